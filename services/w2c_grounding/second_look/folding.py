"""Puts the norms of a trained second look into its convolutions: the same answers, sooner."""

import copy
from itertools import pairwise

from torch import nn
from torch.nn.utils import fuse_conv_bn_eval

from w2c_grounding.second_look.network import Residual, SecondLookNetwork


def folded(network: SecondLookNetwork) -> SecondLookNetwork:
    """Return a copy whose convolutions scale and shift as their norms would.

    A norm that learns nothing any more is one factor and one term for each channel. A pass over
    squares takes a fifth less without.

    Args:
        network: In evaluation mode; it stays as it is. The copy cannot be trained.
    """
    answers = copy.deepcopy(network)
    maps = answers.maps
    for number, (layer, after) in enumerate(pairwise(list(maps))):
        if isinstance(layer, nn.Conv2d) and isinstance(after, nn.BatchNorm2d):
            maps[number], maps[number + 1] = fuse_conv_bn_eval(layer, after), nn.Identity()
    for block in maps:
        if isinstance(block, Residual):
            _fold(block)
    return answers


def _fold(block: Residual) -> None:
    for name in ("first", "second", "past"):
        norm = f"{name}_norm"
        setattr(block, name, fuse_conv_bn_eval(getattr(block, name), getattr(block, norm)))
        setattr(block, norm, nn.Identity())
