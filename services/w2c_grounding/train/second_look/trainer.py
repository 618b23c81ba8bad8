"""The training loop of the second look."""

import torch
from torch import nn
from torch.nn import functional

from w2c.clock import Clock
from w2c_grounding.second_look.network import WIDTH, SecondLookNetwork
from w2c_grounding.train.addition.trainer import AdditionTrainer
from w2c_grounding.train.plan import Plan
from w2c_grounding.train.second_look.batches import SquareBatches
from w2c_grounding.train.second_look.loss import match_loss
from w2c_grounding.train.second_look.squares import Cut, Squares

PLAIN = 0.3
"""Of kind, colour and material of each square, beside what was asked for: they are learned from
every square of a step, and phrases are made of them"""
NOTHING = "nothing"
"""What a square shows that was cut out anywhere"""


class Plain(nn.Module):
    """What a thing is called in the truth: kind, colour, material. Not kept after the training."""

    def __init__(self, cuts: tuple[Cut, ...]) -> None:
        super().__init__()
        self._numbers = []
        targets = []
        for labels in zip(*(_labels(one) for one in cuts), strict=True):
            number = {label: n for n, label in enumerate(sorted(set(labels)))}
            self._numbers.append(number)
            targets.append(torch.tensor([number[label] for label in labels]))
        self._targets = torch.stack(targets)
        self.heads = nn.ModuleList(nn.Linear(WIDTH, len(number)) for number in self._numbers)

    def loss(self, seen: torch.Tensor, squares: torch.Tensor) -> torch.Tensor:
        """Return the cross-entropy of squares (n,) of the set, of which this is seen (n, WIDTH)."""
        losses = [
            functional.cross_entropy(head(seen).float(), targets[squares])
            for head, targets in zip(self.heads, self._targets, strict=True)
        ]
        return torch.stack(losses).sum()


def _labels(cut: Cut) -> tuple[str, str, str]:
    if cut.item is None:
        return NOTHING, NOTHING, NOTHING
    return cut.item.kind, cut.item.colour, cut.item.material


class SecondLookTrainer(AdditionTrainer):
    """Network, optimiser and clock of one training."""

    def __init__(
        self,
        network: SecondLookNetwork,
        squares: Squares,
        plan: Plan,
        clock: Clock,
        started_ns: int,
    ) -> None:
        """`started_ns` is when the command began."""
        plain = Plain(squares.cuts)
        super().__init__({"network": network, "plain": plain}, plan, clock, started_ns)
        self.network = network.train().to(memory_format=torch.channels_last)  # type: ignore[call-overload]
        self._batches = SquareBatches(squares, network, plan.seed)
        self._plain = plain

    def loss(self) -> torch.Tensor:
        """Return the loss of the next step."""
        batch = self._batches.make(self.progress.steps)
        with torch.autocast("cpu", torch.bfloat16, enabled=self._plan.bf16):
            seen = self.network.see(batch.squares.contiguous(memory_format=torch.channels_last))
        seen = seen.float()
        meant = self.network.read(*self.network.tokens(batch.phrases))
        square, phrase = batch.pairs.T
        logits = self.network.match(seen[square], meant[phrase])
        matched = match_loss(logits, batch.fits, phrase, len(batch.phrases))
        return matched + PLAIN * self._plain.loss(seen, torch.from_numpy(batch.numbers))
