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
        if share > 0.0:
            for layer in network.model.layers:
                layer.self_attn.register_forward_hook(self._drop_first)
                layer.mlp.register_forward_hook(self._drop)

    def begin_step(self, step: int) -> None:
        """Draw the masks of this step from here on."""
        self._generator.manual_seed(self._seed * 1_000_003 + step)

    def _drop_first(
        self, block: torch.nn.Module, _: Any, output: tuple[torch.Tensor, Any]
    ) -> tuple[torch.Tensor, Any]:
        return self._drop(block, _, output[0]), output[1]

    def _drop(self, block: torch.nn.Module, _: Any, output: torch.Tensor) -> torch.Tensor:
        if not block.training:
            return output
        mask = torch.empty_like(output[:, :1])
        mask.bernoulli_(self._kept, generator=self._generator)
        return output * mask.div_(self._kept)
