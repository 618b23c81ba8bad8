"""The largest piece of smooth surface around a pixel that the noise of depth does not contradict.

A small piece is fitted first, then ever larger ones: of the pixels in each larger disc those count
that the former piece foretells within the noise. So another surface behind an edge, or beside a
crease, has no say; and where the surface bends, second-order terms say so.
"""

from dataclasses import dataclass, replace

import numpy as np
import numpy.typing as npt

from w2c.errors import RefusedError
from w2c_perception.patch import LINEAR, QUADRATIC, Normals, Patch, terms
from w2c_perception.window import GRAZING, DepthPicture, Points, Samples, Seed, samples

SMALLEST = 5.0
"""Radius of the first disc [px]"""
GROWTH = 1.8
"""Of the radius from disc to disc"""
AGREES = 3.0
"""Standard deviations within which a pixel is as foretold"""
CRUDE = 0.0008
"""... or this, while the plane goes through single pixels [m]"""
MIN_POINTS = 12
HYPOTHESES = 60
"""Planes that are tried in the first disc"""
ENDED = 0.55
"""A disc of which a smaller share agrees is more than this surface"""
MISFIT = 1.2
"""A disc of which the pixels that agree are off by more than so many standard deviations, as a root
mean square, is no such surface"""
BENDS = 25.0
"""Second-order terms count where they explain so many noise variances (chi square, three degrees
of freedom)"""
MAY_BEND = 10.0
"""From so many on it may, which the smallest disc is too small to decide"""


@dataclass(frozen=True)
class Piece:
    """What was found around a pixel."""

    patch: Patch
    radius: float
    """Of the disc that it was fitted in [px]"""
    share: float
    """Of the pixels with depth in that disc that agree"""
    misfit: float
    """Root mean square of what is left over of those, over the noise"""
    dissent: float = 0.0
    """Largest difference of 1 / z at the pixel between this piece and the smaller ones [1/m]"""


def grow(depth: DepthPicture, seed: Seed, focal: float, footprint: float, sigma: float) -> Piece:
    """Return the largest piece up to the footprint.

    Args:
        depth: (h, w) [m], 0 = unknown.
        seed: the pixel on the surface.
        focal: length [px].
        footprint: radius of the largest piece [m].
        sigma: noise of depth [m].

    Raises:
        RefusedError: too few pixels with depth for any.
    """
    largest = max(SMALLEST, footprint * focal / seed.depth)
    radius = min(SMALLEST, largest)
    best = _first(depth, seed, radius, focal, sigma)
    values = [_value(best)]
    while radius < largest:
        radius = min(largest, GROWTH * radius)
        found = samples(depth, seed.u, seed.v, radius)
        larger = _Disc(found, seed, radius, sigma).go_on_from(best.patch)
        if larger is None or larger.share < ENDED or larger.misfit > MISFIT:
            break
        best = larger
        values.append(_value(best))
    among_sizes = max(abs(value - values[-1]) for value in values)
    # A larger piece has settled what the smallest could not tell: whether the surface bends.
    return replace(best, dissent=max(among_sizes, best.dissent))


def _value(piece: Piece) -> float:
    """Return 1 / z in the middle [1/m]."""
    return float(piece.patch.coefficients[0])


def _first(depth: DepthPicture, seed: Seed, radius: float, focal: float, sigma: float) -> Piece:
    """Return the smallest piece: the pixels around that are about as deep.

    Raises:
        RefusedError: too few of them.
    """
    found = samples(depth, seed.u, seed.v, radius)
    same = _consensus(found, seed, focal, sigma)
    disc = _Disc(found, seed, radius, sigma)
    start = disc.fit(same) if same.sum() >= MIN_POINTS else None
    if start is None:
        raise RefusedError(
            f"only {int(same.sum())} points of one surface with depth within {radius:.0f} px of "
            f"pixel ({int(seed.u)}, {int(seed.v)}), a plane needs {MIN_POINTS} that are not on a "
            "line; choose a larger surface or come closer"
        )
    found_again = disc.go_on_from(start)
    piece = found_again or Piece(start, radius, float(same.mean()), disc.misfit(start, same))
    return replace(piece, dissent=disc.doubt(same))


