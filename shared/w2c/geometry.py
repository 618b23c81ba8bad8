"""Poses, pixels and frames, said once.

A transform is a (4, 4) matrix named target_from_source: `world_from_camera @ point_in_camera`, the
adjacent
names match. Quaternions are xyzw. Pixels are (u, v), u right, v down, origin top left, the centre
of pixel
(0, 0) at (0.5, 0.5); arrays index [v, u].
"""

from typing import Any, NamedTuple

import numpy as np
import numpy.typing as npt

from w2c.errors import GeometryError

Matrix = npt.NDArray[np.float64]
Vector = npt.NDArray[np.float64]


class Intrinsics(NamedTuple):
    """A pinhole camera without distortion [px]."""

    fx: float
    fy: float
    cx: float
    cy: float

    def pixel_from_point(self, point_in_camera: Vector) -> tuple[float, float]:
        """Project a point (3,) [m] to (u, v). Raises GeometryError for one behind the camera."""
        x, y, z = point_in_camera[:3]
        if z <= 1e-6:
            raise GeometryError(f"point at depth {z:.3f} m is behind the camera")
        return self.fx * x / z + self.cx, self.fy * y / z + self.cy

    def point_from_pixel(self, u: float, v: float, depth: float) -> Vector:
        """Return the point (3,) in the camera frame at this z-depth [m]."""
        return np.array([(u - self.cx) / self.fx * depth, (v - self.cy) / self.fy * depth, depth])

    def rays(self, u: npt.ArrayLike, v: npt.ArrayLike) -> Matrix:
        """Return the rays (..., 3) with z = 1 through pixels (...), in the camera frame."""
        x = (np.asarray(u, dtype=np.float64) - self.cx) / self.fx
        y = (np.asarray(v, dtype=np.float64) - self.cy) / self.fy
        result = np.empty((*x.shape, 3))
        result[..., 0], result[..., 1], result[..., 2] = x, y, 1.0
        return result


def intrinsics_from_fov(width: int, height: int, vertical_fov_rad: float) -> Intrinsics:
    """Return the intrinsics of a camera with square pixels and a centred axis."""
    focal = 0.5 * height / float(np.tan(0.5 * vertical_fov_rad))
    return Intrinsics(focal, focal, 0.5 * width, 0.5 * height)


def transform(rotation: npt.ArrayLike, translation: npt.ArrayLike) -> Matrix:
    """Return the (4, 4) transform of a (3, 3) rotation and a (3,) translation."""
    result = np.eye(4)
    result[:3, :3] = rotation
    result[:3, 3] = translation
    return result


def inverse(target_from_source: Matrix) -> Matrix:
    """Return source_from_target of a rigid transform."""
    rotation = target_from_source[:3, :3].T
    return transform(rotation, -rotation @ target_from_source[:3, 3])


def apply(target_from_source: Matrix, point_in_source: npt.ArrayLike) -> Vector:
    """Return a point (3,), or points (n, 3), in the target frame."""
    points = np.asarray(point_in_source, dtype=np.float64)
    return points @ target_from_source[:3, :3].T + target_from_source[:3, 3]


def rotation_from_quaternion(quaternion_xyzw: npt.ArrayLike) -> Matrix:
    """Return the (3, 3) rotation. Raises GeometryError for a quaternion that is not of length 1."""
    q: Any = np.asarray(quaternion_xyzw, dtype=np.float64)
    length = float(np.linalg.norm(q))
    if not abs(length - 1.0) < 1e-3:
        raise GeometryError(f"quaternion of length {length:g}, expected 1")
    x, y, z, w = q / length
    return np.array(
        [
            [1 - 2 * (y * y + z * z), 2 * (x * y - z * w), 2 * (x * z + y * w)],
            [2 * (x * y + z * w), 1 - 2 * (x * x + z * z), 2 * (y * z - x * w)],
            [2 * (x * z - y * w), 2 * (y * z + x * w), 1 - 2 * (x * x + y * y)],
        ]
    )


def quaternion_from_rotation(rotation: Matrix) -> Vector:
    """Return the quaternion xyzw (4,), w >= 0, of a (3, 3) rotation."""
    # The four candidates are equal in exact arithmetic; the largest divisor is the accurate one.
    m = rotation
    squares = np.array(
        [
            1 + m[0, 0] - m[1, 1] - m[2, 2],
            1 - m[0, 0] + m[1, 1] - m[2, 2],
            1 - m[0, 0] - m[1, 1] + m[2, 2],
            1 + m[0, 0] + m[1, 1] + m[2, 2],
        ]
    )
    candidates = np.array(
        [
            [squares[0], m[0, 1] + m[1, 0], m[0, 2] + m[2, 0], m[2, 1] - m[1, 2]],
            [m[0, 1] + m[1, 0], squares[1], m[1, 2] + m[2, 1], m[0, 2] - m[2, 0]],
            [m[0, 2] + m[2, 0], m[1, 2] + m[2, 1], squares[2], m[1, 0] - m[0, 1]],
            [m[2, 1] - m[1, 2], m[0, 2] - m[2, 0], m[1, 0] - m[0, 1], squares[3]],
        ]
    )
    quaternion = candidates[int(np.argmax(squares))]
    quaternion = quaternion / np.linalg.norm(quaternion)
    return np.asarray(quaternion if quaternion[3] >= 0 else -quaternion, dtype=np.float64)


def unit(vector: npt.ArrayLike) -> Vector:
    """Return the vector scaled to length 1. Raises GeometryError for one without direction."""
    array = np.asarray(vector, dtype=np.float64)
    length = float(np.linalg.norm(array))
    if not np.isfinite(length) or length < 1e-9:
        raise GeometryError(f"vector {array.tolist()} has no direction")
    return array / length


def frame_from_normal(normal: npt.ArrayLike) -> Matrix:
    """Return a (3, 3) rotation world_from_contact whose z axis is the normal.

    The x axis is the world's x as far as it lies in the surface (y where it does not), so that a
    table
    gives the identity.
    """
    z = unit(normal)
    reference = np.array([1.0, 0.0, 0.0]) if abs(z[0]) < 0.9 else np.array([0.0, 1.0, 0.0])
    x = unit(reference - (reference @ z) * z)
    return np.column_stack([x, np.cross(z, x), z])


def base_from_midfeet(base_from_left_sole: Matrix, base_from_right_sole: Matrix) -> Matrix:
    """Return the frame midway between the soles; its x and z are the means of the feet's.

    In double support the world frame *is* this frame:
    `world_from_base = inverse(base_from_midfeet(...))`.
    """
    left, right = base_from_left_sole, base_from_right_sole
    z = unit(left[:3, 2] + right[:3, 2])
    forward = left[:3, 0] + right[:3, 0]
    x = unit(forward - (forward @ z) * z)
    return transform(np.column_stack([x, np.cross(z, x), z]), 0.5 * (left[:3, 3] + right[:3, 3]))
