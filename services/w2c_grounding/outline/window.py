"""The square of a picture in which an outline is drawn. Pure functions.

Pixels are (u right, v down), the centre of pixel (0, 0) is at (0.5, 0.5).
"""

from dataclasses import dataclass
from typing import Any

import cv2
import numpy as np
import numpy.typing as npt

from w2c_grounding.evidence import Region
from w2c_grounding.family import Heatmap, RgbImage
from w2c_grounding.outline.network import SIDE
from w2c_grounding.second_look.crops import LEAST, square_around

WIDENED = 2.2
"""Side of a square over the longer one of a region: half of a thing that was seen shows the rest"""
LARGEST = 0.17
"""Of the picture's width: where longer things end the family sees by itself, and better. With 0.45,
which was usual at first, boxes of large things grew over their neighbours"""
REACHED = 0.03
"""Of the side of a square: what comes so near to its end may go on beyond it"""


@dataclass(frozen=True)
class Window:
    """A square of a heatmap, and the same one of the picture that was brought to a width."""

    left: int
    top: int
    side: int
    """[px] of the picture that was brought to a width"""
    scale: float
    """Its pixels over those of the heatmap"""

    def widened(self, factor: float) -> "Window":
        """Return the square with the same middle whose side is so many times as long."""
        side = round(factor * self.side)
        more = (side - self.side) // 2
        return Window(self.left - more, self.top - more, side, self.scale)

    def is_reached(self, region: Region) -> bool:
        """Tell whether a region of the heatmap comes to an end of the square."""
        left, top = self.left / self.scale, self.top / self.scale
        side = self.side / self.scale
        near = REACHED * side
        return (
            region.left <= left + near
            or region.right >= left + side - near
            or region.top <= top + near
            or region.bottom >= top + side - near
        )

    def of_picture(self, image: RgbImage, side: int) -> RgbImage:
        """Return the square (side, side, 3) of the picture."""
        box = (self.left, self.top, self.left + self.side, self.top + self.side)
        return square_around(image, box, side, margin=0.0)

    def of_map(self, values: npt.NDArray[Any], side: int) -> npt.NDArray[np.float32]:
        """Return the square (side, side) of what has the size of the heatmap, 0 beyond it."""
        step = self.side / self.scale / side
        move = np.array(
            [
                [step, 0.0, self.left / self.scale + 0.5 * step - 0.5],
                [0.0, step, self.top / self.scale + 0.5 * step - 0.5],
            ]
        )
        cut = cv2.warpAffine(
            values.astype(np.float32, copy=False),
            move,
            (side, side),
            flags=cv2.INTER_LINEAR | cv2.WARP_INVERSE_MAP,
        )
        return np.asarray(cut, np.float32)

    def onto_map(
        self, drawn: npt.NDArray[np.float32], height: int, width: int
    ) -> tuple[tuple[slice, slice], npt.NDArray[np.float32]]:
        """Return where a square (n, n) lies in a heatmap of that size, and its values there."""
        first_u, first_v = self.left / self.scale, self.top / self.scale
        side = self.side / self.scale
        left, top = max(0, round(first_u)), max(0, round(first_v))
        right, bottom = min(width, round(first_u + side)), min(height, round(first_v + side))
        step = len(drawn) / side
        move = np.array(
            [
                [step, 0.0, (left + 0.5 - first_u) * step - 0.5],
                [0.0, step, (top + 0.5 - first_v) * step - 0.5],
            ]
        )
        laid = cv2.warpAffine(
            drawn,
            move,
            (right - left, bottom - top),
            flags=cv2.INTER_LINEAR | cv2.WARP_INVERSE_MAP,
            borderMode=cv2.BORDER_REPLICATE,
        )
        return np.s_[top:bottom, left:right], np.asarray(laid, np.float32)


def window_around(region: Region, scale: float) -> Window:
    """Return the square around a region of a heatmap; `scale` as in `Window`."""
    longest = max(region.right - region.left, region.bottom - region.top)
    side = max(1, round(max(WIDENED * longest * scale, LEAST)))
    left = round(0.5 * (scale * (region.left + region.right) - side))
    top = round(0.5 * (scale * (region.top + region.bottom) - side))
    return Window(left, top, side, scale)


def fits(region: Region, width: int) -> bool:
    """Tell whether an outline can be drawn around a region of a heatmap of this width."""
    return max(region.right - region.left, region.bottom - region.top) <= LARGEST * width


def layers(
    image: RgbImage, heatmap: Heatmap, region: Region, window: Window, side: int = SIDE
) -> npt.NDArray[np.uint8]:
    """Return what the network reads (side, side, LAYERS), 255 for 1.

    Args:
        image: Brought to a width.
        heatmap: (height, width).
        region: Of the heatmap.
        window: Around the region.
        side: Of the result.
    """
    mark = np.zeros(heatmap.shape, np.uint8)
    mark[region.top : region.bottom, region.left : region.right][region.mask] = 1
    heat = np.minimum(window.of_map(heatmap, side) / np.float32(region.score), 1.0)
    marked = window.of_map(mark, side)
    return np.dstack(
        [
            window.of_picture(image, side),
            *(np.rint(255.0 * one).astype(np.uint8) for one in (heat, marked)),
        ]
    )
