"""A picture with depth as coloured points of the world: cropped to a box, one point a voxel."""

from dataclasses import dataclass

import cv2
import numpy as np
import numpy.typing as npt

from w2c.errors import MessageError, RefusedError
from w2c.geometry import Intrinsics, Matrix, apply, inverse
from w2c_perception.registration import pixels_of, within
from w2c_perception.window import DepthPicture

Colours = npt.NDArray[np.uint8]

DENSER = 2.0
"""Pixels are thinned until so many are in a row of a voxel, at the nearest depth"""


@dataclass(frozen=True)
class Cloud:
    """Coloured points."""

    points: npt.NDArray[np.float32]
    """(n, 3) in the world [m]"""
    colours: Colours
    """(n, 3) red, green, blue"""


@dataclass(frozen=True)
class Box:
    """A part of the world, its sides along the axes."""

    low: tuple[float, float, float]
    high: tuple[float, float, float]
    """Opposite corners [m]"""


def decode_colours(jpeg: bytes, width: int, height: int) -> Colours:
    """Return the colours (h, w, 3) of a JPEG.

    Raises:
        MessageError: the bytes are not a JPEG of this size.
    """
    encoded = np.frombuffer(jpeg, np.uint8)
    picture = cv2.imdecode(encoded, cv2.IMREAD_COLOR) if encoded.size else None
    if picture is None:
        raise MessageError(f"{len(jpeg)} bytes are no JPEG")
    if picture.shape != (height, width, 3):
        raise MessageError(
            f"the JPEG is {picture.shape[1]}x{picture.shape[0]} px, the frame says {width}x{height}"
        )
    return np.asarray(cv2.cvtColor(picture, cv2.COLOR_BGR2RGB))


def point_cloud(
    depth: DepthPicture,
    colours: Colours,
    intrinsics: Intrinsics,
    world_from_camera: Matrix,
    box: Box,
    *,
    voxel: float,
    most: int,
    depth_from_colours: Matrix | None = None,
) -> Cloud:
    """Return what is seen in a box: the mean point and the mean colour of each voxel.

    Args:
        depth: (h, w) z-depth [m], 0 = unknown.
        colours: (h, w, 3) red, green, blue.
        intrinsics: of the picture.
        world_from_camera: (4, 4).
        box: what is wanted.
        voxel: side of a voxel [m].
        most: points that are allowed.
        depth_from_colours: (4, 4) from the camera when it took the colours to when it took depth,
            `world_from_camera`; None: at once. Points beside the colours are left out then.

    Raises:
        RefusedError: there would be more.
    """
    whole = depth[:]
    known = whole[whole > 0.0]
    if not known.size:
        return _means(np.zeros((0, 3)), np.zeros((0, 3)), np.zeros((0, 3), np.int64))
    spacing = float(known.min()) / intrinsics.fx
    stride = max(1, int(voxel / (DENSER * spacing)))
    thinned = whole[::stride, ::stride]
    rows, columns = np.nonzero(thinned > 0.0)
    z = thinned[rows, columns].astype(np.float64)
    along = intrinsics.rays(columns * stride + 0.5, rows * stride + 0.5)
    in_camera = z[:, None] * along
    points = apply(world_from_camera, in_camera)
    inside = ((points >= box.low) & (points < box.high)).all(axis=1)
    rows, columns = rows * stride, columns * stride
    if depth_from_colours is not None:
        in_colours = apply(inverse(depth_from_colours), in_camera)
        pixels = pixels_of(intrinsics, in_colours)
        inside &= within(pixels, depth)
        columns, rows = np.where(inside[:, None], pixels, 0.0).astype(np.intp).T
    points = points[inside]
    seen = colours[rows[inside], columns[inside]].astype(np.float64)
    cells = np.floor((points - np.asarray(box.low)) / voxel).astype(np.int64)
    cloud = _means(points, seen, cells)
    if len(cloud.points) > most:
        wider = voxel * float(np.sqrt(len(cloud.points) / most))
        raise RefusedError(
            f"{len(cloud.points)} points, limit {most}: choose a voxel of {1.1 * wider:.3f} m or "
            "a smaller box"
        )
    return cloud


def _means(
    points: npt.NDArray[np.float64],
    colours: npt.NDArray[np.float64],
    cells: npt.NDArray[np.int64],
) -> Cloud:
    """Return the mean point and colour of those (n, 3) that share a cell (n, 3)."""
    if not len(points):
        return Cloud(np.zeros((0, 3), np.float32), np.zeros((0, 3), np.uint8))
    extents = cells.max(axis=0) + 1
    index = (cells[:, 0] * extents[1] + cells[:, 1]) * extents[2] + cells[:, 2]
    _, which, counts = np.unique(index, return_inverse=True, return_counts=True)
    sums = [
        np.bincount(which, weights=column, minlength=len(counts))
        for column in (*points.T, *colours.T)
    ]
    means = np.stack(sums, axis=-1) / counts[:, None]
    return Cloud(means[:, :3].astype(np.float32), np.rint(means[:, 3:]).astype(np.uint8))
