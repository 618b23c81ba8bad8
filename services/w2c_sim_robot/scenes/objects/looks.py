"""Whether a look at two of a kind tells what each is made of."""

from dataclasses import dataclass
from functools import cache

import cv2
import numpy as np

from w2c_sim_robot.scenes.objects.catalogue import KINDS, make_object, shape_of
from w2c_sim_robot.scenes.objects.materials import PRINTED
from w2c_sim_robot.scenes.objects.meshes import triangle_areas
from w2c_sim_robot.scenes.objects.shape import Texture

AFAR = 64
"""Texture at the distance of a robot's hands: finer grain is not seen [texels across]"""
SEEN = 0.025
"""Contrast (standard deviation, of white) from which people see that there is a pattern"""
PLAIN = 0.04
"""Contrast of a pattern that people see at a glance; one of less tells nothing from what has none
or less still"""
OTHER = 0.015
"""Contrasts that differ by less look alike, unless both are patterns"""
OTHER_OPACITY = 0.2
_NOWHERE = (0.0, 0.0, 0.0)


@dataclass(frozen=True)
class Look:
    """What is seen of a material."""

    contrast: float
    """Of the patterns that are painted in the thing's own colour, of white: mean over its surface.
    What is printed tells what the thing is, not what it is made of"""
    opacity: float


def tells_apart(kind: str, one: str, other: str, *colours: str) -> bool:
    """Return whether people who see two of a kind can tell which of them is of which material.

    A plate of ceramic looks like one of plastic; one of wood has a grain. The slats of a crate are
    too narrow for one. On black nothing is seen.

    Args:
        kind: Of both.
        one: A material.
        other: A material.
        colours: Of the two, where they are known.
    """
    if one == other or "black" in colours:
        return False
    a, b = look_of(kind, one), look_of(kind, other)
    if abs(a.opacity - b.opacity) >= OTHER_OPACITY:
        return True
    weaker, stronger = sorted((a.contrast, b.contrast))
    return stronger >= PLAIN and (stronger - weaker >= OTHER or weaker >= SEEN)


def lookalikes(kind: str, material: str, colour: str) -> tuple[str, ...]:
    """Return the other materials of which a thing might be, as far as people see."""
    return tuple(
        other
        for other in KINDS[kind].materials
        if other != material and not tells_apart(kind, material, other, colour)
    )


@cache
def look_of(kind: str, material: str) -> Look:
    """Return the look of a kind of thing that is made of a material."""
    item = make_object(kind, KINDS[kind].colours[0], _NOWHERE, material=material)
    parts = [part for part in shape_of(item).parts if part.surface.paint == "main"]
    areas = [float(triangle_areas(part.mesh.vertices, part.mesh.faces).sum()) for part in parts]
    contrasts = [0.0 if part.name in PRINTED else _contrast(part.surface.texture) for part in parts]
    return Look(
        float(np.average(contrasts, weights=areas)) if parts else 0.0,
        min((part.surface.opacity for part in parts), default=1.0),
    )


def _contrast(texture: Texture | None) -> float:
    if texture is None:
        return 0.0
    grey = texture.astype(np.float32).mean(axis=2)
    return float(cv2.resize(grey, (AFAR, AFAR), interpolation=cv2.INTER_AREA).std()) / 255.0
