"""The cache of key and value: what is kept is right, what breaks leaves nothing behind."""

from collections.abc import Iterator
from pathlib import Path

import numpy as np
import pytest

from w2c.clock import RealClock, StepClock
from w2c.errors import DeadlineError, ModelError, RefusedError
from w2c_llm.backend import Budget
from w2c_llm.llama_model import LlamaModel
from w2c_llm.sequences import Sequences, _groups

PREFIX = [20 + index % 90 for index in range(50)]
PROMPT = [*PREFIX, 31, 32, 33]


class Impatient(Budget):
    """Lets so many checks pass."""

    def __init__(self, checks: int) -> None:
        super().__init__(StepClock(), 9.0)
        self._left = checks

    def check(self) -> None:
        self._left -= 1
        if self._left < 0:
            raise DeadlineError("enough")


@pytest.fixture(scope="module")
def model(tiny_model: Path) -> Iterator[LlamaModel]:
    model = LlamaModel(tiny_model)
    yield model
    model.close()


@pytest.fixture
def sequences(model: LlamaModel) -> Iterator[Sequences]:
    sequences = Sequences(model, 256, threads=1, batch=16)
    yield sequences
    sequences.close()


@pytest.fixture
def expected(model: LlamaModel, budget: Budget) -> np.ndarray:
    """Return the logits after the prompt, evaluated in one piece in a context of its own."""
    fresh = Sequences(model, 256, threads=1, batch=256)
    logits = fresh.begin(PROMPT, 0, 4, budget).logits
    fresh.close()
    return logits


@pytest.mark.parametrize("prefix_length", [0, 1, 16, 50, 52])
def test_the_cut_between_prefix_and_rest_changes_nothing(
    sequences: Sequences, expected: np.ndarray, budget: Budget, prefix_length: int
) -> None:
    for _ in range(2):
        logits = sequences.begin(PROMPT, prefix_length, 4, budget).logits
        np.testing.assert_allclose(logits, expected, atol=2e-2)


@pytest.mark.parametrize("checks", range(5))
def test_a_prefix_that_breaks_off_half_way_leaves_nothing_behind(
    sequences: Sequences, expected: np.ndarray, budget: Budget, checks: int
) -> None:
    """The prefix takes four batches: it ends after each, and before the rest."""
    with pytest.raises(DeadlineError):
        sequences.begin(PROMPT, len(PREFIX), 4, Impatient(checks))
    again = sequences.begin(PROMPT, len(PREFIX), 4, budget)
    assert again.reused_tokens == (len(PREFIX) if checks == 4 else 0)
    np.testing.assert_allclose(again.logits, expected, atol=2e-2)


def test_a_failure_of_llama_cpp_is_an_error_and_the_next_request_is_right(
    sequences: Sequences, expected: np.ndarray, budget: Budget
) -> None:
    sequences.begin(PROMPT, len(PREFIX), 4, budget)
    with pytest.raises(ModelError, match="failed to evaluate"):
        sequences.extend([40] * 400, budget)
    again = sequences.begin(PROMPT, len(PREFIX), 4, budget)
    assert again.reused_tokens == 0, "everything was forgotten"
    np.testing.assert_allclose(again.logits, expected, atol=2e-2)


def test_what_cannot_fit_is_refused_before_anything_is_evaluated(
    sequences: Sequences, budget: Budget
) -> None:
    with pytest.raises(RefusedError, match="53 tokens of prompt and 204 of answer exceed"):
        sequences.begin(PROMPT, 0, 204, budget)
    assert sequences.evaluated_tokens == 0


def test_the_context_is_rounded_up_as_llama_cpp_does(model: LlamaModel) -> None:
    sequences = Sequences(model, 100, threads=1)
    assert sequences.cells == 256
    sequences.close()
    sequences.close()


@pytest.mark.parametrize(
    ("count", "length", "batches"), [(3, 3, 1), (32, 3, 1), (33, 1, 2), (4, 30, 2), (2, 80, 2)]
)
def test_options_go_in_one_batch_as_long_as_they_fit(count: int, length: int, batches: int) -> None:
    options = [[index] * length for index in range(count)]
    groups = _groups(options)
    assert len(groups) == batches
    assert [option for group in groups for option in group] == options


def test_more_options_than_sequences_are_scored_in_groups(
    sequences: Sequences, budget: Budget
) -> None:
    after = sequences.begin(PROMPT, len(PREFIX), 90, budget).logits
    options = [[40 + index, 41, 42] for index in range(40)]
    together = sequences.continuations(after, options, budget)
    alone = [sequences.continuations(after, [option], budget)[0] for option in options]
    np.testing.assert_allclose(together, alone, atol=5e-2)
    assert budget.remaining_s() > 0


def test_time_is_checked_between_the_groups_of_a_choice(
    sequences: Sequences, budget: Budget
) -> None:
    after = sequences.begin(PROMPT, 0, 60, budget).logits
    late = Budget(RealClock(), 60.0)
    late.cancel(DeadlineError("gone"))
    with pytest.raises(DeadlineError, match="gone"):
        sequences.continuations(after, [[40, 41]], late)
