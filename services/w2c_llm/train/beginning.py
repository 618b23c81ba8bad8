"""The network and the tokenizer of a run: new ones, those of other models, or those it had."""

import random
from collections.abc import Sequence
from dataclasses import replace
from pathlib import Path

from w2c.errors import ConfigError
from w2c_llm.train.corpus import Example
from w2c_llm.train.mean import read_origins
from w2c_llm.train.network import NetworkSize, make_network
from w2c_llm.train.origin import Origin, read_origin
from w2c_llm.train.plan import Shape
from w2c_llm.train.tokenizer import train_tokenizer

_TOKENIZER_EXAMPLES = 40_000
"""More than enough for the merges, and fast"""
_WIDTH, _FEED_FORWARD, _VOCABULARY = 256, 768, 4096


def final_layers(shape: Shape, origin: Origin) -> int:
    """Return how many layers a network has at the end of its run."""
    return origin.size.layers if shape.begin_layers is None else shape.new_layers


def new(corpus: Sequence[Example], shape: Shape, seed: int) -> Origin:
    """Return random weights, and a tokenizer made for a corpus."""
    sample = random.Random(seed).sample(  # noqa: S311 - not a secret
        corpus, min(_TOKENIZER_EXAMPLES, len(corpus))
    )
    tokenizer = train_tokenizer(sample, shape.vocabulary or _VOCABULARY)
    width = shape.width or _WIDTH
    size = NetworkSize(
        width,
        shape.begin_layers or shape.new_layers,
        width // 64,
        shape.feed_forward or _FEED_FORWARD,
    )
    return Origin(make_network(size, tokenizer.get_vocab_size(), seed), tokenizer, size)


def continued(paths: Sequence[Path], shape: Shape) -> Origin:
    """Return the mean of other models. Raises ConfigError where it has not this shape."""
    origin = read_origins(paths, shape.layers)
    _expect_shape(paths[0], origin, shape)
    return origin


def resumed(checkpoint: Path, shape: Shape) -> Origin:
    """Return what a checkpoint holds. Raises ConfigError where it has not this shape."""
    origin = read_origin(checkpoint)
    if (shape.vocabulary or 0) > origin.tokenizer.get_vocab_size():
        shape = replace(shape, vocabulary=None)  # a small corpus has fewer tokens than allowed
    if origin.size.layers == shape.begin_layers:
        shape = replace(shape, layers=None)  # it was stopped before it grew
    _expect_shape(checkpoint, origin, shape)
    return origin


def _expect_shape(path: Path, origin: Origin, wanted: Shape) -> None:
    """Refuse flags that say another shape than the file's: its weights fit no other."""
    found = {
        "--layers": (wanted.layers, origin.size.layers),
        "--width": (wanted.width, origin.size.width),
        "--feed-forward": (wanted.feed_forward, origin.size.feed_forward),
        "--vocabulary": (wanted.vocabulary, origin.tokenizer.get_vocab_size()),
    }
    for flag, (value, actual) in found.items():
        if value is not None and value != actual:
            raise ConfigError(
                f"{flag} is {value}, {path} has {actual}: its weights and its tokenizer belong "
                f"together; leave {flag} out"
            )
