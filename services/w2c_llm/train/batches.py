"""Examples to padded tensors, neighbours in length together so that little is padding."""

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
import numpy.typing as npt
import torch

from w2c_llm.train.tokenizer import EncodedExample

_CHUNK_BATCHES = 50
"""How many batches are sorted together: enough for little padding, few enough to stay random."""
CPU = torch.device("cpu")


@dataclass(frozen=True)
class Batch:
    """What one step of training sees."""

    tokens: torch.Tensor
    """(examples, length) int64, padded on the right, where causal attention never looks"""
    targets: torch.Tensor
    """(examples, length) int64, the token that follows each"""
    weights: torch.Tensor
    """(examples, length) float32: 1 in the answer, less in the prompt, 0 in the padding"""
    answers: torch.Tensor
    """(examples, length) bool, where the target belongs to the answer"""


def make_batch(
    examples: Sequence[EncodedExample], prompt_weight: float, device: torch.device = CPU
) -> Batch:
    """Pad examples to the longest of them."""
    length = max(len(example.tokens) for example in examples) - 1
    shape = (len(examples), length)
    tokens, targets = np.zeros(shape, np.int64), np.zeros(shape, np.int64)
    weights, answers = np.zeros(shape, np.float32), np.zeros(shape, np.bool_)
    for row, example in enumerate(examples):
        count = len(example.tokens) - 1
        tokens[row, :count] = example.tokens[:-1]
        targets[row, :count] = example.tokens[1:]
        # Position p predicts token p + 1, so the answer begins one before it.
        weights[row, : example.prompt_length - 1] = prompt_weight
        weights[row, example.prompt_length - 1 : count] = 1.0
        answers[row, example.prompt_length - 1 : count] = True
    return Batch(
        torch.from_numpy(tokens).to(device),
        torch.from_numpy(targets).to(device),
        torch.from_numpy(weights).to(device),
        torch.from_numpy(answers).to(device),
    )


@dataclass(frozen=True)
class Mixture:
    """Examples of the corpus, and others that make up a share of every epoch."""

    examples: Sequence[EncodedExample]
    """Those of the corpus first"""
    order: npt.NDArray[np.int64]
    """(n,) indices of one epoch before it is shuffled; others than the corpus' may repeat"""
    lengths: npt.NDArray[np.int64]
    """(examples,) tokens of each"""


def mix(
    corpus: Sequence[EncodedExample], others: Sequence[EncodedExample], share: float
) -> Mixture:
    """Return a mixture with this share of others, 0 < share < 1, repeated as often as it takes."""
    order = np.arange(len(corpus), dtype=np.int64)
    if others:
        count = max(1, round(len(corpus) * share / (1.0 - share)))
        order = np.append(order, len(corpus) + np.resize(np.arange(len(others)), count))
    examples = [*corpus, *others]
    return Mixture(examples, order, np.array([len(example.tokens) for example in examples]))


def epoch_groups(mixture: Mixture, size: int, seed: int, epoch: int) -> list[npt.NDArray[np.int64]]:
    """Return the batches of an epoch as indices: a function of nothing but the arguments.

    Random chunks, sorted by length within, batches in random order.
    """
    random = np.random.default_rng((seed, epoch))
    order = random.permutation(mixture.order)
    chunk = size * _CHUNK_BATCHES
    groups: list[npt.NDArray[np.int64]] = []
    for start in range(0, len(order), chunk):
        indices = order[start : start + chunk]
        indices = indices[np.argsort(mixture.lengths[indices], kind="stable")]
        cut = [indices[at : at + size] for at in range(0, len(indices), size)]
        groups += [cut[place] for place in random.permutation(len(cut))]
    return groups
