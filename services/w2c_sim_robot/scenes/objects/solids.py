"""Solids that many things are made of: rods, discs, egg shapes, open walls."""

from typing import Literal

import numpy as np

from w2c.geometry import unit
from w2c_sim_robot.scenes.objects.meshes import (
    SEGMENTS,
    Profile,
    lathe,
    prism,
    rounded_rectangle,
    tube,
)
from w2c_sim_robot.scenes.objects.shape import Collider, Mesh, Points, Size, merged

Axis = Literal["x", "y"]
_TURNS = {
    "x": np.array([[0.0, 0, 1], [0, 1, 0], [-1, 0, 0]]),
    "y": np.array([[1.0, 0, 0], [0, 0, 1], [0, -1, 0]]),
}


def turned(profile: Profile, axis: Axis, segments: int = SEGMENTS) -> Mesh:
    """Return what `lathe` makes, its axis laid along x or y."""
    return lathe(profile, segments).rotated(_TURNS[axis])


def rod(path: Profile, radius: float | Points, sides: int = 12, flatten: float = 1.0) -> Mesh:
    """Return a bent rod as `tube` makes it, its ends closed."""
    points = np.asarray(path, dtype=np.float64)
    radii = np.broadcast_to(np.asarray(radius, dtype=np.float64), (len(points),))
    return merged(
        tube(points, radius, sides, flatten),
        disc(points[0], points[0] - points[1], float(radii[0]), sides),
        disc(points[-1], points[-1] - points[-2], float(radii[-1]), sides),
    )


def polygon(corners: Profile) -> Mesh:
    """Return a flat convex polygon (k, 3), counter-clockwise seen from where it faces.

    The texture is laid over it from above: its top at +x.
    """
    points = np.asarray(corners, dtype=np.float64)
    count = len(points)
    normal = unit(np.cross(points[1] - points[0], points[2] - points[0]))
    fan = [[0, i, i + 1] for i in range(1, count - 1)]
    low = points.min(axis=0)
    extent = np.maximum(points.max(axis=0) - low, 1e-9)
    share = (points - low) / extent
    texcoords = np.column_stack([1.0 - share[:, 1], 1.0 - share[:, 0]])
    return Mesh(points, np.tile(normal, (count, 1)), texcoords, np.array(fan, dtype=np.int32))


def disc(centre: Points, direction: Points, radius: float, sides: int = 12) -> Mesh:
    """Return a flat disc that faces `direction`."""
    normal = unit(direction)
    other = np.array([0.0, 0.0, 1.0]) if abs(normal[2]) < 0.7 else np.array([0.0, 1.0, 0.0])
    first = unit(np.cross(other, normal))
    second = np.cross(normal, first)
    angle = np.linspace(0.0, 2.0 * np.pi, sides, endpoint=False)
    around = np.cos(angle)[:, None] * first + np.sin(angle)[:, None] * second
    vertices = np.vstack([centre, centre + radius * around])
    here = np.arange(1, sides + 1)
    faces = np.column_stack([np.zeros(sides), here, np.roll(here, -1)]).astype(np.int32)
    count = sides + 1
    return Mesh(vertices, np.tile(normal, (count, 1)), np.zeros((count, 2)), faces)


def ellipsoid(radii: Size, low: float = -90.0, high: float = 90.0) -> Mesh:
    """Return an egg shape around the origin between two latitudes [degrees]."""
    angle = np.radians(np.linspace(low, high, 25))
    wide, deep, tall = radii
    profile = np.column_stack([np.maximum(np.cos(angle), 0.0), tall * np.sin(angle)])
    return lathe(profile, scale=(wide, deep))


def slab(x: float, y: float, z: float, radius: float = 0.004, bevel: float = 0.001) -> Mesh:
    """Return a board with round corners that stands on the origin."""
    return prism(rounded_rectangle(x, y, radius), z, bevel)


def open_wall(x: float, y: float, z: float, radius: float, thick: float) -> Mesh:
    """Return a closed wall without floor or lid: outside, inside and rim."""
    outer, inner = (
        rounded_rectangle(x, y, radius),
        rounded_rectangle(x - 2 * thick, y - 2 * thick, radius),
    )
    outside = prism(outer, z, caps=False)
    inwards = prism(inner, z, caps=False)
    inside = Mesh(inwards.vertices, -inwards.normals, inwards.texcoords, inwards.faces[:, ::-1])
    count = len(outer)
    rims = []
    for height, sign in ((z, 1.0), (0.0, -1.0)):
        vertices = np.vstack([outer, inner])
        points = np.column_stack([vertices, np.full(2 * count, height)])
        here = np.arange(count)
        there = (here + 1) % count
        faces = np.vstack(
            [
                np.column_stack([here, there, there + count]),
                np.column_stack([here, there + count, here + count]),
            ]
        )
        faces = faces if sign > 0 else faces[:, ::-1]
        normals = np.tile([0.0, 0.0, sign], (2 * count, 1))
        rims.append(Mesh(points, normals, np.zeros((2 * count, 2)), faces.astype(np.int32)))
    return merged(outside, inside, *rims)


def wall_colliders(size: Size, thick: float) -> tuple[Collider, ...]:
    """Return four upright boards around the extents of an object."""
    x, y, z = size
    sides = [
        Collider("box", (thick / 2, y / 2, z / 2), (s * (x - thick) / 2, 0, z / 2)) for s in (-1, 1)
    ]
    ends = [
        Collider("box", (x / 2, thick / 2, z / 2), (0, s * (y - thick) / 2, z / 2)) for s in (-1, 1)
    ]
    return (*sides, *ends)


def flat_ring(outer: float, inner: float, z: float) -> Mesh:
    """Return a flat ring about z, between two radii, of a height [m]."""
    return merged(
        lathe([[inner, 0], [outer, 0], [outer, z], [inner, z]]), lathe([[inner, z], [inner, 0]])
    )


def about_z(angle: float) -> Points:
    """Return the rotation (3, 3) about z by an angle [rad]."""
    cosine, sine = np.cos(angle), np.sin(angle)
    return np.array([[cosine, -sine, 0.0], [sine, cosine, 0.0], [0.0, 0.0, 1.0]])
