"""A GGUF of the size of a 0.5 B model with random weights: costs what a trained one costs.

A model of random weights has no opinion: which of two tokens it prefers hangs on the last digit of
their logits, and two programs that cut the same text into other tokens would get other answers.
So this one prefers some tokens to others in every context: one channel of the hidden state is
constant, no layer writes to it, and the output layer reads each token's preference from it.
"""

import json
from pathlib import Path

import gguf
import numpy as np
import numpy.typing as npt
from tokenizers import Tokenizer

from w2c_llm.bench.questions import KINDS, utterances
from w2c_llm.train.corpus import Example, Turn
from w2c_llm.train.tokenizer import (
    CHAT_TEMPLATE,
    END,
    PAD,
    PRE_TOKENIZER,
    SPECIAL_TOKENS,
    train_tokenizer,
)

WIDTH, LAYERS, HEADS, KEY_HEADS, FEED_FORWARD = 896, 24, 14, 2, 4864
VOCABULARY = 151_936
CONTEXT = 4096
_HEAD = WIDTH // HEADS
_LEARNED_TOKENS = 2000
_BLOCK = 32
"""Weights with one scale in the format q8_0"""
_FILE = "random-0.5b-2.gguf"
_Q8 = gguf.GGMLQuantizationType.Q8_0
_SPREAD = 127 / 3**0.5
"""Standard deviation of integers drawn evenly from -127 to 127"""


def random_model(folder: Path, seed: int = 0) -> Path:
    """Return the file, made on first use: 0.7 GB, half a minute."""
    path = folder / _FILE
    if not path.exists():
        folder.mkdir(parents=True, exist_ok=True)
        unfinished = path.with_suffix(".part")
        write_random_model(unfinished, np.random.default_rng(seed))
        unfinished.replace(path)
    return path


def write_random_model(
    path: Path, rng: np.random.Generator, layers: int = LAYERS, vocabulary: int = VOCABULARY
) -> None:
    """Write the model; tests make it smaller."""
    writer = gguf.GGUFWriter(path, "qwen2")
    writer.add_name("random weights")
    writer.add_file_type(gguf.LlamaFileType.MOSTLY_Q8_0)
    writer.add_context_length(CONTEXT)
    writer.add_embedding_length(WIDTH)
    writer.add_block_count(layers)
    writer.add_feed_forward_length(FEED_FORWARD)
    writer.add_head_count(HEADS)
    writer.add_head_count_kv(KEY_HEADS)
    writer.add_layer_norm_rms_eps(1e-6)
    writer.add_rope_freq_base(1_000_000.0)
    _write_vocabulary(writer, vocabulary, rng)
    embedding = _weights(rng, vocabulary, WIDTH, 1.0)
    _set_first_column(embedding, np.full(vocabulary, 4.0))
    output = _weights(rng, vocabulary, WIDTH, 0.01)
    _set_first_column(output, rng.standard_normal(vocabulary))
    writer.add_tensor("token_embd.weight", embedding, raw_dtype=_Q8)
    writer.add_tensor("output.weight", output, raw_dtype=_Q8)
    writer.add_tensor("output_norm.weight", np.ones(WIDTH, np.float32))
    for layer in range(layers):
        _add_layer(writer, f"blk.{layer}", rng)
    writer.write_header_to_file()
    writer.write_kv_data_to_file()
    writer.write_tensors_to_file()
    writer.close()


