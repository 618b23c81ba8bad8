"""A smooth piece of surface as a polynomial of inverse depth over the picture.

Along the ray r = ((u - cx) / fx, (v - cy) / fy, 1) a plane n . x = c has the inverse depth
1 / z = n . r / c: exactly linear in u and v, however steep it is seen. Noise of depth with standard
deviation s is noise of 1 / z with s / z^2, nearly the same all over a small piece. So a plane is a
linear least-squares problem, and a curved piece one with second-order terms.
"""

from dataclasses import dataclass

import numpy as np
import numpy.typing as npt

from w2c.geometry import Intrinsics, Vector, unit

Points = npt.NDArray[np.float64]

LINEAR, QUADRATIC = 3, 6
"""Coefficients of the two models"""
WORST_CONDITION = 1e4
"""Of normal equations that fix all coefficients"""


@dataclass(frozen=True)
class Patch:
    """1 / z = c . (1, a, b, a^2, a b, b^2), with a = (u - u0) / scale, b = (v - v0) / scale."""

    u: float
    v: float
    """The middle (u0, v0) [px]"""
    scale: float
    """[px]"""
    coefficients: Vector
    """(3,) or (6,) [1/m]"""
    covariance: Points
    """Of the coefficients, for a standard deviation of one of 1 / z"""
    spread: float
    """Root mean square of what is left over [1/m]"""
    support: int
    """Points that were used"""

    @property
    def curved(self) -> bool:
        """Whether it has second-order terms."""
        return self.coefficients.size == QUADRATIC

    def inverse_depth(self, u: npt.ArrayLike, v: npt.ArrayLike) -> Points:
        """Return 1 / z (n,) at pixels [1/m]; not positive: behind the camera."""
        return np.asarray(self._terms(u, v) @ self.coefficients)

    def deviation(self, u: float, v: float) -> float:
        """Return the standard deviation of 1 / z at a pixel for one of 1 in each measurement."""
        terms = self._terms(u, v)[0]
        return float(np.sqrt(terms @ self.covariance @ terms))

    def normal(self, u: float, v: float, intrinsics: Intrinsics) -> Vector:
        """Return the unit normal (3,) at a pixel, towards the camera, in the camera frame.

        The plane g . r = 1 / z that touches the surface there has g along its normal.
        """
        a, b = (u - self.u) / self.scale, (v - self.v) / self.scale
        c = self.coefficients
        slope_u, slope_v = c[1], c[2]
        if self.curved:
            slope_u += 2.0 * c[3] * a + c[4] * b
            slope_v += c[4] * a + 2.0 * c[5] * b
        along_u, along_v = slope_u / self.scale, slope_v / self.scale
        here = float(self.inverse_depth(u, v)[0])
        rest = here - along_u * (u - intrinsics.cx) - along_v * (v - intrinsics.cy)
        return -unit([along_u * intrinsics.fx, along_v * intrinsics.fy, rest])

    def _terms(self, u: npt.ArrayLike, v: npt.ArrayLike) -> Points:
        return terms(u, v, (self.u, self.v), self.scale, self.coefficients.size)


def terms(
    u: npt.ArrayLike, v: npt.ArrayLike, middle: tuple[float, float], scale: float, count: int
) -> Points:
    """Return the terms (n, count) of the polynomial at pixels."""
    a = (np.atleast_1d(np.asarray(u, dtype=np.float64)) - middle[0]) / scale
    b = (np.atleast_1d(np.asarray(v, dtype=np.float64)) - middle[1]) / scale
    result = np.empty((len(a), count))
    result[:, 0], result[:, 1], result[:, 2] = 1.0, a, b
    if count == QUADRATIC:
        result[:, 3], result[:, 4], result[:, 5] = a * a, a * b, b * b
    return result


class Normals:
    """The normal equations of least squares through some points, for both models."""

    def __init__(
        self, rows: Points, inverse_depth: Points, middle: tuple[float, float], scale: float
    ) -> None:
        """Take points.

        Args:
            rows: (n, 6) terms of the points.
            inverse_depth: (n,) [1/m].
            middle: of the polynomial [px].
            scale: of the polynomial [px].
        """
        self._count = len(rows)
        self._middle, self._scale = middle, scale
        self._matrix = rows.T @ rows
        self._right = rows.T @ inverse_depth
        self._square = float(inverse_depth @ inverse_depth)

    def solve(self, count: int) -> Patch | None:
        """Return the patch with `count` coefficients; None where the points do not fix one."""
        if self._count < 2 * count:
            return None
        matrix = self._matrix[:count, :count]
        try:
            covariance = np.asarray(np.linalg.inv(matrix), dtype=np.float64)
        except np.linalg.LinAlgError:
            return None
        # Points on a line, or in one spot, leave a slope open.
        if np.linalg.norm(matrix) * np.linalg.norm(covariance) > WORST_CONDITION:
            return None
        right = self._right[:count]
        coefficients = covariance @ right
        square = max(0.0, self._square - float(coefficients @ right))
        return Patch(
            self._middle[0],
            self._middle[1],
            self._scale,
            coefficients,
            covariance,
            float(np.sqrt(square / self._count)),
            self._count,
        )