def _consensus(found: Samples, seed: Seed, focal: float, sigma: float) -> npt.NDArray[np.bool_]:
    """Return which pixels (n,) agree with the plane through the seed that most agree with.

    Planes through the seed and two pixels at random; the draws are fixed, so that the same picture
    gives the same answer. Planes that are seen at a grazing angle do not count: they are edges.
    """
    across, down = found.u - seed.anchor[0], found.v - seed.anchor[1]
    inverse = 1.0 / found.z
    step = inverse - 1.0 / seed.depth
    pairs = np.random.default_rng(0).integers(len(step), size=(HYPOTHESES, 2))
    (a, b), (c, d) = ((across[pairs[:, k]], down[pairs[:, k]]) for k in (0, 1))
    first, second = step[pairs[:, 0]], step[pairs[:, 1]]
    turn = a * d - b * c
    with np.errstate(divide="ignore", invalid="ignore"):
        slopes = np.stack([d * first - b * second, a * second - c * first]) / turn
    steepest = GRAZING / (seed.depth * focal)
    possible = (np.abs(turn) > 0.5) & (np.hypot(*slopes) <= steepest)
    if not possible.any():
        return np.zeros(len(step), bool)
    expected = np.outer(across, slopes[0, possible]) + np.outer(down, slopes[1, possible])
    tolerance = max(CRUDE, AGREES * sigma) * inverse * inverse
    agrees = np.abs(step[:, None] - expected) <= tolerance[:, None]
    return np.asarray(agrees[:, int(np.argmax(agrees.sum(axis=0)))])


class _Disc:
    """The pixels with depth around the seed, up to a radius."""

    def __init__(self, found: Samples, seed: Seed, radius: float, sigma: float) -> None:
        self._found, self._radius = found, radius
        self._middle = (seed.u, seed.v)
        self._inverse = 1.0 / found.z
        square = self._inverse * self._inverse
        self._sigma = sigma * square
        self._tolerance = AGREES * sigma * square
        self._rows = terms(found.u, found.v, self._middle, radius, QUADRATIC)

    def go_on_from(self, patch: Patch) -> Piece | None:
        """Return the piece that goes on from a former one; None where too little agrees."""
        agrees = np.abs(self._inverse - self._foretold(patch)) <= self._tolerance
        if agrees.sum() < MIN_POINTS:
            return None
        found = self.fit(agrees)
        if found is None:
            return None
        return Piece(found, self._radius, float(agrees.mean()), self.misfit(found, agrees))

    def misfit(self, patch: Patch, chosen: npt.NDArray[np.bool_]) -> float:
        """Return what a patch through some pixels leaves over, over the noise."""
        return patch.spread / float(np.mean(self._sigma[chosen]))

    def fit(self, chosen: npt.NDArray[np.bool_]) -> Patch | None:
        """Return the patch through some pixels, curved where that explains more than chance."""
        normals = Normals(self._rows[chosen], self._inverse[chosen], self._middle, self._radius)
        linear = normals.solve(LINEAR)
        # In the smallest disc a crease would pass for a bend.
        bent = normals.solve(QUADRATIC) if self._radius > SMALLEST else None
        if linear is None or bent is None:
            return linear
        gain = linear.support * (linear.spread**2 - bent.spread**2)
        return bent if gain > BENDS * float(np.mean(self._sigma[chosen])) ** 2 else linear

    def doubt(self, chosen: npt.NDArray[np.bool_]) -> float:
        """Return by how much 1 / z in the middle differs if the surface bends, as it may [1/m]."""
        normals = Normals(self._rows[chosen], self._inverse[chosen], self._middle, self._radius)
        linear, bent = normals.solve(LINEAR), normals.solve(QUADRATIC)
        if linear is None or bent is None:
            return 0.0
        gain = linear.support * (linear.spread**2 - bent.spread**2)
        if gain <= MAY_BEND * float(np.mean(self._sigma[chosen])) ** 2:
            return 0.0
        return abs(float(linear.coefficients[0] - bent.coefficients[0]))

    def _foretold(self, patch: Patch) -> Points:
        """Return 1 / z (n,) of the pixels by a patch about the same middle [1/m]."""
        shrink = self._radius / patch.scale
        c = (
            patch.coefficients
            * np.array([1.0, *[shrink] * 2, *[shrink**2] * 3])[: len(patch.coefficients)]
        )
        return np.asarray(self._rows[:, : len(c)] @ c)
