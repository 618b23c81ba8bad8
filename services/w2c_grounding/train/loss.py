"""What training minimises."""

import torch
from torch.nn import functional

HARDEST_SHARE = 0.002
"""Of the pixels of a phrase: those that decide whether an absent thing is "found" """


def mask_loss(logits: torch.Tensor, shares: torch.Tensor, weights: torch.Tensor) -> torch.Tensor:
    """Return the loss of heatmaps against the things that phrases fit.

    Five terms. Cross-entropy of each pixel. Dice, which does not care that a cup covers a
    hundredth of the picture (Milletari et al., "V-Net", 2016, eq. 3, with squares). And the
    cross-entropy of the hottest pixels outside the mask: the peak of a heatmap decides whether a
    thing is found, and the mean over all pixels hardly notices a single hot one. How likely a
    pixel drawn from the soft-max over the picture is outside the mask: the arg-max is what is
    pointed at. Last, the cross-entropy of the pixels of each thing, where all things count the
    same: of two bowls the smaller one, too, is to be found.

    Args:
        logits: (phrases, side, side).
        shares: (phrases, side, side), one over the pixels of a thing where a phrase fits it, else
            0; all 0 for a phrase that fits nothing.
        weights: (phrases,), 0 leaves a phrase out.
    """
    logits, shares = logits.flatten(1), shares.flatten(1)
    masks = (shares > 0).to(logits.dtype)
    each = functional.binary_cross_entropy_with_logits(logits, masks, reduction="none")
    probabilities = logits.sigmoid()
    overlap = (probabilities * masks).sum(dim=1)
    extent = (probabilities**2).sum(dim=1) + masks.sum(dim=1)
    present = (masks.sum(dim=1) > 0).float()
    dice = present * (1.0 - 2.0 * overlap / (extent + 1.0))
    outside = each * (1.0 - masks)
    count = max(1, round(HARDEST_SHARE * logits.shape[1]))
    hardest = outside.topk(count, dim=1).values.mean(dim=1)
    # Finite, so that phrases that fit nothing have a gradient of zero and not of NaN.
    inside = logits.masked_fill(masks == 0, -1e4).logsumexp(dim=1)
    astray = torch.where(present > 0, logits.logsumexp(dim=1) - inside, torch.zeros_like(present))
    missed = (each * shares).sum(dim=1) / shares.sum(dim=1).clamp(min=1.0)
    total = 4.0 * each.mean(dim=1) + dice + 0.25 * (hardest + astray + missed)
    return (weights * total).sum() / weights.sum().clamp(min=1.0)


def patch_targets(owners: torch.Tensor, classes: torch.Tensor, patch: int) -> torch.Tensor:
    """Return the share of each class in each patch.

    Args:
        owners: (n, side, side) uint8, ids of objects.
        classes: (n, 256, c) 0 or 1: which classes the object of an id belongs to.
        patch: Side of a patch [px].

    Returns:
        (n, patches, c), 0 to 1.
    """
    # Every second row and column is enough for a share, at a quarter of the time.
    sparse = owners[:, ::2, ::2].long()
    count, side, _ = sparse.shape
    cells, half = side // (patch // 2), patch // 2
    by_patch = sparse.view(count, cells, half, cells, half).permute(0, 1, 3, 2, 4)
    by_patch = by_patch.reshape(count, cells * cells, half * half)
    histogram = torch.zeros(count, cells * cells, 256)
    histogram.scatter_add_(2, by_patch, torch.ones(by_patch.shape))
    return torch.bmm(histogram / (half * half), classes)


def patch_loss(logits: torch.Tensor, shares: torch.Tensor) -> torch.Tensor:
    """Return the cross-entropy of what patches are said to show against the shares they show.

    What none of the classes covers is a class of its own, whose logit is 0. Patches that show a
    rare thing count more than those of table and floor, which are most.

    Args:
        logits: (n, patches, c).
        shares: (n, patches, c), 0 to 1, with a sum of at most 1 over c.
    """
    rest = (1.0 - shares.sum(dim=-1, keepdim=True)).clamp(min=0.0)
    everything = torch.cat([shares, rest], dim=-1)
    padded = torch.cat([logits, torch.zeros_like(rest)], dim=-1)
    each = -(everything * padded.log_softmax(dim=-1)).sum(dim=-1)
    common = everything.mean(dim=(0, 1), keepdim=True)
    # The square root is half way between counting patches and counting classes.
    weights = (everything / (common + 0.005).sqrt()).sum(dim=-1)
    return (weights * each).sum() / weights.sum()
