"""How a configuration q of a floating base moves with a velocity, compiled."""

import math

import numpy as np
import numpy.typing as npt

from w2c_controller.compiled import compiled

Vector = npt.NDArray[np.float64]


@compiled
def integrate(q: Vector, velocity: Vector, dt: float, out: Vector) -> None:
    """Fill q (+) dt v (nq,): the base moves along its own constant twist, joints add up.

    Args:
        q: (nq,)
        velocity: (nv,)
        dt: [s]
        out: (nq,) may be q itself.
    """
    a, b, c = dt * velocity[3], dt * velocity[4], dt * velocity[5]
    d, e, f = dt * velocity[0], dt * velocity[1], dt * velocity[2]
    square = a * a + b * b + c * c
    angle = math.sqrt(square)
    if angle > 1e-4:
        sine, versine = math.sin(angle) / angle, (1.0 - math.cos(angle)) / square
        rest, half = (1.0 - sine) / square, math.sin(0.5 * angle) / angle
    else:
        sine, versine = 1.0 - square / 6.0, 0.5 - square / 24.0
        rest, half = 1.0 / 6.0 - square / 120.0, 0.5 - square / 48.0
    along = rest * (a * d + b * e + c * f)
    u = sine * d + versine * (b * f - c * e) + along * a
    v = sine * e + versine * (c * d - a * f) + along * b
    w = sine * f + versine * (a * e - b * d) + along * c
    x, y, z, s = q[3], q[4], q[5], q[6]
    # p + R t with R of the unit quaternion (r, s): t + 2 s (r x t) + 2 r x (r x t).
    g, h, k = y * w - z * v, z * u - x * w, x * v - y * u
    out[0] = q[0] + u + 2.0 * (s * g + y * k - z * h)
    out[1] = q[1] + v + 2.0 * (s * h + z * g - x * k)
    out[2] = q[2] + w + 2.0 * (s * k + x * h - y * g)
    a, b, c, t = half * a, half * b, half * c, math.cos(0.5 * angle)
    out[3] = s * a + x * t + y * c - z * b
    out[4] = s * b + y * t + z * a - x * c
    out[5] = s * c + z * t + x * b - y * a
    out[6] = s * t - x * a - y * b - z * c
    length = math.sqrt(out[3] ** 2 + out[4] ** 2 + out[5] ** 2 + out[6] ** 2)
    for i in range(3, 7):
        out[i] /= length
    for i in range(7, q.shape[0]):
        out[i] = q[i] + dt * velocity[i - 1]
