"""Meshes by construction: boxes, prisms, turned profiles, bent tubes, draped sheets."""

from collections.abc import Sequence

import numpy as np
import numpy.typing as npt

from w2c.geometry import unit
from w2c_sim_robot.scenes.objects.shape import Indices, Mesh, Points, Size, merged

Profile = Sequence[Sequence[float] | Points] | Points
SEGMENTS = 40
CREASE = np.cos(np.radians(35.0))
"""Edges sharper than this stay edges; flatter ones are shaded as a curve."""

_FACES = {
    "+x": (0, 1.0),
    "-x": (0, -1.0),
    "+y": (1, 1.0),
    "-y": (1, -1.0),
    "+z": (2, 1.0),
    "-z": (2, -1.0),
}
ALL_FACES = tuple(_FACES)


def box(size: Size, faces: tuple[str, ...] = ALL_FACES) -> Mesh:
    """Return chosen faces of a box that stands on the origin; each shows the whole texture.

    On the upper side the texture's top is at +x, away from the robot; on the others it is at +z.
    """
    vertices, normals, texcoords, triangles = [], [], [], []
    half = np.asarray(size) / 2
    centre = np.array([0.0, 0.0, half[2]])
    for number, name in enumerate(faces):
        axis, sign = _FACES[name]
        normal = np.zeros(3)
        normal[axis] = sign
        up = np.array([1.0, 0.0, 0.0]) if axis == 2 else np.array([0.0, 0.0, 1.0])
        right = np.cross(up, normal)
        for s, t in ((-1, -1), (1, -1), (1, 1), (-1, 1)):
            vertices.append(centre + half * (normal + s * right + t * up))
            normals.append(normal)
            texcoords.append(((s + 1) / 2, (1 - t) / 2))
        triangles += [
            [4 * number, 4 * number + 1, 4 * number + 2],
            [4 * number, 4 * number + 2, 4 * number + 3],
        ]
    return _mesh(vertices, normals, texcoords, triangles)


def rounded_rectangle(width: float, depth: float, radius: float, steps: int = 6) -> Points:
    """Return the counter-clockwise outline (k, 2) of a rectangle with round corners."""
    radius = min(radius, width / 2 - 1e-4, depth / 2 - 1e-4)
    corners = []
    for quarter, (x, y) in enumerate(((1, 1), (-1, 1), (-1, -1), (1, -1))):
        angles = np.linspace(quarter, quarter + 1, steps) * np.pi / 2
        centre = np.array([x * (width / 2 - radius), y * (depth / 2 - radius)])
        corners.append(centre + radius * np.column_stack([np.cos(angles), np.sin(angles)]))
    return np.vstack(corners)


def prism(outline: Points, height: float, bevel: float = 0.0, caps: bool = True) -> Mesh:
    """Return a solid of a convex outline (k, 2) that stands on the origin, its rims bevelled.

    The caps show the texture seen from above with its top at +x, the side shows it wrapped around.
    """
    low, high = outline.min(axis=0), outline.max(axis=0)
    inner = outline * (1.0 - 2.0 * bevel / (high - low))
    rings = [(inner, 0.0), (outline, bevel), (outline, height - bevel), (inner, height)]
    if bevel <= 0.0:
        rings = [(outline, 0.0), (outline, height)]
    closed = [np.vstack([points, points[:1]]) for points, _ in rings]
    around = np.linspace(0.0, 1.0, len(outline) + 1)
    vertices = [
        np.column_stack([points, np.full(len(points), z)])
        for points, (_, z) in zip(closed, rings, strict=True)
    ]
    along = np.roll(closed[0][:-1], -1, axis=0) - np.roll(closed[0][:-1], 1, axis=0)
    outwards = np.column_stack([along[:, 1], -along[:, 0]])
    outwards = outwards / np.linalg.norm(outwards, axis=1, keepdims=True)
    outwards = np.vstack([outwards, outwards[:1]])
    tilts = [0.0, 0.0] if bevel <= 0.0 else [-0.7, -0.25, 0.25, 0.7]
    normals = [_unit(np.column_stack([outwards, np.full(len(outwards), tilt)])) for tilt in tilts]
    texcoords = [
        np.column_stack([around, np.full(len(around), 1.0 - z / height)]) for _, z in rings
    ]
    side = strips(vertices, normals, texcoords)
    if not caps:
        return side
    return merged(side, _cap(rings[-1][0], height, 1.0), _cap(rings[0][0], 0.0, -1.0))


