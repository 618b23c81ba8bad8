"""What the evaluation needs of a witness of the simulation, and where the witness sees a place."""

from collections.abc import Sequence
from dataclasses import dataclass
from typing import Any, Protocol

import numpy as np

from w2c.geometry import Intrinsics, Matrix, Vector
from w2c.messages import Array
from w2c_evaluation.scenarios.scenario import Place
from w2c_evaluation.scenarios.sight import Circle, Pixel, draw_circle

EDGE_WINDOW_PX = 2
EDGE_LEAST_PX = 5
EDGE_STEP_M = 0.012
"""What is nearer by more, in so many of the pixels around, is another surface, in front"""


PATCH_PX, PATCH_STEP_PX = 9, 3
PATCH_M = 0.02
PATCH_LEAST = 9
"""Points around, in pixels and metres, that make a plane"""
ALIKE = 0.9
"""Cosine between normals of one face"""


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
    faces: tuple[Vector, ...] = ()
    """Normals (3,) of the faces that meet within a fingertip: at an edge, there are two"""


def find_place(witness: Witness, place: Place) -> Wanted | None:
    """Return where a place is seen to be; None where something hides it.

    At an edge, the surface in front is meant, as for everybody who points there: of an open box,
    its rim and not what is seen beside it within.
    """
    thing = next(item for item in witness.objects if item.name == place.thing)
    aim = place.aim(witness.world_from_object(place.thing), thing.size)
    pixel = witness.project(aim)
    surface = None if pixel is None else witness.surface(*pixel)
    if pixel is None or surface is None or surface.owner not in place.surfaces:
        return None
    front = _in_front(witness, pixel, surface, place.surfaces)
    normal, *faces = _normals(witness, pixel, front)
    return Wanted(front.point, normal, front.owner, tuple(faces))


def _normals(witness: Witness, pixel: Pixel, surface: Surface) -> tuple[Vector, ...]:
    """Return the normals (3,) of what is seen within a fingertip around a surface's point.

    The first is that of all of it: of a heap of nails, that of the heap, not of the nail that a ray
    happens to meet. The others are of the faces that meet there, such as the front of a box and
    its top: who points at the edge means the one as much as the other.
    """
    steps = range(-PATCH_PX, PATCH_PX + 1, PATCH_STEP_PX)
    seen = (witness.surface(pixel[0] + du, pixel[1] + dv) for du in steps for dv in steps)
    near = [
        one
        for one in seen
        if one is not None
        and one.owner == surface.owner
        and float(np.linalg.norm(one.point - surface.point)) < PATCH_M
    ]
    if len(near) < PATCH_LEAST:
        return (surface.normal,)
    towards = witness.world_from_camera()[:3, 3] - surface.point
    faces = [_plane_normal(face, towards) for face in _faces(near) if len(face) >= PATCH_LEAST]
    return (_plane_normal(near, towards), *faces)


def _faces(seen: Sequence[Surface]) -> list[list[Surface]]:
    """Return surfaces that face alike together."""
    faces: list[list[Surface]] = []
    for one in seen:
        face = next((face for face in faces if float(face[0].normal @ one.normal) > ALIKE), None)
        if face is None:
            faces.append([one])
        else:
            face.append(one)
    return faces


def _plane_normal(seen: Sequence[Surface], towards: Vector) -> Vector:
    """Return the normal (3,) of the plane through the points of surfaces, on the side `towards`."""
    points = np.array([one.point for one in seen])
    normal: Vector = np.linalg.svd(points - points.mean(axis=0))[2][2]
    return normal if float(normal @ towards) > 0.0 else -normal


def _in_front(witness: Witness, pixel: Pixel, surface: Surface, surfaces: Sequence[str]) -> Surface:
    """Return the nearest of these objects' surfaces within two pixels that is not just a speck."""
    eye = witness.world_from_camera()[:3, 3]
    limit = float(np.linalg.norm(surface.point - eye)) - EDGE_STEP_M
    steps = range(-EDGE_WINDOW_PX, EDGE_WINDOW_PX + 1)
    found = []
    for du, dv in ((du, dv) for du in steps for dv in steps):
        beside = witness.surface(pixel[0] + du, pixel[1] + dv)
        if beside is None or beside.owner not in surfaces:
            continue
        if float(np.linalg.norm(beside.point - eye)) < limit:
            found.append((du * du + dv * dv, beside))
    if len(found) < EDGE_LEAST_PX:
        return surface
    return min(found, key=lambda pair: pair[0])[1]


def circle_of(witness: Witness, wanted: Wanted) -> Circle:
    """Return the wanted place as the operator sees it. Raises GeometryError."""
    return draw_circle(wanted.point, wanted.normal, witness.world_from_camera(), witness.intrinsics)
