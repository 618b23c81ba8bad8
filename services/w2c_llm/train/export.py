"""Weights and tokenizer into one GGUF file that llama.cpp loads."""

import json
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import gguf
import numpy as np
import numpy.typing as npt
from tokenizers import Tokenizer
from transformers import Qwen2ForCausalLM

from w2c_llm.train.plan import WeightsName
from w2c_llm.train.tokenizer import CHAT_TEMPLATE, END, PAD, PRE_TOKENIZER, SPECIAL_TOKENS

_TYPES = {
    "f32": (gguf.GGMLQuantizationType.F32, gguf.LlamaFileType.ALL_F32),
    "f16": (gguf.GGMLQuantizationType.F16, gguf.LlamaFileType.MOSTLY_F16),
    "q8_0": (gguf.GGMLQuantizationType.Q8_0, gguf.LlamaFileType.MOSTLY_Q8_0),
}

_LAYER_TENSORS = {
    "input_layernorm.weight": "attn_norm.weight",
    "self_attn.q_proj.weight": "attn_q.weight",
    "self_attn.q_proj.bias": "attn_q.bias",
    "self_attn.k_proj.weight": "attn_k.weight",
    "self_attn.k_proj.bias": "attn_k.bias",
    "self_attn.v_proj.weight": "attn_v.weight",
    "self_attn.v_proj.bias": "attn_v.bias",
    "self_attn.o_proj.weight": "attn_output.weight",
    "post_attention_layernorm.weight": "ffn_norm.weight",
    "mlp.gate_proj.weight": "ffn_gate.weight",
    "mlp.up_proj.weight": "ffn_up.weight",
    "mlp.down_proj.weight": "ffn_down.weight",
}


@dataclass(frozen=True)
class Card:
    """What the file says of itself."""

    name: str
    description: str
    license: str = "apache-2.0"


def export_gguf(
    path: Path,
    network: Qwen2ForCausalLM,
    tokenizer: Tokenizer,
    card: Card,
    weights: WeightsName = "q8_0",
) -> None:
    """Write the model, whole or not at all. Raises OSError.

    The embedding serves as output layer too, so it is stored once.
    """
    quantization, file_type = _TYPES[weights]
    partial = path.with_suffix(".partial")
    writer = gguf.GGUFWriter(partial, "qwen2")
    writer.add_name(card.name)
    writer.add_description(card.description)
    writer.add_license(card.license)
    writer.add_file_type(file_type)
    _write_architecture(writer, network.config)
    _write_tokenizer(writer, tokenizer)
    for name, tensor in _tensors(network):
        if tensor.ndim == 1:  # norms and biases: small, and llama.cpp wants them in float32
            writer.add_tensor(name, tensor)
        else:
            writer.add_tensor(
                name, gguf.quants.quantize(tensor, quantization), raw_dtype=quantization
            )
    writer.write_header_to_file()
    writer.write_kv_data_to_file()
    writer.write_tensors_to_file()
    writer.close()
    partial.replace(path)


def _write_architecture(writer: gguf.GGUFWriter, config: Any) -> None:
    writer.add_context_length(config.max_position_embeddings)
    writer.add_embedding_length(config.hidden_size)
    writer.add_block_count(config.num_hidden_layers)
    writer.add_feed_forward_length(config.intermediate_size)
    writer.add_head_count(config.num_attention_heads)
    writer.add_head_count_kv(config.num_key_value_heads)
    writer.add_layer_norm_rms_eps(config.rms_norm_eps)
    writer.add_rope_freq_base(config.rope_parameters["rope_theta"])


def _write_tokenizer(writer: gguf.GGUFWriter, tokenizer: Tokenizer) -> None:
    model = json.loads(tokenizer.to_str())["model"]
    vocabulary: dict[str, int] = tokenizer.get_vocab(with_added_tokens=True)
    tokens = sorted(vocabulary, key=lambda token: vocabulary[token])
    kinds = [
        gguf.TokenType.CONTROL if token in SPECIAL_TOKENS else gguf.TokenType.NORMAL
        for token in tokens
    ]
    merges = [pair if isinstance(pair, str) else " ".join(pair) for pair in model["merges"]]
    writer.add_tokenizer_model("gpt2")
    writer.add_tokenizer_pre(PRE_TOKENIZER)
    writer.add_token_list(tokens)
    writer.add_token_types(kinds)
    writer.add_token_merges(merges)
    writer.add_eos_token_id(vocabulary[END])
    writer.add_pad_token_id(vocabulary[PAD])
    writer.add_add_bos_token(False)
    writer.add_chat_template(CHAT_TEMPLATE)


def tensor_names(layers: int) -> dict[str, str]:
    """Return name of a weight in the network -> its name in the GGUF file."""
    names = {
        "model.embed_tokens.weight": "token_embd.weight",
        "model.norm.weight": "output_norm.weight",
    }
    for layer in range(layers):
        names |= {
            f"model.layers.{layer}.{source}": f"blk.{layer}.{target}"
            for source, target in _LAYER_TENSORS.items()
        }
    return names


def _tensors(network: Qwen2ForCausalLM) -> list[tuple[str, npt.NDArray[np.float32]]]:
    """Return (name in GGUF, float32 array) of every weight."""
    state = network.state_dict()
    return [
        (theirs, state[ours].detach().float().cpu().numpy())
        for ours, theirs in tensor_names(network.config.num_hidden_layers).items()
    ]
