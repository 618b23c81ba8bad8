"""What the evaluation needs of a witness of the simulation, and where the witness sees a place."""

from collections.abc import Sequence
from dataclasses import dataclass
from typing import Any, Protocol

from w2c.geometry import Intrinsics, Matrix, Vector
from w2c.messages import Array
from w2c_evaluation.scenarios.scenario import Place
from w2c_evaluation.scenarios.sight import Circle, Pixel, draw_circle


class Surface(Protocol):
    """The first visible surface behind a pixel."""

    @property
    def owner(self) -> str:
        """Name of the object."""

    @property
    def point(self) -> Vector:
        """(3,) in the world [m]."""

    @property
    def normal(self) -> Vector:
        """(3,) towards the camera."""


class Touching(Protocol):
    """Two bodies that touch."""

    @property
    def first(self) -> str:
        """A link of the robot, where one takes part."""

    @property
    def second(self) -> str:
        """The other body."""

    @property
    def depth(self) -> float:
        """How far they overlap [m]."""


class Witness(Protocol):
    """The world as it is at one moment: `w2c_sim_robot.witness.Witness`."""

    @property
    def effectors(self) -> dict[str, int]:
        """Links of feet and hands, and which they belong to."""

    @property
    def links(self) -> frozenset[str]:
        """Links of the robot."""

    @property
    def objects(self) -> Sequence[Any]:
        """Things of the scene."""

    @property
    def size(self) -> tuple[int, int]:
        """Width and height of the picture [px]."""

    @property
    def intrinsics(self) -> Intrinsics:
        """Of the head camera."""

    def pose(self, generalized_position: Array) -> None:
        """Go to a moment."""

    def world_from_object(self, name: str) -> Matrix:
        """Return the (4, 4) pose of a thing."""

    def world_from_camera(self) -> Matrix:
        """Return the (4, 4) pose of the optical frame."""

    def project(self, point: Vector) -> Pixel | None:
        """Return the pixel of a point (3,) of the world."""

    def surface(self, u: float, v: float) -> Surface | None:
        """Return what a pixel shows."""

    def owners(self, pixels: Array) -> list[str]:
        """Return what pixels (n, 2) show."""

    def contacts(self) -> Sequence[Touching]:
        """Return who touches whom."""


@dataclass(frozen=True)
class Wanted:
    """A place as it is in the world at one moment."""

    point: Vector
    """(3,) on the surface [m]"""
    normal: Vector
    owner: str
    """Whose surface is seen there"""


def find_place(witness: Witness, place: Place) -> Wanted | None:
    """Return where a place is seen to be; None where something hides it."""
    thing = next(item for item in witness.objects if item.name == place.thing)
    aim = place.aim(witness.world_from_object(place.thing), thing.size)
    pixel = witness.project(aim)
    surface = None if pixel is None else witness.surface(*pixel)
    if surface is None or surface.owner not in place.surfaces:
        return None
    return Wanted(surface.point, surface.normal, surface.owner)


def circle_of(witness: Witness, wanted: Wanted) -> Circle:
    """Return the wanted place as the operator sees it. Raises GeometryError."""
    return draw_circle(wanted.point, wanted.normal, witness.world_from_camera(), witness.intrinsics)
