"""What an object is made of: parts to look at, colliders to touch. Knows nothing of MuJoCo."""

from collections.abc import Callable
from dataclasses import dataclass, replace
from typing import Literal

import numpy as np
import numpy.typing as npt

from w2c.geometry import Vector
from w2c_sim_robot.scenes.objects.palette import Colour

Texture = npt.NDArray[np.uint8]
Points = npt.NDArray[np.float64]
Indices = npt.NDArray[np.int32]
Size = tuple[float, float, float]


@dataclass(frozen=True)
class Mesh:
    """Triangles with a normal and a texture coordinate at each vertex."""

    vertices: Points
    """(n, 3) in the object's frame [m]"""
    normals: Points
    """(n, 3) unit"""
    texcoords: Points
    """(n, 2), (0, 0) = first row and column of the texture"""
    faces: Indices
    """(m, 3) counter-clockwise seen from outside"""

    def moved(self, offset: tuple[float, float, float]) -> "Mesh":
        """Return the mesh shifted by `offset` [m]."""
        return Mesh(self.vertices + np.asarray(offset), self.normals, self.texcoords, self.faces)

    def rotated(self, rotation: npt.NDArray[np.float64]) -> "Mesh":
        """Return the mesh turned about the origin by a (3, 3) rotation."""
        return Mesh(
            self.vertices @ rotation.T, self.normals @ rotation.T, self.texcoords, self.faces
        )


def merged(*meshes: Mesh) -> Mesh:
    """Return one mesh of several."""
    starts = np.cumsum([0] + [len(mesh.vertices) for mesh in meshes[:-1]])
    return Mesh(
        np.vstack([mesh.vertices for mesh in meshes]),
        np.vstack([mesh.normals for mesh in meshes]),
        np.vstack([mesh.texcoords for mesh in meshes]),
        np.vstack([mesh.faces + start for mesh, start in zip(meshes, starts, strict=True)]).astype(
            np.int32
        ),
    )


@dataclass(frozen=True)
class Surface:
    """How a part looks. Its colour multiplies its texture, so that an object can be repainted."""

    paint: Literal["main", "accent"] | Colour = "main"
    """The object's colour, the colour of its print, or one of its own"""
    texture: Texture | None = None
    """(h, w, 3), first row at the top; None = plain"""
    gloss: float = 0.25
    """0 = chalk, 1 = polished"""
    opacity: float = 1.0
    """Below 1 what is behind shines through; depth cameras see the surface all the same"""


@dataclass(frozen=True)
class Part:
    """One mesh of one look."""

    mesh: Mesh
    surface: Surface
    name: str = ""
    """What people call this part: handle, lid ...; empty where it has no name of its own"""
    material: str = ""
    """Of this part, where a person would say it: the wooden handle of a mallet"""


@dataclass(frozen=True)
class Collider:
    """A convex solid that physics knows."""

    shape: Literal["box", "cylinder", "sphere", "capsule"]
    size: tuple[float, ...]
    """Half extents (box), radius and half length along z (cylinder, capsule), radius (sphere)
    [m]"""
    position: tuple[float, float, float]
    """Of its centre in the object's frame [m]"""


@dataclass(frozen=True)
class Shape:
    """An object without its place: seen through its parts, touched through its colliders."""

    parts: tuple[Part, ...]
    colliders: tuple[Collider, ...]


def fitted(size: Size, parts: tuple[Part, ...], colliders: tuple[Collider, ...]) -> Shape:
    """Return a shape drawn in any place and scale, moved and stretched to fill `size` [m].

    What can be seen then stands on the origin, and its extents are `size`. Colliders go along;
    round ones stay round, with the smaller of the two sideways scales.
    """
    low, high = bounds(Shape(parts, ()))
    scale = np.asarray(size) / np.maximum(high - low, 1e-9)
    origin = np.array([*(low + high)[:2] / 2, low[2]])
    across = float(min(scale[0], scale[1]))
    moved = []
    for part in parts:
        normals = part.mesh.normals / scale
        normals = normals / np.linalg.norm(normals, axis=1, keepdims=True)
        vertices = (part.mesh.vertices - origin) * scale
        mesh = Mesh(vertices, normals, part.mesh.texcoords, part.mesh.faces)
        moved.append(replace(part, mesh=mesh))
    solids = []
    for collider in colliders:
        x, y, z = ((np.asarray(collider.position) - origin) * scale).tolist()
        if collider.shape == "box":
            extents = tuple((np.asarray(collider.size) * scale).tolist())
        elif collider.shape == "sphere":
            extents = (collider.size[0] * float(scale.min()),)
        else:
            extents = (collider.size[0] * across, collider.size[1] * float(scale[2]))
        solids.append(Collider(collider.shape, extents, (x, y, z)))
    return Shape(tuple(moved), tuple(solids))


Builder = Callable[[Size, np.random.Generator], Shape]
"""Makes a shape of a size [m]; the generator chooses its print, grain and pattern."""


def box_collider(size: Size) -> Collider:
    """Return the collider that fills the extents of an object."""
    return Collider("box", (size[0] / 2, size[1] / 2, size[2] / 2), (0.0, 0.0, size[2] / 2))


def cylinder_collider(size: Size) -> Collider:
    """Return the upright cylinder that fills the extents of an object."""
    radius = min(size[0], size[1]) / 2
    return Collider("cylinder", (radius, size[2] / 2), (0.0, 0.0, size[2] / 2))


def bounds(shape: Shape) -> tuple[Vector, Vector]:
    """Return the lowest and the highest corner (3,) of everything that can be seen [m]."""
    vertices = np.vstack([part.mesh.vertices for part in shape.parts])
    return vertices.min(axis=0), vertices.max(axis=0)
