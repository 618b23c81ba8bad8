"""More words for a model that was trained already: its own keep what they mean."""

from collections.abc import Sequence
from typing import Any

import torch

from w2c_grounding.train.model import Size, new_model, new_processor

_EMBEDDINGS = "clip.text_model.embeddings.token_embedding.weight"


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
