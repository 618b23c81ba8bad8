"""How wrong the network of things is."""

import torch
from torch.nn import functional

from w2c_grounding.train.things.targets import Targets


def things_loss(
    there: torch.Tensor, fits: torch.Tensor, boxes: torch.Tensor, wanted: Targets
) -> torch.Tensor:
    """Return the loss of what `ThingsNetwork` answers.

    Cross-entropy of whether there is a thing; one minus the generalised overlap of boxes
    (Rezatofighi et al., CVPR 2019, equation 2); and cross-entropy of how well they fit with how
    well they do. A small thing counts as much as a large one.
    """
    inside = wanted.weights > 0.0
    each = functional.binary_cross_entropy_with_logits(
        there, wanted.things.clamp(min=0.0), reduction="none"
    )
    known = (wanted.things >= 0.0).float()
    per_thing = wanted.weights.sum().clamp(min=1.0)
    # All places alike, and all things alike: half and half.
    place = (each * known).sum() / known.sum().clamp(min=1.0)
    thing = (each * wanted.weights).sum() / per_thing
    if not bool(inside.any()):
        return place
    overlap, generalised = overlaps(boxes[inside], wanted.boxes[inside])
    weights = wanted.weights[inside] / per_thing
    ends = ((1.0 - generalised) * weights).sum()
    fit = functional.binary_cross_entropy_with_logits(
        fits[inside], overlap.detach().clamp(0.0, 1.0), reduction="none"
    )
    return 2.0 * place + 0.3 * thing + 2.0 * ends + 0.5 * (fit * weights).sum()


def overlaps(some: torch.Tensor, others: torch.Tensor) -> tuple[torch.Tensor, torch.Tensor]:
    """Return intersection over union, and the generalised one, of boxes (n, 4) in pairs."""
    low = torch.maximum(some[:, :2], others[:, :2])
    high = torch.minimum(some[:, 2:], others[:, 2:])
    common = (high - low).clamp(min=0.0).prod(dim=1)
    joint = (
        (some[:, 2:] - some[:, :2]).prod(dim=1)
        + (others[:, 2:] - others[:, :2]).prod(dim=1)
        - common
    )
    around = (
        torch.maximum(some[:, 2:], others[:, 2:]) - torch.minimum(some[:, :2], others[:, :2])
    ).prod(dim=1)
    overlap = common / joint.clamp(min=1e-9)
    return overlap, overlap - (around - joint) / around.clamp(min=1e-9)
