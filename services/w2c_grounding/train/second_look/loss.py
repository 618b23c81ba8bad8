"""What the training of the second look minimises."""

import torch
from torch.nn import functional

CHOICE = 0.5
"""Of the choice among the squares of a picture, beside yes and no of each"""


def match_loss(
    logits: torch.Tensor, fits: torch.Tensor, phrases: torch.Tensor, count: int
) -> torch.Tensor:
    """Return the loss of squares against the phrases that are asked of them.

    Two terms. The cross-entropy of each pair of a square and a phrase, those that fit and those
    that don't counting the same. And for each phrase that fits some, how likely a square drawn
    from the soft-max over all that it is asked of is one of them: one of two of a kind is to be
    told apart from the other, however alike both are to all else.

    Args:
        logits: (pairs,).
        fits: (pairs,) 1 or 0.
        phrases: (pairs,) number of the phrase, ascending.
        count: Of phrases.
    """
    each = functional.binary_cross_entropy_with_logits(logits, fits, reduction="none")
    right, wrong = fits.sum().clamp(min=1.0), (1.0 - fits).sum().clamp(min=1.0)
    decided = 0.5 * ((each * fits).sum() / right + (each * (1.0 - fits)).sum() / wrong)
    # The largest of each phrase is taken off before exponents are: they stay finite.
    empty = torch.full((count,), -1e4)
    highest = empty.scatter_reduce(0, phrases, logits.detach(), "amax")
    shares = (logits - highest[phrases]).exp()
    zeros = torch.zeros(count)
    total = zeros.scatter_add(0, phrases, shares)
    meant = zeros.scatter_add(0, phrases, shares * fits)
    some = zeros.scatter_add(0, phrases, fits) > 0
    chosen = -((meant[some] + 1e-6) / total[some]).log()
    return decided + CHOICE * chosen.sum() / some.sum().clamp(min=1)
