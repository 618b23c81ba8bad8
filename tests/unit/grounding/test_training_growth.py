"""A trained model that is given more words keeps what its own words mean."""

from typing import Any

import pytest
import torch

from w2c_grounding.train.growth import with_words
from w2c_grounding.train.model import Size, embed, new_model, new_processor

SIZE = Size(image=64, patch=16, width=32, layers=2, heads=2, extract=(0, 1), reduced=16)
WORDS = ["red", "blue", "cup", "book", "the", "plate"]


def embedded(model: Any, processor: Any, phrase: str) -> torch.Tensor:
    tokens = processor.tokenizer([phrase], return_tensors="pt")
    with torch.no_grad():
        return embed(model, tokens)


@pytest.fixture
def small() -> tuple[Any, Any]:
    torch.manual_seed(3)
    processor = new_processor(SIZE, WORDS)
    return new_model(SIZE, len(processor.tokenizer)).eval(), processor


def test_known_phrases_mean_what_they_meant(small: tuple[Any, Any]) -> None:
    model, processor = small
    grown, more = with_words(model, processor, SIZE, [*WORDS, "drink", "crockery"])

    spelled = processor.tokenizer("drink crockery", add_special_tokens=False)["input_ids"]
    assert len(spelled) > 2
    assert len(more.tokenizer("drink crockery", add_special_tokens=False)["input_ids"]) == 2
    for phrase in ("red cup", "the blue book", "plate"):
        torch.testing.assert_close(
            embedded(grown.eval(), more, phrase), embedded(model, processor, phrase)
        )


def test_a_new_word_begins_as_the_mean_of_its_pieces(small: tuple[Any, Any]) -> None:
    model, processor = small
    grown, more = with_words(model, processor, SIZE, [*WORDS, "drink"])
    rows = [one.clip.text_model.embeddings.token_embedding.weight for one in (model, grown)]

    pieces = processor.tokenizer("drink", add_special_tokens=False)["input_ids"]
    (number,) = more.tokenizer("drink", add_special_tokens=False)["input_ids"]
    torch.testing.assert_close(rows[1][number], rows[0][pieces].mean(dim=0))


def test_without_new_words_nothing_is_made_anew(small: tuple[Any, Any]) -> None:
    model, processor = small
    assert with_words(model, processor, SIZE, WORDS) == (model, processor)
