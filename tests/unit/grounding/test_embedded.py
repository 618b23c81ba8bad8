"""The model in the repository, on pictures of the head camera that it was not trained on."""

import json
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from msgspec.structs import replace

from w2c.messages import GroundingReply, GroundingRequest
from w2c_grounding.answer import Grounder
from w2c_grounding.model_config import ModelConfig
from w2c_grounding.registry import EMBEDDED, load

DATA = Path(__file__).parents[2] / "data" / "grounding"
PICTURES: list[dict[str, Any]] = json.loads((DATA / "pictures.json").read_text())
LIMIT_BYTES = 30_000_000


@pytest.fixture(scope="module")
def grounder() -> Grounder:
    return Grounder(*load(ModelConfig(threads=1)))


def ask(grounder: Grounder, file: str, *phrases: str) -> GroundingReply:
    jpeg = (DATA / file).read_bytes()
    return grounder.ground(GroundingRequest(jpeg=jpeg, phrases=list(phrases), want="boxes"))


@pytest.mark.parametrize("row", PICTURES, ids=[row["file"] for row in PICTURES])
def test_it_points_at_what_is_named(grounder: Grounder, row: dict[str, Any]) -> None:
    reply = ask(grounder, row["file"], *row["present"])
    for answer in reply.evidence:
        assert answer.found, f"{answer.phrase}: score {answer.score:.2f}"
        assert answer.point is not None
        u, v = answer.point
        inside = [
            left <= u < right and top <= v < bottom
            for left, top, right, bottom in row["present"][answer.phrase]
        ]
        assert any(inside), f"{answer.phrase}: point {answer.point}"


@pytest.mark.parametrize("row", PICTURES, ids=[row["file"] for row in PICTURES])
def test_it_does_not_find_what_is_not_there(grounder: Grounder, row: dict[str, Any]) -> None:
    for answer in ask(grounder, row["file"], *row["absent"]).evidence:
        assert not answer.found, f"{answer.phrase}: score {answer.score:.2f}"


def test_it_knows_which_words_it_never_saw(grounder: Grounder) -> None:
    first, second = ask(grounder, PICTURES[0]["file"], "the elephant", "the red book").evidence
    assert first.unknown_words == ["elephant"]
    assert second.unknown_words == []


def test_a_name_with_a_word_of_size_is_a_name() -> None:
    family, _ = load(ModelConfig(threads=1))
    plain, _ = load(ModelConfig(threads=1), lambda card: replace(card, compares_sizes=False))
    image = np.zeros((90, 160, 3), np.uint8)
    (named,), (asked,) = (
        one.query(one.prepare(image), ["small shovel"]) for one in (family, plain)
    )
    assert np.array_equal(named.heatmap, asked.heatmap)
    (other,) = plain.query(plain.prepare(image), ["shovel"])
    assert not np.array_equal(named.heatmap, other.heatmap)


def test_it_is_small_has_a_card_and_no_training_state() -> None:
    files = sorted(path.name for path in EMBEDDED.iterdir())
    assert sum(path.stat().st_size for path in EMBEDDED.iterdir()) <= LIMIT_BYTES
    assert {"CARD.md", "grounding.json", "config.json", "model.safetensors"} <= set(files)
    assert not [name for name in files if name.endswith((".pt", ".tmp"))]
