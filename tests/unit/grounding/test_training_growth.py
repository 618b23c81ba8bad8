"""A trained model that is given more words, or more pixels, keeps what it knows."""

from pathlib import Path
from typing import Any

import pytest
import torch

from w2c.errors import ConfigError
from w2c_grounding.card import ModelCard
from w2c_grounding.train.growth import with_side, with_words
from w2c_grounding.train.model import Size, embed, features, new_model, new_processor, read, save

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


def test_a_finer_picture_shows_the_same_at_the_same_place(small: tuple[Any, Any]) -> None:
    model, processor = small
    positions = model.clip.vision_model.embeddings.position_embedding.weight
    with torch.no_grad():  # a slope: what lies between is known
        rows = torch.arange(4.0).repeat_interleave(4)
        positions[1:] = rows[:, None].expand(16, 32)
    finer, _, size = with_side(model, processor, SIZE, 128)
    assert size.cells == 8
    found = finer.clip.vision_model.embeddings.position_embedding.weight[1:].view(8, 8, 32)
    # The rows in the middle: the cubic at the edges knows no slope, and bends a little.
    torch.testing.assert_close(found[3, 0], torch.full((32,), 1.25), atol=0.06, rtol=0.0)
    torch.testing.assert_close(found[4, 7], torch.full((32,), 1.75), atol=0.06, rtol=0.0)
    assert features(finer, torch.zeros(1, 3, 128, 128))[0].shape == (1, 65, 32)


def test_a_model_of_another_side_is_read_as_such(small: tuple[Any, Any], tmp_path: Path) -> None:
    finer, processor, size = with_side(*small, SIZE, 96)
    save(finer, processor, ModelCard(name="finer"), tmp_path)
    _, processor, found = read(tmp_path)
    assert found == size
    assert processor.image_processor.size["height"] == 96


def test_the_same_side_changes_nothing(small: tuple[Any, Any]) -> None:
    assert with_side(*small, SIZE, SIZE.image) == (*small, SIZE)


def test_a_side_that_patches_do_not_fill_is_refused(small: tuple[Any, Any]) -> None:
    with pytest.raises(ConfigError, match="use 64 or 80"):
        with_side(*small, SIZE, 70)
