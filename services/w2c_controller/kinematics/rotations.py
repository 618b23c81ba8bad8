"""Rotation vectors (axis times angle) and rotation matrices, compiled."""

import math

import numpy as np
import numpy.typing as npt

from w2c_controller.compiled import compiled

Vector = npt.NDArray[np.float64]
Matrix = npt.NDArray[np.float64]


NEAR_HALF_TURN = -0.99
"""Cosine of an angle beyond which the axis is read from the symmetric part of the matrix."""


@compiled
def rotation_vector(rotation: Matrix, out: Vector) -> None:
    """Fill the axis times the angle (3,) of a rotation (3, 3), angle in [0, pi] [rad]."""
    _log(
        rotation[0, 0],
        rotation[0, 1],
        rotation[0, 2],
        rotation[1, 0],
        rotation[1, 1],
        rotation[1, 2],
        rotation[2, 0],
        rotation[2, 1],
        rotation[2, 2],
        out,
    )


@compiled
def rotation_between(target: Matrix, rotation: Matrix, out: Vector) -> None:
    """Fill log(R* R^T) (3,): the turn, in the world, from a rotation to its target [rad]."""
    _log(
        _dot(target[0], rotation[0]),
        _dot(target[0], rotation[1]),
        _dot(target[0], rotation[2]),
        _dot(target[1], rotation[0]),
        _dot(target[1], rotation[1]),
        _dot(target[1], rotation[2]),
        _dot(target[2], rotation[0]),
        _dot(target[2], rotation[1]),
        _dot(target[2], rotation[2]),
        out,
    )


@compiled
def turn(rotation: Matrix, x: float, y: float, z: float) -> None:
    """Replace R by exp([x y z]) R: turn it in the world by a rotation vector [rad]."""
    square = x * x + y * y + z * z
    angle = math.sqrt(square)
    if angle > 1e-4:
        sine, versine = math.sin(angle) / angle, (1.0 - math.cos(angle)) / square
    else:
        sine, versine = 1.0 - square / 6.0, 0.5 - square / 24.0
    cosine = 1.0 - versine * square
    for j in range(3):
        a, b, c = rotation[0, j], rotation[1, j], rotation[2, j]
        along = versine * (x * a + y * b + z * c)
        rotation[0, j] = cosine * a + along * x + sine * (y * c - z * b)
        rotation[1, j] = cosine * b + along * y + sine * (z * a - x * c)
        rotation[2, j] = cosine * c + along * z + sine * (x * b - y * a)


@compiled
def _dot(a: Vector, b: Vector) -> float:
    return float(a[0] * b[0] + a[1] * b[1] + a[2] * b[2])


@compiled
def _log(
    xx: float,
    xy: float,
    xz: float,
    yx: float,
    yy: float,
    yz: float,
    zx: float,
    zy: float,
    zz: float,
    out: Vector,
) -> None:
    """Fill the rotation vector of the rotation with these entries, row by row."""
    x, y, z = 0.5 * (zy - yz), 0.5 * (xz - zx), 0.5 * (yx - xy)
    sine = math.sqrt(x * x + y * y + z * z)
    cosine = 0.5 * (xx + yy + zz - 1.0)
    angle = math.atan2(sine, cosine)
    if cosine > NEAR_HALF_TURN:
        scale = angle / sine if sine > 1e-12 else 1.0
        out[0], out[1], out[2] = scale * x, scale * y, scale * z
        return
    # R + R' = 2 c I + 2 (1 - c) a a': the column of its largest diagonal entry leads to the axis.
    if xx >= yy and xx >= zz:
        out[0], out[1], out[2] = xx - cosine, 0.5 * (xy + yx), 0.5 * (xz + zx)
    elif yy >= zz:
        out[0], out[1], out[2] = 0.5 * (xy + yx), yy - cosine, 0.5 * (yz + zy)
    else:
        out[0], out[1], out[2] = 0.5 * (xz + zx), 0.5 * (yz + zy), zz - cosine
    length = math.sqrt(out[0] * out[0] + out[1] * out[1] + out[2] * out[2])
    share = angle / length
    if out[0] * x + out[1] * y + out[2] * z < 0.0:
        share = -share
    out[0] *= share
    out[1] *= share
    out[2] *= share
