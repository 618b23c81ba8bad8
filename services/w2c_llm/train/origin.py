"""What a training begins with: random weights, those of a GGUF file, or those of a checkpoint."""

from dataclasses import dataclass
from pathlib import Path
from typing import Any

import gguf
import numpy as np
import torch
from tokenizers import Tokenizer
from transformers import Qwen2ForCausalLM

from w2c.errors import ConfigError
from w2c_llm.train import checkpoint
from w2c_llm.train.export import tensor_names
from w2c_llm.train.network import NetworkSize, make_network
from w2c_llm.train.tokenizer import PRE_TOKENIZER, known_tokenizer

_ARCHITECTURE = "qwen2"
_MAGIC = b"GGUF"


@dataclass(frozen=True)
class Origin:
    """A network with its tokenizer; they are never mixed with those of others."""

    network: Qwen2ForCausalLM
    tokenizer: Tokenizer
    size: NetworkSize


def read_origin(path: Path) -> Origin:
    """Return the network of a GGUF file or of a checkpoint of this trainer.

    Raises:
        ConfigError: there is no such file, it is neither, or of another kind of network.
    """
    try:
        with path.open("rb") as file:
            is_gguf = file.read(len(_MAGIC)) == _MAGIC
    except OSError as error:
        raise ConfigError(f"{path} cannot be read: {error.strerror}; give --from FILE") from error
    return _from_gguf(path) if is_gguf else _from_checkpoint(path)


def _from_checkpoint(path: Path) -> Origin:
    kept = checkpoint.load(path)
    tokenizer, size = checkpoint.tokenizer_of(kept), NetworkSize(**kept.size)
    network = make_network(size, tokenizer.get_vocab_size(), 0)
    network.load_state_dict(kept.trainer["network"])
    return Origin(network, tokenizer, size)


def _from_gguf(path: Path) -> Origin:
    try:
        reader = gguf.GGUFReader(path)
    except (ValueError, IndexError, KeyError, OSError) as error:
        raise ConfigError(f"{path} is a damaged GGUF file: {error}") from error
    architecture = _field(path, reader, "general.architecture")
    split = _field(path, reader, "tokenizer.ggml.pre")
    if (architecture, split) != (_ARCHITECTURE, PRE_TOKENIZER):
        raise ConfigError(
            f"{path} is a '{architecture}' with the tokenizer '{split}'; training goes on only "
            f"from a '{_ARCHITECTURE}' with '{PRE_TOKENIZER}', as this trainer writes it"
        )
    tokenizer = known_tokenizer(
        _field(path, reader, "tokenizer.ggml.tokens"), _field(path, reader, "tokenizer.ggml.merges")
    )
    size = NetworkSize(
        width=_field(path, reader, "qwen2.embedding_length"),
        layers=_field(path, reader, "qwen2.block_count"),
        heads=_field(path, reader, "qwen2.attention.head_count"),
        feed_forward=_field(path, reader, "qwen2.feed_forward_length"),
        context=_field(path, reader, "qwen2.context_length"),
    )
    network = make_network(size, tokenizer.get_vocab_size(), 0)
    _load_weights(path, reader, network)
    return Origin(network, tokenizer, size)


def _field(path: Path, reader: gguf.GGUFReader, name: str) -> Any:
    field = reader.get_field(name)
    if field is None:
        raise ConfigError(f"{path} does not say '{name}': it is not from this trainer")
    return field.contents()


def _load_weights(path: Path, reader: gguf.GGUFReader, network: Qwen2ForCausalLM) -> None:
    """Take over the weights; those of 8 bits are nearly what was trained."""
    stored = {
        tensor.name: gguf.quants.dequantize(tensor.data, tensor.tensor_type)
        for tensor in reader.tensors
    }
    state = network.state_dict()
    for ours, theirs in tensor_names(network.config.num_hidden_layers).items():
        weight = stored.pop(theirs, None)
        if weight is None or weight.shape != tuple(state[ours].shape):
            found = "missing" if weight is None else f"of shape {weight.shape}"
            raise ConfigError(f"{path}: '{theirs}' is {found}, expected {tuple(state[ours].shape)}")
        state[ours] = torch.from_numpy(np.array(weight, np.float32))
    if stored:
        raise ConfigError(f"{path} has tensors that this network has not: {sorted(stored)[:3]}")
    state["lm_head.weight"] = state["model.embed_tokens.weight"]
    network.load_state_dict(state)
