"""The network of outlines: a square of the picture and the heat there in, the whole thing out."""

from itertools import pairwise

import torch
from torch import nn
from torch.nn import functional

from w2c_grounding.second_look.network import Residual

SIDE = 64
"""Of what the network reads, and of what it draws [px]"""
LAYERS = 5
"""Of its input: red, green, blue, the heat of the phrase, and the region that is meant"""
_CHANNELS = (24, 24, 40, 64, 96)
_COMMON = 32


class OutlineNetwork(nn.Module):
    """A feature pyramid (Lin et al., CVPR 2017, figure 3) of which the finest level is drawn."""

    def __init__(self) -> None:
        super().__init__()
        self.stem = nn.Sequential(
            nn.Conv2d(LAYERS, _CHANNELS[0], 5, 2, 2, bias=False),
            nn.BatchNorm2d(_CHANNELS[0]),
            nn.ReLU(),
        )
        self.down = nn.ModuleList(
            Residual(before, channels, 1 if number == 0 else 2)
            for number, (before, channels) in enumerate(pairwise(_CHANNELS))
        )
        self.across = nn.ModuleList(nn.Conv2d(channels, _COMMON, 1) for channels in _CHANNELS[1:])
        self.smooth = nn.ModuleList(nn.Conv2d(_COMMON, _COMMON, 3, 1, 1) for _ in _CHANNELS[1:])
        # What is drawn is finer than the finest maps: each of their cells is four pixels.
        self.drawn = nn.Sequential(nn.Conv2d(_COMMON, 4, 1), nn.PixelShuffle(2))

    def forward(self, squares: torch.Tensor) -> torch.Tensor:
        """Return the logits (n, SIDE, SIDE) of the thing in squares (n, LAYERS, SIDE, SIDE).

        Of squares, all layers are 0 to 1.
        """
        maps = self.stem((squares - 0.5) / 0.25)
        levels = []
        for residual in self.down:
            maps = residual(maps)
            levels.append(maps)
        common: torch.Tensor | None = None
        for level, across, smooth in zip(
            reversed(levels), reversed(self.across), reversed(self.smooth), strict=True
        ):
            here = across(level)
            if common is not None:
                here = here + functional.interpolate(common, size=here.shape[-2:])
            common = functional.relu(smooth(here))
        logits: torch.Tensor = self.drawn(common).squeeze(1)
        return logits
