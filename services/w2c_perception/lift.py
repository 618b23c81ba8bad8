"""From a pixel with depth to a point on a surface: what a hand would touch there.

Which surface is meant, how noisy depth is there, and the largest smooth piece around the pixel that
this noise does not contradict: its value and its slope at the pixel are the answer. Points of
another surface behind an edge have no say: the answer is never the mean of two.
"""

from dataclasses import dataclass

import numpy as np

from w2c.errors import RefusedError
from w2c.geometry import Intrinsics, Matrix, Vector, apply
from w2c_perception.growing import Piece, grow
from w2c_perception.surroundings import look_around
from w2c_perception.window import SMALLEST_NOISE, DepthPicture, Seed, find_seed, noise, samples

COVERS = 2.0
"""Standard deviations of the noise's share of the error bound"""
BY_CHANCE = 1.2
"""Variances of the noise that a fit leaves over where nothing is wrong with it"""
OUTLIER = 0.012
"""What is further from the plane than this is another thing, not roughness [m]"""
MAX_BLUR = 16.0
"""The camera moved by more between colour and depth: nobody knows what the pixel showed [px]"""


@dataclass(frozen=True)
class Surface:
    """What is known around a point, in the world."""

    point: Vector
    """(3,) [m]"""
    normal: Vector
    """(3,) unit, towards the camera"""
    error_bound: float
    """Of the point, for a camera that is where it is thought to be [m]"""
    flatness: float
    """Root mean square distance of the surface to its plane inside the footprint, without the
    noise of depth [m]"""
    slope: float
    """Between normal and vertical [rad]"""
    extent: float
    """Radius of the flat surface that is seen all around the point [m]"""
    edge_distance: float
    """To the nearest place where the surface ends [m]; 0.25 where none is nearer"""
    warning: str


def lift(
    depth: DepthPicture,
    intrinsics: Intrinsics,
    world_from_camera: Matrix,
    u: float,
    v: float,
    *,
    footprint: float = 0.03,
    depth_unit: float = 0.00025,
    blur: float = 0.0,
) -> Surface:
    """Return the surface behind a pixel.

    Args:
        depth: (h, w) z-depth [m], 0 = unknown.
        intrinsics: of the camera.
        world_from_camera: (4, 4) when the picture was taken.
        u: to the right [px].
        v: down [px].
        footprint: radius of what will touch the surface [m].
        depth_unit: smallest step of the depth [m].
        blur: how far the picture may have moved between colour and depth [px].

    Raises:
        RefusedError: outside of the picture, no depth there, too few points around it, or a camera
            that moved too fast.
    """
    check_pixel(depth, u, v)
    _check_blur(blur)
    sigma = noise(depth, u, v, depth_unit)
    seed = find_seed(depth, u, v, intrinsics.fx, sigma)
    piece = grow(depth, seed, intrinsics.fx, footprint, sigma)
    z = _depth_at(piece, seed, footprint)
    point = intrinsics.point_from_pixel(seed.u, seed.v, z)
    normal = piece.patch.normal(seed.u, seed.v, intrinsics)
    around = look_around(depth, intrinsics, point, normal, sigma)
    flatness = _flatness(depth, intrinsics, point, normal, footprint, sigma)
    error = _error_bound(intrinsics, seed, piece, point, normal, sigma, depth_unit)
    error += _blur_error(depth, intrinsics, point, u, v, blur)
    in_world = world_from_camera[:3, :3] @ normal
    slope = float(np.arccos(np.clip(in_world[2], -1.0, 1.0)))
    return Surface(
        point=apply(world_from_camera, point),
        normal=in_world,
        error_bound=float(error),
        flatness=flatness,
        slope=slope,
        extent=around.extent,
        edge_distance=around.edge_distance,
        warning=_warning(seed, blur),
    )


def check_pixel(depth: DepthPicture, u: float, v: float) -> None:
    """Raise RefusedError for a pixel outside of the picture."""
    height, width = depth.shape
    if not (np.isfinite(u) and np.isfinite(v) and 0.0 <= u < width and 0.0 <= v < height):
        raise RefusedError(
            f"pixel ({u:g}, {v:g}) is outside of the picture, {width}x{height} px; choose one in it"
        )


