"""What `w2c bench language` compares is the same question, and what it counts is what was done."""

import json
from pathlib import Path

import numpy as np
import pytest

from w2c_llm.bench import random_model
from w2c_llm.bench.questions import KINDS, Kind, prefix_of, question, utterances
from w2c_llm.bench.trial import compare
from w2c_llm.schema import check_schema
from w2c_llm.values import violation


@pytest.fixture(scope="module")
def small_model(tmp_path_factory: pytest.TempPathFactory) -> Path:
    """Return the random model with one layer and a vocabulary that is a little too large."""
    path = tmp_path_factory.mktemp("models") / "random.gguf"
    random_model.write_random_model(path, np.random.default_rng(0), layers=1, vocabulary=3000)
    return path


def test_both_ways_give_the_same_answers_at_the_counted_cost(small_model: Path) -> None:
    """Of five kinds in turn only the new words are evaluated here, and all of them there."""
    found = compare(small_model, rounds=1, threads=1, seed=0, prefix_tokens=60)
    assert len(found.first) == len(KINDS)
    assert [pair.case for pair in found.pairs] == [kind.name for kind in KINDS]
    assert found.model == "random weights"
    for pair in found.pairs:
        assert pair.ours.text == pair.plain.text
        assert pair.ours.prompt_tokens < 45
        assert 60 < pair.plain.prompt_tokens < 160
        assert 1 <= pair.ours.answer_tokens <= pair.plain.answer_tokens
        assert pair.ours.milliseconds > 0.0
    assert all(cost.prompt_tokens > 60 for cost in found.first), "the prefix is counted once"


def test_the_model_is_made_once_and_the_same_for_a_seed(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    written: list[Path] = []

    def write(path: Path, _: np.random.Generator) -> None:
        written.append(path)
        path.write_bytes(b"model")

    monkeypatch.setattr(random_model, "write_random_model", write)
    first = random_model.random_model(tmp_path / "cache")
    assert first == random_model.random_model(tmp_path / "cache")
    assert len(written) == 1
    assert first.read_bytes() == b"model"


@pytest.mark.parametrize("kind", KINDS, ids=lambda kind: kind.name)
def test_the_examples_of_a_prefix_are_answers_of_its_schema(kind: Kind) -> None:
    for answer in kind.examples:
        assert violation(json.loads(answer), check_schema(kind.schema)) is None
    rng = np.random.default_rng(0)
    prefix = prefix_of(kind, 50, lambda messages: sum(len(m.content) for m in messages) // 4, rng)
    assert prefix[0].content == kind.task
    assert prefix[-1].role == "assistant"
    request = question(kind, prefix, next(utterances(rng)))
    assert request.constant_messages == len(prefix) == len(request.messages) - 1
