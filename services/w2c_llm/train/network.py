"""The embedded model is a small Qwen2: llama.cpp runs it without permuted weights."""

from dataclasses import dataclass
from typing import Any

import torch
from transformers import Qwen2Config, Qwen2ForCausalLM


@dataclass(frozen=True)
class NetworkSize:
    """What decides the number of parameters; the default has 3.7 million with 2,048 tokens."""

    width: int = 256
    layers: int = 4
    heads: int = 4
    feed_forward: int = 704
    context: int = 1024
    """Longest chat [tokens]"""


def make_network(size: NetworkSize, vocabulary_size: int, seed: int) -> Qwen2ForCausalLM:
    """Return a network with random weights."""
    torch.manual_seed(seed)
    return Qwen2ForCausalLM(_config(size, vocabulary_size))


def _config(size: NetworkSize, vocabulary_size: int) -> Qwen2Config:
    options: dict[str, Any] = {
        "vocab_size": vocabulary_size,
        "hidden_size": size.width,
        "num_hidden_layers": size.layers,
        "num_attention_heads": size.heads,
        "num_key_value_heads": size.heads,
        "intermediate_size": size.feed_forward,
        "max_position_embeddings": size.context,
        "rope_parameters": {"rope_type": "default", "rope_theta": 10_000.0},
        "rms_norm_eps": 1e-6,
        "tie_word_embeddings": True,
        "use_cache": False,
        # Chats are short: plain attention is faster here than the fused one, and no less exact.
        "attn_implementation": "eager",
    }
    return Qwen2Config(**options)