def _add_layer(writer: gguf.GGUFWriter, name: str, rng: np.random.Generator) -> None:
    for norm in ("attn_norm", "ffn_norm"):
        writer.add_tensor(f"{name}.{norm}.weight", np.ones(WIDTH, np.float32))
    keys = KEY_HEADS * _HEAD
    for part, rows in (("q", WIDTH), ("k", keys), ("v", keys)):
        weights = _weights(rng, rows, WIDTH, 0.02)
        writer.add_tensor(f"{name}.attn_{part}.weight", weights, raw_dtype=_Q8)
        writer.add_tensor(f"{name}.attn_{part}.bias", np.zeros(rows, np.float32))
    for part, rows, columns in (
        ("attn_output", WIDTH, WIDTH),
        ("ffn_gate", FEED_FORWARD, WIDTH),
        ("ffn_up", FEED_FORWARD, WIDTH),
        ("ffn_down", WIDTH, FEED_FORWARD),
    ):
        weights = _weights(rng, rows, columns, 0.02)
        if rows == WIDTH:  # what writes into the hidden state leaves its first channel alone
            weights[0] = 0
        writer.add_tensor(f"{name}.{part}.weight", weights, raw_dtype=_Q8)


def _weights(
    rng: np.random.Generator, rows: int, columns: int, deviation: float
) -> npt.NDArray[np.uint8]:
    """Return (rows, bytes) of q8_0: per block of 32 weights a float16 scale and 32 integers."""
    blocks = np.empty((rows, columns // _BLOCK, 2 + _BLOCK), np.uint8)
    integers = rng.integers(-127, 128, (rows, columns // _BLOCK, _BLOCK), np.int8)
    blocks[..., 2:] = integers.view(np.uint8)
    scale = np.array([deviation / _SPREAD], np.float16)
    blocks[..., :2] = scale.view(np.uint8)
    return blocks.reshape(rows, -1)


def _set_first_column(weights: npt.NDArray[np.uint8], values: npt.NDArray[np.float64]) -> None:
    """Give the first column its values; the 31 weights that share their scale become zero."""
    scales = (values / 127).astype(np.float16)
    weights[:, :2] = scales[:, None].view(np.uint8)
    weights[:, 2] = 127
    weights[:, 3 : 2 + _BLOCK] = 0


def _write_vocabulary(writer: gguf.GGUFWriter, size: int, rng: np.random.Generator) -> None:
    """Write the tokens of the questions, and words that nobody says up to the size."""
    tokenizer: Tokenizer = train_tokenizer(_texts(rng), _LEARNED_TOKENS)
    known: dict[str, int] = tokenizer.get_vocab(with_added_tokens=True)
    tokens = sorted(known, key=lambda token: known[token])
    tokens += _other_words(size - len(tokens), set(tokens), rng)
    merges = json.loads(tokenizer.to_str())["model"]["merges"]
    control, normal = gguf.TokenType.CONTROL, gguf.TokenType.NORMAL
    writer.add_tokenizer_model("gpt2")
    writer.add_tokenizer_pre(PRE_TOKENIZER)
    writer.add_token_list(tokens)
    writer.add_token_types([control if token in SPECIAL_TOKENS else normal for token in tokens])
    writer.add_token_merges([p if isinstance(p, str) else " ".join(p) for p in merges])
    writer.add_eos_token_id(known[END])
    writer.add_pad_token_id(known[PAD])
    writer.add_add_bos_token(False)
    writer.add_chat_template(CHAT_TEMPLATE)


def _other_words(count: int, taken: set[str], rng: np.random.Generator) -> list[str]:
    """Return words of 2 to 9 letters, half of them with the mark of a space in front."""
    alphabet = "abcdefghijklmnopqrstuvwxyzABCDEFGHIJKLMNOPQRSTUVWXYZ"
    words: dict[str, None] = {}
    while len(words) < count:
        letters = rng.integers(len(alphabet), size=(count, 9)).tolist()
        lengths = rng.integers(2, 10, size=count).tolist()
        spaces = rng.integers(2, size=count).tolist()
        for letter, length, space in zip(letters, lengths, spaces, strict=True):
            word = "Ġ" * space + "".join(alphabet[index] for index in letter[:length])
            if word not in taken:
                words[word] = None
    return list(words)[:count]


def _texts(rng: np.random.Generator) -> list[Example]:
    sentences = utterances(rng)
    return [
        Example([Turn("system", kind.task), Turn("user", next(sentences))], answer)
        for kind in KINDS
        for answer in kind.examples
        for _ in range(40)
    ]
