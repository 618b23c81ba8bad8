"""Changes to pictures that change no answer: light, colour, noise, blur, crop and mirror image.

The mirror image is one of them only because no phrase says left or right.
"""

import torch
from torch.nn import functional

from w2c_grounding.train.model import DEVIATION, MEAN


def vary(
    pixels: torch.Tensor, identities: torch.Tensor, generator: torch.Generator
) -> tuple[torch.Tensor, torch.Tensor]:
    """Return pictures and identities after random changes, the same geometry for both.

    Args:
        pixels: (n, 3, side, side), 0 to 1.
        identities: (n, side, side) uint8.
        generator: Source of chance.
    """
    pixels, identities = _reframe(pixels, identities, generator)
    pixels = _relight(pixels, generator)
    noise = 0.03 * _uniform((len(pixels), 1, 1, 1), 0, 1, generator)
    pixels = pixels + noise * torch.randn(pixels.shape, generator=generator)
    soft = _uniform((len(pixels),), 0, 1, generator) < 0.2
    pixels[soft] = functional.avg_pool2d(
        pixels[soft], 3, stride=1, padding=1, count_include_pad=False
    )
    return pixels.clamp(0, 1), identities


def normalise(pixels: torch.Tensor) -> torch.Tensor:
    """Return what the model reads of pictures (n, 3, side, side) in 0 to 1."""
    mean = torch.tensor(MEAN).view(1, 3, 1, 1)
    deviation = torch.tensor(DEVIATION).view(1, 3, 1, 1)
    return (pixels - mean) / deviation


def _uniform(
    shape: tuple[int, ...], low: float, high: float, generator: torch.Generator
) -> torch.Tensor:
    return low + (high - low) * torch.rand(shape, generator=generator)


def _reframe(
    pixels: torch.Tensor, identities: torch.Tensor, generator: torch.Generator
) -> tuple[torch.Tensor, torch.Tensor]:
    """Mirror half of the pictures, and shift, zoom and slightly stretch most of them."""
    count = len(pixels)
    zoom = _uniform((count, 1), 0.5, 1.1, generator) * _uniform((count, 2), 0.92, 1.08, generator)
    whole = _uniform((count, 1), 0, 1, generator) < 0.4
    zoom = torch.where(whole, torch.ones_like(zoom), zoom)
    # A crop stays inside the picture where it can.
    room = (1.0 - zoom).abs()
    shift = room * _uniform((count, 2), -1, 1, generator)
    mirror = torch.where(_uniform((count,), 0, 1, generator) < 0.5, -1.0, 1.0)
    maps = torch.zeros(count, 2, 3)
    maps[:, 0, 0] = zoom[:, 0] * mirror
    maps[:, 1, 1] = zoom[:, 1]
    maps[:, :, 2] = shift
    grid = functional.affine_grid(maps, list(pixels.shape), align_corners=False)
    moved = functional.grid_sample(pixels, grid, padding_mode="border", align_corners=False)
    owners = functional.grid_sample(
        identities[:, None].float(), grid, mode="nearest", padding_mode="zeros", align_corners=False
    )
    return moved, owners[:, 0].to(torch.uint8)


def _relight(pixels: torch.Tensor, generator: torch.Generator) -> torch.Tensor:
    """Change brightness, contrast, saturation and the light's colour; hues keep their names."""
    shape = (len(pixels), 1, 1, 1)
    pixels = pixels * _uniform(shape, 0.7, 1.3, generator)
    pixels = pixels * _uniform((len(pixels), 3, 1, 1), 0.93, 1.07, generator)
    centre = pixels.mean(dim=(1, 2, 3), keepdim=True)
    pixels = centre + (pixels - centre) * _uniform(shape, 0.75, 1.25, generator)
    grey = pixels.mean(dim=1, keepdim=True)
    return grey + (pixels - grey) * _uniform(shape, 0.8, 1.2, generator)
