"""Answers from a recording: the same question gets the same answer, another one a refusal."""

from pathlib import Path
from typing import Any

import pytest

from fakes.language_model import ScriptedBackend
from support.recordings import raw_message, write_recording
from w2c import topics
from w2c.bus import RawReceived
from w2c.bus.inprocess import InProcessHub
from w2c.bus.interface import CallContext
from w2c.clock import RealClock
from w2c.errors import ConfigError, RefusedError
from w2c.messages import (
    CallTrace,
    ChatMessage,
    ChooseReply,
    ChooseRequest,
    CompleteReply,
    CompleteRequest,
)
from w2c_llm.answering import choose, complete
from w2c_llm.backend import Budget
from w2c_llm.config import LlmConfig
from w2c_llm.node import make_backend
from w2c_llm.replay_backend import ReplayBackend

SCHEMA: dict[str, Any] = {
    "type": "object",
    "properties": {"hand": {"enum": ["left", "right"]}, "task": {"enum": ["reach", "contact"]}},
    "required": ["hand", "task"],
}
TEXT = '{"hand":"left","task":"reach"}'
OPTIONS = ["yes", "no", "maybe"]


def chat(text: str) -> list[ChatMessage]:
    return [ChatMessage(role="system", content="task"), ChatMessage(role="user", content=text)]


def asked(text: str, **changes: Any) -> CompleteRequest:
    return CompleteRequest(**{"messages": chat(text), "schema": SCHEMA, **changes})


def minute() -> Budget:
    return Budget(RealClock(), 60.0)


def answer_completion(request: CompleteRequest, _: CallContext) -> CompleteReply:
    answer = complete(ScriptedBackend([TEXT]), request, minute())
    return CompleteReply(
        text=answer.text,
        value=answer.value,
        model="teacher",
        prompt_tokens=9,
        reused_tokens=4,
        completion_tokens=7,
        queue_ms=0.0,
        prefill_ms=1.0,
        decode_ms=2.0,
    )


def answer_choice(request: ChooseRequest, _: CallContext) -> ChooseReply:
    choice = choose(ScriptedBackend(likelihoods=[-1.0, -2.0, -5.0]), request, minute())
    return ChooseReply(
        option=choice.option,
        probabilities=choice.probabilities,
        model="teacher",
        prompt_tokens=9,
        reused_tokens=4,
        queue_ms=0.0,
        prefill_ms=1.0,
    )


def record(path: Path) -> None:
    """Record a service that answers two questions and refuses one, through the bus."""
    hub = InProcessHub()
    server, caller, recorder = hub.connect("llm"), hub.connect("dialogue"), hub.connect("recorder")
    server.serve(topics.COMPLETE, answer_completion)
    server.serve(topics.CHOOSE, answer_choice)
    queue = recorder.raw_queue("**")
    caller.call(topics.COMPLETE, asked("the cup", constant_messages=1, deadline=9.0))
    with pytest.raises(RefusedError):
        caller.call(topics.COMPLETE, asked("the wall", schema={"type": "string"}))
    caller.call(
        topics.CHOOSE,
        ChooseRequest(messages=chat("ok"), options=OPTIONS, log_prior={"no": 3.0}),
    )
    received: list[RawReceived] = []
    while (raw := queue.receive(0.2)) is not None:
        received.append(raw)
    write_recording(path, received)


@pytest.fixture(scope="module")
def recording(tmp_path_factory: pytest.TempPathFactory) -> Path:
    path = tmp_path_factory.mktemp("replay") / "session.mcap"
    record(path)
    return path


@pytest.fixture
def backend(recording: Path) -> ReplayBackend:
    return ReplayBackend(recording)


def test_a_recorded_request_gets_its_answer_again_and_again(backend: ReplayBackend) -> None:
    for _ in range(2):
        answer = complete(backend, asked("the cup"), minute())
        assert answer.value == {"hand": "left", "task": "reach"}
        assert answer.usage.completion_tokens == 7
    assert backend.name == "replay of teacher"


@pytest.mark.parametrize(
    "changes",
    [
        {"seed": 1},
        {"temperature": 0.5},
        {"max_tokens": 10},
        {"messages": chat("the cup ")},
        {"schema": {**SCHEMA, "properties": dict(reversed(SCHEMA["properties"].items()))}},
    ],
)
def test_another_request_is_refused_and_the_refusal_says_so(
    backend: ReplayBackend, changes: dict[str, Any]
) -> None:
    with pytest.raises(RefusedError, match="not asked in that recording") as caught:
        complete(backend, asked("the cup", **changes), minute())
    assert "the cup" in str(caught.value)


def test_what_was_refused_then_is_not_an_answer(backend: ReplayBackend) -> None:
    with pytest.raises(RefusedError, match="maxLength"):
        complete(backend, asked("the wall", schema={"type": "string"}), minute())
    with pytest.raises(RefusedError, match="not asked"):
        complete(backend, asked("the wall"), minute())


def test_a_choice_is_replayed_without_its_prior_which_may_be_another_one(
    backend: ReplayBackend,
) -> None:
    expected = choose(
        ScriptedBackend(likelihoods=[-1.0, -2.0, -5.0]),
        ChooseRequest(messages=chat("ok"), options=OPTIONS),
        minute(),
    )
    reordered = ChooseRequest(messages=chat("ok"), options=OPTIONS[::-1])
    found = choose(backend, reordered, minute())
    assert found.option == expected.option == "yes"
    assert found.probabilities == pytest.approx(expected.probabilities)
    with pytest.raises(RefusedError, match="`choose`"):
        choose(backend, ChooseRequest(messages=chat("ok"), options=OPTIONS[:2]), minute())


def test_a_file_that_is_none_or_holds_no_answers_is_named(tmp_path: Path) -> None:
    with pytest.raises(ConfigError, match="no recording at"):
        ReplayBackend(tmp_path / "none.mcap")
    (tmp_path / "text.mcap").write_text("hello")
    with pytest.raises(ConfigError, match=r"text\.mcap"):
        ReplayBackend(tmp_path / "text.mcap")
    write_recording(tmp_path / "empty.mcap", [])
    with pytest.raises(ConfigError, match="no answer of a language model"):
        ReplayBackend(tmp_path / "empty.mcap")


def test_calls_of_another_version_are_skipped_with_a_warning(
    tmp_path: Path, caplog: pytest.LogCaptureFixture
) -> None:
    trace = CallTrace(
        service="llm",
        method="complete",
        instance="0",
        outcome="ok",
        duration_ms=1.0,
        request=b"old",
        reply=b"older",
        error="",
    )
    key = topics.TRACE.key("test", "dialogue")
    write_recording(tmp_path / "old.mcap", [raw_message(trace, key, sender="dialogue")])
    with pytest.raises(ConfigError, match="no answer"):
        ReplayBackend(tmp_path / "old.mcap")
    assert "recorded calls not read" in caplog.text


def test_the_service_takes_a_recording_as_its_model(recording: Path) -> None:
    config = LlmConfig(robot="talos", backend="replay", model=str(recording))
    assert make_backend(config).name == "replay of teacher"
    with pytest.raises(ConfigError, match="needs --model"):
        make_backend(LlmConfig(robot="talos", backend="replay"))
