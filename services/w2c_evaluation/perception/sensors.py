"""What real sensors make of the truth: depth with noise, edges and holes; angles with a bias."""

from dataclasses import dataclass

import cv2
import numpy as np
import numpy.typing as npt

from w2c.messages import Array

Depth = npt.NDArray[np.float32]

EDGE_STEP = 0.01
"""An edge is where depth changes by more from pixel to pixel than the slope beside it tells [m]"""
EDGE_SLOPE = 3.0
"""Times the change of the pixels beside it, which the slope of a surface may explain"""
HOLE_RADII = (0, 1, 2, 3)
"""Of round holes, equally often [px]; 0 = a single pixel"""


@dataclass(frozen=True)
class SensorErrors:
    """The errors that the targets are stated for."""

    noise: float = 0.001
    """Standard deviation of depth near the camera [m]"""
    noise_growth: float = 0.0015
    """What it grows by with the square of depth [1/m]"""
    edge_dropout: int = 2
    """Pixels without depth on either side of an edge"""
    holes: float = 0.02
    """Share of the picture"""
    encoder_noise: float = float(np.radians(0.02))
    """Standard deviation [rad]"""
    encoder_bias: float = float(np.radians(0.05))
    """Constant for each joint, at most [rad]"""

    def depth(self, truth: Depth, rng: np.random.Generator) -> Depth:
        """Return depth (h, w) [m] as a camera measures it; 0 = unknown."""
        sigma = self.noise + self.noise_growth * truth**2
        measured = truth + sigma * rng.standard_normal(truth.shape, dtype=np.float32)
        lost = (truth <= 0.0) | near_edges(truth, self.edge_dropout)
        lost |= random_holes(truth.shape, self.holes, rng)
        return np.where(lost, 0.0, np.maximum(measured, 0.0)).astype(np.float32)

    def position(self, truth: Array, rng: np.random.Generator) -> Array:
        """Return joint angles (n,) [rad] as encoders measure them."""
        bias = rng.uniform(-self.encoder_bias, self.encoder_bias, truth.shape)
        return np.asarray(truth + bias + rng.normal(0.0, self.encoder_noise, truth.shape))


def near_edges(depth: Depth, distance: int) -> npt.NDArray[np.bool_]:
    """Return which pixels (h, w) are within `distance` pixels of an edge."""
    edges = np.zeros(depth.shape, np.uint8)
    for axis in (0, 1):
        step = np.abs(np.diff(depth, axis=axis))
        beside = np.pad(step, [(1, 1) if a == axis else (0, 0) for a in (0, 1)], mode="edge")
        length = step.shape[axis]
        slope = np.minimum(
            np.take(beside, range(length), axis), np.take(beside, range(2, length + 2), axis)
        )
        jump = step > EDGE_STEP + EDGE_SLOPE * slope
        for shift in (0, 1):  # the pixels on both sides
            window = [slice(None), slice(None)]
            window[axis] = slice(shift, shift + length)
            edges[tuple(window)] |= jump
    if distance > 1:
        edges = np.asarray(cv2.dilate(edges, np.ones((2 * distance - 1,) * 2, np.uint8)))
    return np.asarray(edges > 0) if distance > 0 else np.zeros(depth.shape, bool)


def random_holes(
    shape: tuple[int, ...], share: float, rng: np.random.Generator
) -> npt.NDArray[np.bool_]:
    """Return which pixels (h, w) are in round holes that cover about this share."""
    height, width = shape
    mean_area = float(np.mean([_disc_area(radius) for radius in HOLE_RADII]))
    count = rng.poisson(share * height * width / mean_area)
    picture = np.zeros((height, width), np.uint8)
    rows, columns = rng.integers(height, size=count), rng.integers(width, size=count)
    for row, column, radius in zip(rows, columns, rng.choice(HOLE_RADII, count), strict=True):
        cv2.circle(picture, (int(column), int(row)), int(radius), 1, thickness=-1)
    return np.asarray(picture > 0)


def _disc_area(radius: int) -> int:
    """Return how many pixels a drawn disc covers."""
    side = 2 * radius + 3
    disc = cv2.circle(np.zeros((side, side), np.uint8), (radius + 1, radius + 1), radius, 1, -1)
    return int(np.asarray(disc).sum())
