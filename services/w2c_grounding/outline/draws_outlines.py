"""Wraps a family: what was found ends where it ends in the picture."""

from collections.abc import Sequence
from dataclasses import replace
from typing import Generic

import numpy as np
import numpy.typing as npt
import torch

from w2c_grounding.evidence import REGION_FRACTION, Region, regions_of
from w2c_grounding.family import ContextT, Evidence, Family, Heatmap, RgbImage
from w2c_grounding.outline.network import OutlineNetwork
from w2c_grounding.outline.redraw import redrawn
from w2c_grounding.outline.window import fits, layers, window_around
from w2c_grounding.seen_near import SeenNear, seen_near

MOST = 8
"""Outlines of a phrase, the surest first"""
ROUNDS = 2
"""A thing of which less than half was lit goes on beyond its first square"""


class DrawsOutlines(Generic[ContextT]):
    """A family whose regions are redrawn. Thread-safe.

    What a family says with boxes of its own is left alone.
    """

    def __init__(
        self,
        family: Family[ContextT],
        network: OutlineNetwork,
        least: float,
        device: str = "cpu",
        edge: float = REGION_FRACTION,
    ) -> None:
        """Wrap a family.

        Args:
            family: Whose heatmaps are redrawn.
            network: Draws.
            least: Score of a region that is worth it.
            device: Of the network.
            edge: Share of the peak at which a thing ends in heatmaps of the family.
        """
        self.family = family
        self._network = network.to(device).eval()
        self._least = least
        self._device = device
        self._edge = edge

    def prepare(self, image: RgbImage) -> SeenNear[ContextT]:
        """Return what is kept of a picture."""
        return seen_near(self.family, image)

    def query(self, context: SeenNear[ContextT], phrases: Sequence[str]) -> list[Evidence]:
        """Return the evidence for each phrase."""
        return [
            one
            if one.boxes is not None
            else replace(one, heatmap=self.redrawn(one.heatmap, context.image, context.scale))
            for one in self.family.query(context.context, phrases)
        ]

    def redrawn(self, heatmap: Heatmap, image: RgbImage, scale: float) -> Heatmap:
        """Return a heatmap of the family with the outlines of what it shows.

        Args:
            heatmap: (height, width).
            image: The picture, brought to the width of the training.
            scale: Its pixels over those of the heatmap.
        """
        regions = regions_to_draw(heatmap, self._least, self._edge)
        for _ in range(ROUNDS):
            if regions:
                heatmap, regions = self._drawn(heatmap, regions, image, scale)
        return heatmap

    def _drawn(
        self, heatmap: Heatmap, regions: Sequence[Region], image: RgbImage, scale: float
    ) -> tuple[Heatmap, list[Region]]:
        """Return a heatmap with outlines, and the regions that go on beyond their squares."""
        windows = [window_around(one, scale) for one in regions]
        squares = np.stack(
            [
                layers(image, heatmap, region, window)
                for region, window in zip(regions, windows, strict=True)
            ]
        )
        logits = self._logits(squares)
        drawn, found = redrawn(heatmap, regions, windows, logits, self._edge)
        return drawn, [
            one
            for one, window in zip(found, windows, strict=True)
            if window.is_reached(one) and fits(one, heatmap.shape[1])
        ]

    @torch.inference_mode()
    def _logits(self, squares: npt.NDArray[np.uint8]) -> npt.NDArray[np.float32]:
        pixels = torch.from_numpy(squares).to(self._device).permute(0, 3, 1, 2)
        logits = self._network(pixels.float() / 255.0)
        return np.asarray(logits.float().cpu().numpy(), np.float32)


def regions_to_draw(heatmap: Heatmap, least: float, edge: float) -> list[Region]:
    """Return the regions of a heatmap whose outlines are drawn, the surest first."""
    if float(heatmap.max()) < least:
        return []
    found = regions_of(heatmap, least, edge)
    return [one for one in found[:MOST] if fits(one, heatmap.shape[1])]
