"""Squares of pictures as they might have been cut and lit: for what is learned from near."""

import torch
from torch.nn import functional


def cut_otherwise(
    squares: torch.Tensor,
    side: int,
    nominal: float,
    scales: tuple[float, float],
    shift: float,
    generator: torch.Generator,
) -> torch.Tensor:
    """Return (n, c, side, side): each square cut a little differently, every second turned over.

    Args:
        squares: (n, c, stored, stored).
        side: Of the results [px].
        nominal: Side of what is cut at run time, over that of `squares`.
        scales: Lowest and highest factor of that.
        shift: Of the middle, at most, in halves of the side of `squares`.
        generator: Source of chance.
    """
    count = len(squares)
    scaled = (
        nominal
        * between(*scales, count, 1, generator=generator)
        * between(0.93, 1.07, count, 2, generator=generator)
    )
    turned = torch.where(between(0.0, 1.0, count, generator=generator) < 0.5, -1.0, 1.0)
    windows = torch.zeros(count, 2, 3)
    windows[:, 0, 0] = scaled[:, 0] * turned
    windows[:, 1, 1] = scaled[:, 1]
    windows[:, :, 2] = between(-shift, shift, count, 2, generator=generator)
    grid = functional.affine_grid(windows, [*squares.shape[:2], side, side], align_corners=False)
    return functional.grid_sample(squares, grid, align_corners=False, padding_mode="border")


def lit_otherwise(colours: torch.Tensor, generator: torch.Generator) -> torch.Tensor:
    """Return pictures (n, 3, h, w), 0 to 1, under other light, with noise."""
    count = len(colours)
    lit = colours * between(0.7, 1.35, count, 1, 1, 1, generator=generator) * between(
        0.93, 1.07, count, 3, 1, 1, generator=generator
    ) + between(-0.06, 0.06, count, 1, 1, 1, generator=generator)
    noise = torch.randn(lit.shape, generator=generator)
    noise *= between(0.0, 0.03, count, 1, 1, 1, generator=generator)
    return (lit + noise).clamp(0.0, 1.0)


def between(low: float, high: float, *shape: int, generator: torch.Generator) -> torch.Tensor:
    """Return numbers (shape) drawn evenly from an interval."""
    return low + (high - low) * torch.rand(*shape, generator=generator)
