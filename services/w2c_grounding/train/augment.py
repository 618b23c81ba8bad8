"""Changes to pictures that change no answer: crop, zoom, turn, mirror image, light, noise, blur.

The mirror image is one of them only because no phrase says left or right.
"""

from dataclasses import dataclass

import cv2
import numpy as np
import numpy.typing as npt
import torch
from torch.nn import functional

from w2c_grounding.train.model import DEVIATION, MEAN

Bytes = npt.NDArray[np.uint8]
Matrix = npt.NDArray[np.float64]
ASPECT = 16.0 / 9.0
"""Of the camera: how much wider a pixel of the squashed picture is in the world than high"""
MOST_TURNED = 0.12
"""[rad]"""


@dataclass(frozen=True)
class View:
    """Which part of a picture is shown, in pixels of a squashed picture of some side."""

    picture_from_view: Matrix
    """(2, 3): where a pixel of the window is taken from"""
    corner: tuple[int, int]
    """Row and column of the window's first patch in the whole picture [patches]"""
    window: int
    """Side [px]"""
    zoom: float
    """Pixels of the picture for one of the window, along each axis"""


def draw_view(
    side: int,
    window: int,
    patch: int,
    centre: tuple[float, float] | None,
    rng: np.random.Generator,
) -> View:
    """Draw a view: the whole picture a little moved, or a window around a point of it.

    Args:
        side: Of the squashed picture [px].
        window: Side of the window [px]; `side` for the whole picture.
        patch: Side of a patch [px].
        centre: What the window shall show: column and row in the picture [px]; None = anything.
        rng: Source of chance.
    """
    zoom = float(np.exp(rng.uniform(np.log(0.7), np.log(1.2))))
    if rng.random() < 0.3:
        zoom = 1.0
    turned = float(rng.uniform(-MOST_TURNED, MOST_TURNED)) if rng.random() < 0.6 else 0.0
    mirror = -1.0 if rng.random() < 0.5 else 1.0
    cosine, sine = np.cos(turned), np.sin(turned)
    # A turn in the world, where pixels are wider than high.
    linear = zoom * np.array([[mirror * cosine, -sine / ASPECT], [mirror * sine * ASPECT, cosine]])
    middle = np.array([side / 2.0, side / 2.0])
    # The whole picture first: it stays within the frame where it can, and may leave it a little.
    room = side * (abs(1.0 - zoom) / 2.0 + 0.04)
    shifted = middle + rng.uniform(-room, room, 2)
    if window == side:
        corner = (0, 0)
    else:
        where = rng.uniform(0, side, 2) if centre is None else np.asarray(centre)
        seen = np.linalg.solve(linear, where - shifted) + middle  # in the whole view
        low = seen - window * rng.uniform(0.2, 0.8, 2)
        last = (side - window) // patch
        column, row = (int(np.clip(round(value / patch), 0, last)) for value in low)
        corner = (row, column)
    origin = np.array([corner[1] * patch, corner[0] * patch], dtype=np.float64)
    offset = shifted + linear @ (origin - middle)
    return View(np.column_stack([linear, offset]), corner, window, zoom)


def look(view: View, pixels: Bytes, identities: Bytes) -> tuple[Bytes, Bytes]:
    """Return colours (window, window, 3) and owners (window, window) of a view of a picture."""
    size = (view.window, view.window)
    nearest = cv2.INTER_NEAREST | cv2.WARP_INVERSE_MAP
    linear = cv2.INTER_LINEAR | cv2.WARP_INVERSE_MAP
    colours = cv2.warpAffine(
        pixels, view.picture_from_view, size, flags=linear, borderMode=cv2.BORDER_REPLICATE
    )
    owners = cv2.warpAffine(identities, view.picture_from_view, size, flags=nearest)
    return np.asarray(colours, dtype=np.uint8), np.asarray(owners, dtype=np.uint8)


def relight(pixels: torch.Tensor, generator: torch.Generator) -> torch.Tensor:
    """Return pictures (n, 3, h, w) in 0 to 1 in another light; hues keep their names.

    Brightness, contrast, saturation, gamma, the light's colour and direction, noise, blur.
    """
    count = len(pixels)
    shape = (count, 1, 1, 1)
    pixels = pixels * _uniform(shape, 0.65, 1.3, generator)
    pixels = pixels * _uniform((count, 3, 1, 1), 0.92, 1.08, generator)
    pixels = pixels * _gradient(pixels, generator)
    centre = pixels.mean(dim=(1, 2, 3), keepdim=True)
    pixels = centre + (pixels - centre) * _uniform(shape, 0.75, 1.25, generator)
    grey = pixels.mean(dim=1, keepdim=True)
    pixels = grey + (pixels - grey) * _uniform(shape, 0.8, 1.2, generator)
    noise = 0.03 * _uniform(shape, 0, 1, generator)
    pixels = pixels + noise * torch.randn(pixels.shape, generator=generator)
    soft = _uniform((count,), 0, 1, generator) < 0.2
    pixels[soft] = functional.avg_pool2d(
        pixels[soft], 3, stride=1, padding=1, count_include_pad=False
    )
    return pixels.clamp(0, 1)


def normalise(pixels: torch.Tensor) -> torch.Tensor:
    """Return what the model reads of pictures (n, 3, side, side) in 0 to 1."""
    mean = torch.tensor(MEAN).view(1, 3, 1, 1)
    deviation = torch.tensor(DEVIATION).view(1, 3, 1, 1)
    return (pixels - mean) / deviation


def _gradient(pixels: torch.Tensor, generator: torch.Generator) -> torch.Tensor:
    """Return (n, 1, h, w): light that falls off from one side to the other, by up to a fifth."""
    count, _, height, width = pixels.shape
    slopes = _uniform((count, 2), -0.2, 0.2, generator)
    down = torch.linspace(-1, 1, height)[None, :, None] * slopes[:, 0, None, None]
    across = torch.linspace(-1, 1, width)[None, None, :] * slopes[:, 1, None, None]
    return (1.0 + 0.5 * (down + across))[:, None]


def _uniform(
    shape: tuple[int, ...], low: float, high: float, generator: torch.Generator
) -> torch.Tensor:
    return low + (high - low) * torch.rand(shape, generator=generator)
