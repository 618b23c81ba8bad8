"""More words, or more pixels, for a model that was trained already: what it knows, it keeps."""

from collections.abc import Sequence
from dataclasses import replace
from typing import Any

import torch
from torch.nn import functional

from w2c.errors import ConfigError
from w2c_grounding.train.model import Size, new_model, new_processor

_EMBEDDINGS = "clip.text_model.embeddings.token_embedding.weight"
_POSITIONS = "clip.vision_model.embeddings.position_embedding.weight"


def with_words(model: Any, processor: Any, size: Size, words: Sequence[str]) -> tuple[Any, Any]:
    """Return model and processor for which each of these words is one token.

    A new word begins as the mean of the pieces in which it was spelt before, so that the model
    answers to it as it did; one that no piece spells begins as the mean of all tokens.

    Args:
        model: Of `new_model`.
        processor: Of `new_processor`.
        size: Of the model.
        words: All that shall be one token, those that are one already among them.
    """
    old = processor.tokenizer
    if all(len(old(word, add_special_tokens=False)["input_ids"]) == 1 for word in words):
        return model, processor
    grown = new_processor(size, words)
    ids: dict[str, int] = old.get_vocab()
    state = dict(model.state_dict())
    known = state[_EMBEDDINGS]
    rows = torch.empty(len(grown.tokenizer), known.shape[1])
    for token, number in grown.tokenizer.get_vocab().items():
        if token in ids:
            rows[number] = known[ids[token]]
            continue
        pieces = old(token.removesuffix("</w>"), add_special_tokens=False)["input_ids"]
        rows[number] = known[pieces].mean(dim=0) if pieces else known.mean(dim=0)
    result = new_model(size, len(grown.tokenizer))
    result.load_state_dict({**state, _EMBEDDINGS: rows})
    return result, grown


def with_side(model: Any, processor: Any, size: Size, side: int) -> tuple[Any, Any, Size]:
    """Return model, processor and size for pictures of another side [px].

    Places between the old ones get what lies between: the same patches see a finer picture.

    Args:
        model: Of `new_model`.
        processor: Of `new_processor`; changed.
        size: Of the model.
        side: Wanted, a multiple of the patch.

    Raises:
        ConfigError: it is no multiple of the patch.
    """
    if side == size.image:
        return model, processor, size
    larger = resized(size, side)
    state = dict(model.state_dict())
    first, places = state[_POSITIONS][:1], state[_POSITIONS][1:]
    grid = places.T.reshape(1, -1, size.cells, size.cells)
    finer = functional.interpolate(
        grid, size=(larger.cells, larger.cells), mode="bicubic", align_corners=False
    )
    state[_POSITIONS] = torch.cat([first, finer[0].flatten(1).T])
    result = new_model(larger, len(processor.tokenizer))
    result.load_state_dict(state)
    processor.image_processor.size = {"height": side, "width": side}
    return result, processor, larger


def resized(size: Size, side: int) -> Size:
    """Return the size of a model for pictures of another side [px]. Raises ConfigError."""
    if side % size.patch:
        below = side // size.patch * size.patch
        raise ConfigError(
            f"a side of {side} px is no multiple of the patch of {size.patch}: use "
            f"{max(below, size.patch)} or {below + size.patch}"
        )
    return replace(size, image=side)
