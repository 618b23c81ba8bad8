"""Transposed convolutions as plain products: the same numbers, where their tiles do not overlap."""

import pytest
import torch
from torch import nn

from w2c_grounding.clipseg import ClipSeg
from w2c_grounding.model_config import ModelConfig
from w2c_grounding.registry import EMBEDDED
from w2c_grounding.tiles import Tiles, with_tiles


@pytest.mark.parametrize("bias", [True, False])
@pytest.mark.parametrize(("channels_in", "channels", "side"), [(6, 1, 4), (5, 3, 2), (4, 2, 1)])
def test_the_numbers_are_those_of_the_convolution(
    channels_in: int, channels: int, side: int, bias: bool
) -> None:
    torch.manual_seed(0)
    convolution = nn.ConvTranspose2d(channels_in, channels, side, stride=side, bias=bias)
    cells = torch.randn(2, channels_in, 5, 7)
    tiles = with_tiles(convolution)
    assert isinstance(tiles, Tiles)
    torch.testing.assert_close(tiles(cells), convolution(cells))


@pytest.mark.parametrize(
    "convolution",
    [
        nn.ConvTranspose2d(4, 2, 4, stride=2),
        nn.ConvTranspose2d(4, 2, 4, stride=4, padding=1),
        nn.ConvTranspose2d(4, 2, (4, 2), stride=(4, 2)),
        nn.ConvTranspose2d(4, 4, 4, stride=4, groups=2),
        nn.ConvTranspose2d(4, 2, 2, stride=2, dilation=2),
    ],
    ids=["overlapping", "padded", "oblong", "grouped", "dilated"],
)
def test_another_convolution_stays(convolution: nn.ConvTranspose2d) -> None:
    assert with_tiles(convolution) is convolution


def test_those_deep_inside_are_replaced_too() -> None:
    torch.manual_seed(0)
    module = nn.Sequential(nn.Conv2d(3, 4, 1), nn.Sequential(nn.ConvTranspose2d(4, 2, 3, stride=3)))
    cells = torch.randn(1, 3, 4, 4)
    expected = module(cells)
    torch.testing.assert_close(with_tiles(module)(cells), expected)
    assert not any(isinstance(part, nn.ConvTranspose2d) for part in module.modules())


def test_a_loaded_model_decodes_with_them() -> None:
    config = ModelConfig(model=str(EMBEDDED), threads=1)
    family = ClipSeg.load(config, str(EMBEDDED), "{}")
    assert isinstance(family._model.decoder.transposed_convolution, Tiles)
