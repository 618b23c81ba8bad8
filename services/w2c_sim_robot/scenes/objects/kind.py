"""One row of the catalogue of objects."""

from collections.abc import Mapping
from dataclasses import dataclass, field
from typing import Literal

from w2c_sim_robot.scenes.objects.palette import Colour
from w2c_sim_robot.scenes.objects.shape import Builder, Size
from w2c_sim_robot.scenes.scene import Support

Group = Literal[
    "furniture", "tableware", "food", "books and paper", "tools", "clothes", "office", "bathroom",
    "garden", "industrial", "household",
]  # fmt: skip

MANY = (
    "red",
    "orange",
    "yellow",
    "green",
    "blue",
    "purple",
    "pink",
    "black",
    "grey",
    "white",
    "turquoise",
)
WOODEN = ("brown", "white", "grey", "black")
OAK = (0.68, 0.49, 0.31)


@dataclass(frozen=True)
class Kind:
    """One row of the catalogue."""

    build: Builder
    names: tuple[str, ...]
    """What people call it, the usual word first"""
    material: str
    """What it is usually made of; empty where nobody would say it"""
    size: Size
    """Usual extents [m]"""
    stretch: tuple[float, float, float]
    """How far each extent may differ from the usual, as a share, beside the common scale"""
    colours: tuple[str, ...]
    mass: float
    """Of the usual size [kg]"""
    support: Support
    furniture: bool = False
    """Of a room: carries other things, or is a wall or hangs on one; never moves"""
    tones: Mapping[str, Colour] = field(default_factory=dict)
    """Where this kind has another shade by the same name: a brown table is lighter than brown
    leather"""
    group: Group = "household"
    other_materials: tuple[str, ...] = ()
    """What it may be made of instead"""
    lies: bool = False
    """May lie on its side: round, and as thick as it is wide"""
    floor: bool = False
    """May stand on the floor, too"""
    open_work: bool = False
    """Of wires: what it stands on shows through, yet whoever points between them means this"""

    @property
    def materials(self) -> tuple[str, ...]:
        """Return all that it may be made of, the usual one first."""
        return (self.material, *self.other_materials)
