"""Examples to padded tensors, neighbours in length together so that little is padding."""

from collections.abc import Iterator, Sequence
from dataclasses import dataclass

import numpy as np
import torch

from w2c_llm.train.tokenizer import EncodedExample

_CHUNK_BATCHES = 50
"""How many batches are sorted together: enough for little padding, few enough to stay random."""


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


def make_batch(examples: Sequence[EncodedExample], prompt_weight: float) -> Batch:
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
        torch.from_numpy(tokens),
        torch.from_numpy(targets),
        torch.from_numpy(weights),
        torch.from_numpy(answers),
    )


def shuffled_batches(
    examples: Sequence[EncodedExample], size: int, prompt_weight: float, random: np.random.Generator
) -> Iterator[Batch]:
    """Yield one epoch: random chunks, sorted by length within, batches in random order."""
    order = random.permutation(len(examples))
    chunk = size * _CHUNK_BATCHES
    for start in range(0, len(order), chunk):
        indices = sorted(
            order[start : start + chunk], key=lambda index: len(examples[index].tokens)
        )
        groups = [indices[at : at + size] for at in range(0, len(indices), size)]
        for group in random.permutation(len(groups)):
            yield make_batch([examples[index] for index in groups[group]], prompt_weight)
