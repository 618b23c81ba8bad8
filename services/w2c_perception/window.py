"""Pixels with depth around a pixel: which surface is meant, and how noisy its depth is."""

from dataclasses import dataclass, replace
from typing import Any, NamedTuple, Protocol

import numpy as np
import numpy.typing as npt

from w2c.errors import RefusedError

Points = npt.NDArray[np.float64]

NEAR = 2
"""Half width of the window [px] that finds the nearer side of an edge, and bridges small holes"""
FAR = 4
"""Half width of the window [px] that bridges larger holes, where the surface is all around"""
EDGE_STEP = 0.012
"""Neighbouring depths that differ by more are different surfaces [m]"""
EDGE_NOISE = 4.0
"""... or by more than so many standard deviations of noise"""
GRAZING = 6.0
"""On one surface depth may change by so many pixel widths from one pixel to the next"""
EDGE_SHARE = 0.2
"""A surface must fill so much of the window to be one: less is noise"""
NOISE_WINDOW = 12
"""Half width of the window in which noise is measured [px]"""
NOISE_SAMPLES = 30
"""Fewer second differences tell nothing of the noise"""
NOISIEST = 8.0
"""Times the usual noise, beyond which depth tells nothing"""
SMALLEST_NOISE = 0.00015
"""No depth is better, whatever its noise: lenses and calibration bend it [m]"""
USUAL_NOISE = (0.001, 0.0015)
"""Of depth cameras, where it cannot be measured: c0 + c1 z^2 [m]"""


class DepthPicture(Protocol):
    """z-depth (h, w) [m], 0 = unknown: an array, or what is scaled where it is read."""

    @property
    def shape(self) -> tuple[int, ...]:
        """Rows and columns."""

    def __getitem__(self, index: Any, /) -> Any:
        """Return float32 at any index that numpy knows [m]."""


class Samples(NamedTuple):
    """Pixels with depth."""

    u: Points
    """(n,) centres [px]"""
    v: Points
    z: Points
    """(n,) [m]"""


@dataclass(frozen=True)
class Seed:
    """The pixel whose surface is meant, and what else might be."""

    u: float
    v: float
    """Where the answer will be [px]"""
    depth: float
    """Measured at the anchor [m]"""
    anchor: tuple[float, float]
    """Centre of the nearest pixel of the surface that has depth [px]"""
    moved: float
    """How far from the pixel that was asked for [px]; 0 = it is that pixel"""
    behind: float
    """How far behind another surface is that the pixel may show instead [m]; 0 = there is none"""