def _check_blur(blur: float) -> None:
    """Raise RefusedError for a camera that moved too far between colours and depth."""
    if not blur <= MAX_BLUR:
        raise RefusedError(
            f"the camera moved by {blur:.0f} px between colour and depth, limit {MAX_BLUR:.0f}; "
            "choose the pixel in a picture that was taken at rest"
        )


def _depth_at(piece: Piece, seed: Seed, footprint: float) -> float:
    """Return the z-depth of the piece at the pixel [m]. Raises RefusedError where it has none."""
    inverse = float(piece.patch.inverse_depth(seed.u, seed.v)[0])
    if inverse <= 0.0 or abs(1.0 / inverse - seed.depth) > max(footprint, 0.1 * seed.depth):
        raise RefusedError(
            f"depth around pixel ({int(seed.u)}, {int(seed.v)}) is no surface; choose another"
        )
    return 1.0 / inverse


def _error_bound(
    intrinsics: Intrinsics,
    seed: Seed,
    piece: Piece,
    point: Vector,
    normal: Vector,
    sigma: float,
    depth_unit: float,
) -> float:
    """Return how far from the point the truth may be [m]."""
    z = float(point[2])
    along = float(np.linalg.norm(point)) / z
    of_noise = COVERS * piece.patch.deviation(seed.u, seed.v) * sigma
    unexplained = float(np.sqrt(max(0.0, piece.misfit**2 - BY_CHANCE))) * sigma
    of_shape = piece.dissent * z * z + unexplained
    # A pixel that was moved sidewards moves along the surface, which is longer where it is steep.
    facing = max(0.1, abs(float(normal @ point)) / float(np.linalg.norm(point)))
    of_moving = seed.moved * z / intrinsics.fx / facing
    return (
        along * (of_noise + of_shape + max(COVERS * SMALLEST_NOISE, 0.5 * depth_unit) + seed.behind)
        + of_moving
    )


def _blur_error(
    depth: DepthPicture, intrinsics: Intrinsics, point: Vector, u: float, v: float, blur: float
) -> float:
    """Return how far away [m] the farthest of the points is that the pixel may have shown."""
    if blur <= 0.0:
        return 0.0
    found = samples(depth, u, v, max(1.0, blur))
    seen = found.z[:, None] * intrinsics.rays(found.u, found.v)
    away = np.linalg.norm(seen - point, axis=1)
    return float(away.max()) if len(away) else 0.0


def _flatness(
    depth: DepthPicture,
    intrinsics: Intrinsics,
    point: Vector,
    normal: Vector,
    footprint: float,
    sigma: float,
) -> float:
    """Return how uneven the surface is inside the footprint [m]."""
    u, v = intrinsics.pixel_from_point(point)
    found = samples(depth, u, v, max(3.0, footprint * intrinsics.fx / float(point[2])))
    along = intrinsics.rays(found.u, found.v)
    facing = along @ normal
    inside = np.linalg.norm(found.z[:, None] * along - point, axis=1) <= footprint
    off = (found.z * facing - float(normal @ point))[inside]
    own = np.abs(off) <= max(OUTLIER, 3.0 * sigma)
    if not own.any():
        return 0.0
    # What the noise of depth adds along the normal is not the surface's.
    added = float(np.mean((sigma * facing[inside][own]) ** 2))
    return float(np.sqrt(max(0.0, float(np.var(off[own])) - added)))


def _warning(seed: Seed, blur: float) -> str:
    """Return what an operator should know of where the point is, or nothing.

    Whether the surface carries anything is not said here: see `fitness`.
    """
    remarks = []
    if seed.moved > 0.0:
        remarks.append("moved to the nearest surface in front")
    if blur >= 1.0:
        remarks.append(f"the camera moved by {blur:.0f} px")
    return "; ".join(remarks)
