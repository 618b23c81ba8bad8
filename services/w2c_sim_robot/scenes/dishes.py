"""Plates as a dish rack holds them: nearly upright, one behind the other."""

import msgspec
import numpy as np

from w2c_sim_robot.scenes.objects.appliances import RACK_FLOOR
from w2c_sim_robot.scenes.objects.catalogue import make_object
from w2c_sim_robot.scenes.objects.shape import Size
from w2c_sim_robot.scenes.scene import Quaternion, SceneObject

LEAN = np.radians(-72.0)
"""Of a plate about y: its upper side looks at the robot"""
_TILTED: Quaternion = (0.0, float(np.sin(LEAN / 2)), 0.0, float(np.cos(LEAN / 2)))


def standing_plate(
    name: str,
    colour: str,
    place: tuple[float, float],
    rack_foot: float,
    *,
    size: Size,
    variant: int,
    material: str | None = None,
) -> SceneObject:
    """Return a plate that stands in a rack, its middle over `place`; lengths in m.

    Args:
        name: Of the object.
        colour: Of the palette.
        place: x and y of its middle.
        rack_foot: Height of what the rack stands on.
        size: Of the plate, lying.
        variant: Of its print.
        material: The usual one where it is None.
    """
    rest = rack_foot + RACK_FLOOR + size[0] / 2 * float(abs(np.sin(LEAN)))
    lying = make_object(
        "plate",
        colour,
        (*place, rest),
        name=name,
        size=size,
        variant=variant,
        movable=False,
        material=material,
    )
    return msgspec.structs.replace(lying, orientation=_TILTED)