def samples(depth: DepthPicture, u: float, v: float, radius: float, most: int = 29) -> Samples:
    """Return pixels with depth within a radius [px], thinned so that `most` are in a row."""
    reach = int(np.ceil(radius))
    column, row = int(u), int(v)
    stride = max(1, -(-(2 * reach + 1) // most))
    top, left = max(0, row - reach), max(0, column - reach)
    window = depth[top : row + reach + 1 : stride, left : column + reach + 1 : stride]
    rows, columns = np.nonzero(window > 0.0)
    z = window[rows, columns].astype(np.float64)
    us: Points = columns.astype(np.float64) * stride + (left + 0.5)
    vs: Points = rows.astype(np.float64) * stride + (top + 0.5)
    inside = (us - u) ** 2 + (vs - v) ** 2 <= radius * radius
    return Samples(us[inside], vs[inside], z[inside])


def noise(depth: DepthPicture, u: float, v: float, depth_unit: float) -> float:
    """Return the standard deviation of depth around a pixel [m], at least that of its steps.

    From second differences along rows and columns, whose median does not see edges, slopes, or the
    curvature of anything that a hand can touch. Noise that neighbouring pixels share is not seen.

    Raises:
        RefusedError: depth that is nothing but noise.
    """
    column, row = int(u), int(v)
    top, left = max(0, row - NOISE_WINDOW), max(0, column - NOISE_WINDOW)
    window = depth[top : row + NOISE_WINDOW + 1, left : column + NOISE_WINDOW + 1]
    z = window.astype(np.float64)
    known = z > 0.0
    bends = []
    for across, sure in ((z, known), (z.T, known.T)):
        if len(across) > 2:
            all_three = sure[:-2] & sure[1:-1] & sure[2:]
            bends.append((across[:-2] - 2.0 * across[1:-1] + across[2:])[all_three])
    found = np.concatenate(bends) if bends else np.zeros(0)
    smallest = max(SMALLEST_NOISE, depth_unit / np.sqrt(12.0))
    near = z[known]
    typical = float(np.median(near)) if len(near) else 1.0
    usual = USUAL_NOISE[0] + USUAL_NOISE[1] * typical**2
    if len(found) < NOISE_SAMPLES:
        return max(float(smallest), usual)
    # The median of |x| of a normal x is 0.6745 deviations; x is the sum of noises 1, -2 and 1.
    sigma = float(np.median(np.abs(found))) / 0.6745 / float(np.sqrt(6.0))
    if sigma > NOISIEST * usual:
        raise RefusedError(
            f"depth around pixel ({column}, {row}) is noise of {1000 * sigma:.0f} mm, limit "
            f"{1000 * NOISIEST * usual:.0f} mm at {typical:.1f} m; choose another surface"
        )
    return max(float(smallest), sigma)


def find_seed(depth: DepthPicture, u: float, v: float, focal: float, sigma: float) -> Seed:
    """Return the pixel of the nearest surface at (u, v).

    On a surface, and in a hole of it, that is the pixel itself. At an edge it is the closest pixel
    of the surface in front.

    Args:
        depth: (h, w) [m], 0 = unknown.
        u: to the right [px], in the picture.
        v: down [px].
        focal: length [px].
        sigma: noise of depth [m].

    Raises:
        RefusedError: no depth there.
    """
    near, far = (_Window(depth, u, v, reach, focal, sigma) for reach in (NEAR, FAR))
    if near.enough():
        seed = near.seed()
        # What else the pixel may show can be beyond the pixels that an edge has lost.
        return replace(seed, behind=far.behind(seed.depth)) if seed.moved > 0.0 else seed
    if far.enough() and far.surrounded():
        return far.seed()
    raise RefusedError(
        f"no depth at pixel ({int(u)}, {int(v)}): sky, glass, an edge, or too far; choose a point "
        "on a surface"
    )


class _Window:
    """What is seen in a square around a pixel."""

    def __init__(
        self, depth: DepthPicture, u: float, v: float, reach: int, focal: float, sigma: float
    ) -> None:
        row, column = int(v), int(u)
        top, left = max(0, row - reach), max(0, column - reach)
        window: npt.NDArray[np.float32] = depth[top : row + reach + 1, left : column + reach + 1]
        rows, columns = np.nonzero(window > 0.0)
        self._u, self._v, self._size = u, v, window.size
        self._focal = focal
        self._known = depth[row, column] > 0.0
        self._z = window[rows, columns].astype(np.float64)
        self._across = columns + (left + 0.5) - u
        self._down = rows + (top + 0.5) - v
        self._away = np.hypot(rows + top - row, columns + left - column)
        self._front = self._surface_in_front(focal, sigma) if len(self._z) else np.zeros(0, int)

    def enough(self) -> bool:
        """Tell whether there is a surface at all."""
        return len(self._z) >= EDGE_SHARE * self._size

    def surrounded(self) -> bool:
        """Tell whether the surface in front is seen on all sides of the pixel."""
        angles = np.sort(np.arctan2(self._down[self._front], self._across[self._front]))
        if len(angles) < 3:
            return False
        gaps = np.diff(np.append(angles, angles[0] + 2.0 * np.pi))
        return bool(gaps.max() < np.pi)

    def behind(self, depth: float) -> float:
        """Return how far behind a depth the farthest other surface is [m]; 0 = there is none."""
        others = np.delete(self._z, self._front)
        return max(0.0, float(others.max()) - depth) if len(others) else 0.0

    def seed(self) -> Seed:
        """Return the pixel on the surface in front."""
        front = self._front
        nearest = int(front[np.argmin(self._away[front])])
        depth = float(self._z[nearest])
        across, down = float(self._across[nearest]), float(self._down[nearest])
        anchor = (self._u + across, self._v + down)
        if self._away[nearest] == 0.0:
            return Seed(self._u, self._v, depth, anchor, 0.0, 0.0)
        if not self._known and self.surrounded():  # a hole of that surface
            return Seed(self._u, self._v, depth, anchor, 0.0, self.behind(depth))
        return Seed(*anchor, depth, anchor, float(np.hypot(across, down)), self.behind(depth))

    def _surface_in_front(self, focal: float, sigma: float) -> npt.NDArray[np.intp]:
        """Return which pixels (n,) belong to the surface in front: nearest first, up to a jump."""
        order = np.argsort(self._z)
        # Far away even a floor makes a step from pixel to pixel.
        edge = max(EDGE_STEP, EDGE_NOISE * sigma, GRAZING * float(self._z.min()) / focal)
        groups = np.split(order, np.nonzero(np.diff(self._z[order]) > edge)[0] + 1)
        large = [group for group in groups if len(group) >= EDGE_SHARE * self._size]
        return large[0] if large else max(groups, key=len)
