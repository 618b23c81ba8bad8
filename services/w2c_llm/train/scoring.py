"""Exact match on held-out examples, one forward pass each."""

from collections import defaultdict
from collections.abc import Sequence

import torch
from transformers import Qwen2ForCausalLM

from w2c_llm.train.batches import make_batch
from w2c_llm.train.device import CPU, Device
from w2c_llm.train.tokenizer import EncodedExample


def exact_matches(
    network: Qwen2ForCausalLM,
    examples: Sequence[EncodedExample],
    device: Device = CPU,
    size: int = 48,
) -> list[bool]:
    """Return for each example whether greedy decoding would give exactly its answer.

    Greedy decoding reproduces an answer if and only if, with the answer as context, the most likely
    token is the right one at every position: so no text has to be generated.
    """
    order = sorted(range(len(examples)), key=lambda index: len(examples[index].tokens))
    result = [False] * len(examples)
    network.train(False)
    for start in range(0, len(order), size):
        indices = order[start : start + size]
        batch = make_batch([examples[index] for index in indices], 0.0, device.torch_device)
        with torch.no_grad(), device.autocast():
            best = network(input_ids=batch.tokens).logits.argmax(-1)
        right = ((best == batch.targets) | ~batch.answers).all(-1)
        for index, matched in zip(indices, right.tolist(), strict=True):
            result[index] = matched
    network.train()
    return result


def match_rates(
    examples: Sequence[EncodedExample], matches: Sequence[bool]
) -> dict[str, tuple[int, int]]:
    """Return task -> (exact matches, examples), and `all`."""
    counts: dict[str, list[int]] = defaultdict(lambda: [0, 0])
    for example, matched in zip(examples, matches, strict=True):
        for key in (example.task, "all"):
            counts[key][0] += matched
            counts[key][1] += 1
    return {task: (right, total) for task, (right, total) in sorted(counts.items())}