def _cap(outline: Points, z: float, sign: float) -> Mesh:
    """Return the flat lid of a convex outline, facing up (sign 1) or down (-1)."""
    low, high = outline.min(axis=0), outline.max(axis=0)
    uv = (outline - low) / (high - low)
    texcoords = np.column_stack([1.0 - uv[:, 1], 1.0 - uv[:, 0]])
    count = len(outline)
    fan = np.column_stack(
        [np.zeros(count - 2), np.arange(1, count - 1), np.arange(2, count)]
    ).astype(np.int32)
    if sign < 0:
        fan = fan[:, ::-1]
    vertices = np.column_stack([outline, np.full(count, z)])
    return _mesh(vertices, np.tile([0.0, 0.0, sign], (count, 1)), texcoords, fan)


def lathe(
    profile: Profile, segments: int = SEGMENTS, scale: tuple[float, float] = (1.0, 1.0)
) -> Mesh:
    """Return the surface that a profile (k, 2) of (radius, height) [m] sweeps around the z axis.

    Going along the profile the outside is on the right-hand side: from the foot upwards, outside
    the body. The texture is wrapped around, its top at the end of the profile. `scale` widens
    along x and y.
    """
    points = np.asarray(profile, dtype=np.float64)
    steps = np.diff(points, axis=0)  # (k-1, 2)
    lengths = np.linalg.norm(steps, axis=1)
    points = points[np.concatenate([[True], lengths > 1e-9])]
    steps = np.diff(points, axis=0)
    lengths = np.linalg.norm(steps, axis=1)
    flat = np.column_stack([steps[:, 1], -steps[:, 0]]) / lengths[:, None]
    share = 1.0 - np.concatenate([[0.0], np.cumsum(lengths)]) / lengths.sum()
    meshes = []
    for i in range(len(steps)):
        start, end = flat[i], flat[i]
        if i > 0 and flat[i] @ flat[i - 1] > CREASE:
            start = flat[i] + flat[i - 1]
        if i + 1 < len(steps) and flat[i] @ flat[i + 1] > CREASE:
            end = flat[i] + flat[i + 1]
        meshes.append(
            _band(points[i : i + 2], np.array([start, end]), share[i : i + 2], segments, scale)
        )
    return merged(*meshes)


def _band(
    points: Points, normals: Points, share: Points, segments: int, scale: tuple[float, float]
) -> Mesh:
    """Return one ring of a turned surface."""
    angle = np.linspace(0.0, 2.0 * np.pi, segments + 1) + np.pi
    wide, deep = scale
    vertices, directions, texcoords = [], [], []
    for (radius, z), (outwards, upwards), v in zip(points, normals, share, strict=True):
        vertices.append(
            np.column_stack(
                [
                    wide * radius * np.cos(angle),
                    deep * radius * np.sin(angle),
                    np.full(segments + 1, z),
                ]
            )
        )
        normal = np.column_stack(
            [
                outwards * np.cos(angle) / wide,
                outwards * np.sin(angle) / deep,
                np.full(segments + 1, upwards),
            ]
        )
        directions.append(_unit(normal))
        texcoords.append(
            np.column_stack([np.linspace(0.0, 1.0, segments + 1), np.full(segments + 1, v)])
        )
    return strips(vertices, directions, texcoords)


