"""Dropout: what a block adds to the stream is left out at random, so that no one path is relied on.

The corpus has fewer written lines than the network has room for; what is learned by heart of them
is no use for sentences of others. (Srivastava et al., JMLR 2014.)

A channel is left out of a whole sentence, not of one word at a time (Gal and Ghahramani, NeurIPS
2016): what its neighbours carry does not give it away. Nor do random numbers take a seventh of a
step, which one for each word did.
"""

from typing import Any

import torch
from transformers import Qwen2ForCausalLM


class Dropout:
    """Drops a share of what attention and feed-forward blocks add, while the network trains.

    The masks are a function of seed and step, so that a run that is resumed draws the same.
    """

    def __init__(self, network: Qwen2ForCausalLM, share: float, seed: int) -> None:
        """Attach to the network. `share` of the values becomes zero, 0 <= share < 1."""
        self._kept = 1.0 - share
        self._seed = seed
        self._generator = torch.Generator(network.device)
        self._width = network.config.hidden_size
        self._blocks: list[Any] = []
        if share > 0.0:
            for layer in network.model.layers:
                for block in (layer.self_attn, layer.mlp):
                    # A place that is filled in each step: the compiler reads it as an input, and
                    # would break the network in pieces where random numbers are drawn inside.
                    block.dropped = torch.ones(1)
                    block.register_forward_hook(_drop)
                    self._blocks.append(block)

    def begin_step(self, step: int, examples: int) -> None:
        """Draw the masks of a step for so many sentences."""
        self._generator.manual_seed(self._seed * 1_000_003 + step)
        for block in self._blocks:
            mask = torch.empty(examples, 1, self._width, device=self._generator.device)
            block.dropped = mask.bernoulli_(self._kept, generator=self._generator).div_(self._kept)


def _drop(block: Any, _: Any, output: Any) -> Any:
    """Leave out what a block adds; attention returns it with its weights."""
    if not block.training:
        return output
    mask: torch.Tensor = block.dropped
    if isinstance(output, tuple):
        return output[0] * mask.to(output[0].dtype), *output[1:]
    return output * mask.to(output.dtype)
