"""The network of things: what the picture tower saw in, and at each place the thing there out."""

import math

import torch
from torch import nn
from torch.nn import functional

FINER = 2
"""Places along a side of a patch, where the network answers"""
_WIDTH = 128
_REACHES = (1, 2, 4, 6)
"""Of what each place hears of: so many patches away"""
_NARROW = 64
_FINE = 48
_EDGES = (16, 32, 48)
"""Channels of what is seen of the picture itself, each at half of the side of the one before"""
_USUAL = 0.08
"""Of the side of the picture: from the middle of a usual thing to its end"""
ANSWERS = 6
"""At each place: that there is a thing, that its box is good, and how far away its box ends to the
left, above, to the right and below"""


class Around(nn.Module):
    """Each place hears of places around it (Chen et al., "YOLOF", CVPR 2021, section 4.2)."""

    def __init__(self, reach: int) -> None:
        super().__init__()
        self.changes = nn.Sequential(
            nn.Conv2d(_WIDTH, _NARROW, 1, bias=False),
            nn.BatchNorm2d(_NARROW),
            nn.ReLU(),
            nn.Conv2d(_NARROW, _NARROW, 3, 1, reach, dilation=reach, bias=False),
            nn.BatchNorm2d(_NARROW),
            nn.ReLU(),
            nn.Conv2d(_NARROW, _WIDTH, 1, bias=False),
            nn.BatchNorm2d(_WIDTH),
        )

    def forward(self, maps: torch.Tensor) -> torch.Tensor:
        """Return (n, channels, rows, columns), as what goes in."""
        return functional.relu(maps + self.changes(maps))


class ThingsNetwork(nn.Module):
    """At each place of a picture the box of the thing that is seen there.

    A box for each place inside a thing is that of FCOS (Tian et al., ICCV 2019, section 3.1), a
    logit of how well it fits that of IoU-Net (Jiang et al., ECCV 2018).
    """

    def __init__(self, width: int) -> None:
        """Make a network with random weights; `width` is that of all activations together."""
        super().__init__()
        self.width = width
        self.reduce = nn.Sequential(nn.LayerNorm(width), nn.Linear(width, _WIDTH))
        self.around = nn.Sequential(*(Around(reach) for reach in _REACHES))
        self.finer = nn.Sequential(
            nn.Conv2d(_WIDTH, FINER * FINER * _FINE, 3, 1, 1), nn.PixelShuffle(FINER), nn.ReLU()
        )
        stages: list[nn.Module] = []
        before = 3
        for channels in _EDGES:
            stages += [
                nn.Conv2d(before, channels, 3, 2, 1, bias=False),
                nn.BatchNorm2d(channels),
                nn.ReLU(),
            ]
            before = channels
        self.edges = nn.Sequential(*stages)
        self.both = nn.Sequential(
            nn.Conv2d(_FINE + before, 96, 3, 1, 1, bias=False),
            nn.BatchNorm2d(96),
            nn.ReLU(),
            nn.Conv2d(96, 96, 3, 1, 1, bias=False),
            nn.BatchNorm2d(96),
            nn.ReLU(),
        )
        self.answers = nn.Conv2d(96, ANSWERS, 1)

    def forward(
        self, activations: tuple[torch.Tensor, ...], pixels: torch.Tensor
    ) -> tuple[torch.Tensor, torch.Tensor, torch.Tensor]:
        """Return what is at each place.

        Args:
            activations: Of the picture tower, each (n, 1 + patches, width).
            pixels: (n, 3, side, side), normalised.

        Returns:
            Logits (n, rows, columns) that there is a thing; logits that its box fits; and boxes
            (n, rows, columns, 4), left, top, right and bottom as shares of the picture's sides.
        """
        tokens = self.reduce(torch.cat([one[:, 1:] for one in activations], dim=2))
        side = math.isqrt(tokens.shape[1])
        # A view of tokens that lie one after the other is what convolutions like best.
        grid = tokens.unflatten(1, (side, side)).permute(0, 3, 1, 2)
        fine = self.finer(self.around(grid))
        edges = self.edges(pixels)
        if edges.shape[-2:] != fine.shape[-2:]:
            edges = functional.interpolate(edges, size=fine.shape[-2:])
        answers = self.answers(self.both(torch.cat([fine, edges], dim=1))).float()
        far = _USUAL * answers[:, 2:].clamp(-6.0, 4.0).exp()
        places = (torch.arange(fine.shape[-1], device=far.device) + 0.5) / fine.shape[-1]
        across, down = places[None, None, :], places[None, :, None]
        boxes = torch.stack(
            [across - far[:, 0], down - far[:, 1], across + far[:, 2], down + far[:, 3]], dim=3
        )
        return answers[:, 0], answers[:, 1], boxes