def tube(path: Profile, radius: float | Points, sides: int = 12, flatten: float = 1.0) -> Mesh:
    """Return a bent rod along a path (k, 3) [m]; `flatten` makes it oval.

    `radius` [m] is one number, or (k,).
    """
    points = np.asarray(path, dtype=np.float64)
    radii = np.broadcast_to(np.asarray(radius, dtype=np.float64), (len(points),))
    tangents = _unit(np.gradient(points, axis=0))
    reference = (
        np.array([0.0, 0.0, 1.0]) if abs(tangents[:, 2]).mean() < 0.7 else np.array([0.0, 1.0, 0.0])
    )
    vertices, normals, texcoords = [], [], []
    angle = np.linspace(0.0, 2.0 * np.pi, sides + 1)
    first = unit(np.cross(reference, tangents[0]))
    for number, (point, tangent) in enumerate(zip(points, tangents, strict=True)):
        first = unit(first - float(first @ tangent) * tangent)
        second = np.cross(tangent, first)
        ring = np.cos(angle)[:, None] * first * flatten + np.sin(angle)[:, None] * second
        vertices.append(point + radii[number] * ring)
        normals.append(_unit(ring))
        share = np.full(sides + 1, number / (len(points) - 1))
        texcoords.append(np.column_stack([np.linspace(0, 1, sides + 1), share]))
    return strips(vertices, normals, texcoords)


def sheet(heights: Points, size: Size) -> Mesh:
    """Return both sides of a draped sheet of these heights [m]; rows along x, columns along y."""
    rows, columns = heights.shape
    x = np.linspace(-size[0] / 2, size[0] / 2, rows)
    y = np.linspace(-size[1] / 2, size[1] / 2, columns)
    slope_x = np.gradient(heights, x, axis=0)
    slope_y = np.gradient(heights, y, axis=1)
    grid_x, grid_y = np.meshgrid(x, y, indexing="ij")
    vertices = [
        np.column_stack([grid_x[:, j], grid_y[:, j], heights[:, j]]) for j in range(columns)
    ]
    normals = [
        _unit(np.column_stack([-slope_x[:, j], -slope_y[:, j], np.ones(rows)]))
        for j in range(columns)
    ]
    v = 1.0 - np.linspace(0.0, 1.0, rows)
    texcoords = [
        np.column_stack([np.full(rows, 1.0 - j / (columns - 1)), v]) for j in range(columns)
    ]
    upper = strips(vertices, normals, texcoords)
    lower = Mesh(
        upper.vertices - [0.0, 0.0, 1e-3], -upper.normals, upper.texcoords, upper.faces[:, ::-1]
    )
    return merged(upper, lower)


def arc(
    centre: tuple[float, float, float],
    radii: tuple[float, float],
    start: float,
    end: float,
    count: int = 20,
) -> Points:
    """Return points (count, 3) of an ellipse in the x-z plane, angles [rad] from +x towards +z."""
    angle = np.linspace(start, end, count)
    path = np.column_stack([radii[0] * np.cos(angle), np.zeros(count), radii[1] * np.sin(angle)])
    return np.asarray(path + np.asarray(centre))


def strips(vertices: list[Points], normals: list[Points], texcoords: list[Points]) -> Mesh:
    """Return the quads between consecutive rows of equally many points, as triangles."""
    rows, count = len(vertices), len(vertices[0])
    index = np.arange(rows * count).reshape(rows, count)
    a, b = index[:-1, :-1].ravel(), index[:-1, 1:].ravel()
    c, d = index[1:, 1:].ravel(), index[1:, :-1].ravel()
    faces = np.vstack([np.column_stack([a, b, c]), np.column_stack([a, c, d])])
    return _mesh(np.vstack(vertices), np.vstack(normals), np.vstack(texcoords), faces)


def _unit(rows: Points) -> Points:
    """Return the rows scaled to length 1."""
    return np.asarray(rows / np.maximum(np.linalg.norm(rows, axis=1, keepdims=True), 1e-12))


def triangle_areas(points: Points, triangles: Indices) -> Points:
    """Return the area (m,) of triangles (m, 3) between points (n, 3)."""
    a, b, c = (points[triangles[:, corner]] for corner in range(3))
    return np.asarray(0.5 * np.linalg.norm(np.cross(b - a, c - a), axis=1))


def _mesh(
    vertices: npt.ArrayLike, normals: npt.ArrayLike, texcoords: npt.ArrayLike, faces: npt.ArrayLike
) -> Mesh:
    """Return a mesh with the triangles that have an area: MuJoCo refuses the others."""
    points = np.asarray(vertices, dtype=np.float64)
    triangles = np.asarray(faces, dtype=np.int32)
    return Mesh(
        points,
        np.asarray(normals, dtype=np.float64),
        np.asarray(texcoords, dtype=np.float64),
        triangles[triangle_areas(points, triangles) > 0.5e-12],
    )
