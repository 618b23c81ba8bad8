"""What a model says is checked, repaired once, and given up with a reason."""

import math

import pytest
from hypothesis import given
from hypothesis import strategies as st

from fakes.language_model import ScriptedBackend
from w2c.clock import RealClock, StepClock
from w2c.errors import DeadlineError, ModelError, RefusedError
from w2c.messages import ChatMessage, ChooseRequest, CompleteRequest
from w2c_llm.answering import choose, complete, softmax
from w2c_llm.backend import Budget

CHAT = [ChatMessage(role="user", content="which hand?")]
SCHEMA = {
    "type": "object",
    "properties": {"hand": {"enum": ["left", "right"]}},
    "required": ["hand"],
}


def minute() -> Budget:
    return Budget(RealClock(), 60.0)


def request(**changes: object) -> CompleteRequest:
    return CompleteRequest(**{"messages": CHAT, "schema": SCHEMA, **changes})  # type: ignore[arg-type]


def test_an_answer_that_fits_is_returned_with_its_value() -> None:
    backend = ScriptedBackend(['{"hand": "left"}'])
    answer = complete(backend, request(), minute())
    assert answer.value == {"hand": "left"}
    assert len(backend.chats) == 1


@pytest.mark.parametrize(
    "wrong", ["left", '{"hand": "foot"}', "{}", "NaN", "[" * 100_000, '{"hand": "left"', ""]
)
def test_a_wrong_answer_is_shown_to_the_model_which_may_repair_it(wrong: str) -> None:
    backend = ScriptedBackend([wrong, '{"hand": "right"}'])
    answer = complete(backend, request(), minute())
    assert answer.value == {"hand": "right"}
    assert answer.usage.completion_tokens == 6, "both attempts are counted"
    roles = [message.role for message in backend.chats[1]]
    assert roles == ["user", "assistant", "user"]


def test_two_wrong_answers_are_a_failure_that_names_both_reasons() -> None:
    backend = ScriptedBackend(["left", '{"hand": "foot"}', '{"hand": "left"}'])
    with pytest.raises(ModelError, match=r"not JSON.*must be one of"):
        complete(backend, request(), minute())
    assert len(backend.chats) == 2


@pytest.mark.parametrize(
    ("changes", "reason"),
    [
        ({"schema": {"type": "string"}}, "maxLength"),
        ({"constant_messages": 1}, "constant_messages"),
        ({"constant_messages": -1}, "constant_messages"),
        ({"messages": [ChatMessage(role="assistant", content="hm")]}, "must be of the user"),
    ],
)
def test_a_request_that_makes_no_sense_never_reaches_the_model(
    changes: dict[str, object], reason: str
) -> None:
    backend = ScriptedBackend([])
    with pytest.raises(RefusedError, match=reason):
        complete(backend, request(**changes), minute())
    assert backend.chats == []


def test_a_spent_budget_ends_the_request() -> None:
    clock = StepClock()
    budget = Budget(clock, 2.0)
    clock.set(2_000_000_000)
    with pytest.raises(DeadlineError, match="2 s"):
        complete(ScriptedBackend(['{"hand": "left"}']), request(), budget)


def ask(prior: dict[str, float], likelihoods: list[float]) -> dict[str, float]:
    options = [f"option {index}" for index in range(len(likelihoods))]
    asked = ChooseRequest(messages=CHAT, options=options, log_prior=prior)
    return choose(ScriptedBackend(likelihoods=likelihoods), asked, minute()).probabilities


@given(st.lists(st.floats(-500, 0), min_size=2, max_size=32))
def test_probabilities_sum_to_one(likelihoods: list[float]) -> None:
    probabilities = ask({}, likelihoods)
    assert math.fsum(probabilities.values()) == pytest.approx(1.0)
    assert (
        max(probabilities.values())
        == probabilities[f"option {likelihoods.index(max(likelihoods))}"]
    )


def test_a_prior_shifts_the_odds_by_exactly_its_size() -> None:
    before, after = ask({}, [-1.0, -2.0]), ask({"option 1": 1.5}, [-1.0, -2.0])
    odds = [p["option 1"] / p["option 0"] for p in (before, after)]
    assert odds[1] / odds[0] == pytest.approx(math.exp(1.5))


@pytest.mark.parametrize("prior", [{"ghost": 1.0}, {"option 0": math.nan}, {"option 0": math.inf}])
def test_a_prior_without_meaning_is_refused(prior: dict[str, float]) -> None:
    with pytest.raises(RefusedError, match="log_prior"):
        ask(prior, [-1.0, -2.0])


def test_options_that_repeat_are_refused() -> None:
    with pytest.raises(RefusedError, match="repeat"):
        choose(ScriptedBackend(), ChooseRequest(messages=CHAT, options=["a", "a"]), minute())


def test_no_possible_option_is_a_failure_of_the_model() -> None:
    with pytest.raises(ModelError):
        softmax([-math.inf, -math.inf])
