"""Models are compared by score: how near two answers are, and what is not asked again."""

from collections.abc import Callable, Iterator, Sequence
from typing import Any

import msgspec
import numpy as np
import pytest

from w2c.bus import Envelope
from w2c.errors import ConfigError, RecordingError
from w2c.messages import (
    Box,
    ChatMessage,
    ChooseReply,
    ChooseRequest,
    CompleteReply,
    CompleteRequest,
    GroundingReply,
    Health,
    PhraseEvidence,
)
from w2c.through import Asked, Compared, Heard, Skipped, configuration
from w2c.topics import HEALTH, Topic
from w2c_grounding.replaying.through import overlap, reply_differences
from w2c_llm.backend import Budget, Generation, JsonSchema, Sampling, Scores, Usage
from w2c_llm.config import LlmConfig
from w2c_llm.replaying import through as llm

CHAT = [ChatMessage(role="system", content="select"), ChatMessage(role="user", content="up")]
COST: dict[str, Any] = {"prompt_tokens": 1, "reused_tokens": 0, "queue_ms": 0.0, "prefill_ms": 0.0}


class Written:
    """A session of these calls, and of one health report."""

    def __init__(self, calls: Sequence[Asked], facts: dict[str, str] | None = None) -> None:
        self._calls = calls
        self._facts = facts or {}

    def asked(self, *_services: str) -> Iterator[Asked]:
        yield from self._calls

    def heard(self, *_rows: Topic[Any]) -> Iterator[Heard]:
        health = Health(
            stamp_ns=0, service="llm", instance="0", phase="ready", facts=self._facts,
            pid=1, cpu_percent=0.0, memory_mb=1.0,
        )  # fmt: skip
        envelope = Envelope(1, "test", "llm", "boot", 0, 0, 0, [], None)
        yield Heard(HEALTH, health, envelope, HEALTH.key("test", "llm"), 0.0)


class Sure:
    """A model that prefers the first option, by so much, and says one thing."""

    name = "sure"

    def __init__(self, first: float = 3.0, text: str = '{"x": 1}') -> None:
        self._first = first
        self._text = text

    def warm_up(self) -> None:
        """Nothing."""

    def close(self) -> None:
        """Nothing."""

    def generate(self, _m: object, _s: JsonSchema, _p: Sampling, _c: int, _b: Budget) -> Generation:
        return Generation(self._text, True, Usage())

    def score(self, _m: object, options: Sequence[str], _c: int, _b: Budget) -> Scores:
        return Scores([self._first, *(0.0 for _ in options[1:])], Usage())


def call(request: CompleteRequest | ChooseRequest, reply: CompleteReply | ChooseReply) -> Asked:
    method = "complete" if isinstance(request, CompleteRequest) else "choose"
    return Asked("llm", method, "ok", "", request, reply, "dialogue", "b", (), None, 0.0, 1.0)


SCHEMA = {"type": "object", "properties": {"x": {"type": "integer"}}, "required": ["x"]}
WROTE = call(
    CompleteRequest(messages=CHAT, schema=SCHEMA),
    CompleteReply(
        text='{"x": 1}', value={"x": 1}, model="sure", completion_tokens=1, decode_ms=0.0, **COST
    ),
)
CHOSE = call(
    ChooseRequest(messages=CHAT, options=["a", "b"]),
    ChooseReply(option="a", probabilities={"a": 0.9525, "b": 0.0475}, model="sure", **COST),
)


@pytest.fixture
def ask(monkeypatch: pytest.MonkeyPatch) -> Callable[[Sure], list[Compared | Skipped]]:
    """Ask a model all that was asked."""

    def work(model: Sure) -> list[Compared | Skipped]:
        monkeypatch.setattr(llm, "make_backend", lambda _config: model)
        return list(llm.through(Written([WROTE, CHOSE]), None))

    return work


def test_the_same_model_answers_within_the_tolerance(
    ask: Callable[[Sure], list[Compared | Skipped]],
) -> None:
    wrote, chose = ask(Sure())
    assert isinstance(wrote, Compared) and not wrote.found
    assert isinstance(chose, Compared) and chose.found and not chose.differs()
    assert chose.differs(1e-6)


@pytest.mark.parametrize("model", [Sure(first=-3.0), Sure(first=1.0), Sure(text='{"x": 2}')])
def test_another_answer_is_a_difference(
    ask: Callable[[Sure], list[Compared | Skipped]], model: Sure
) -> None:
    assert any(isinstance(one, Compared) and one.differs() for one in ask(model))


def test_a_server_is_not_asked_again() -> None:
    config = LlmConfig(robot="test", backend="openai", model="big")
    facts = {"configuration": msgspec.json.encode(config).decode()}
    assert configuration(Written([], facts), "llm", LlmConfig) == config
    with pytest.raises(ConfigError, match="a server is not asked again"):
        list(llm.through(Written([], facts), None))
    assert configuration(Written([]), "llm", LlmConfig) == LlmConfig(robot="test")
    with pytest.raises(RecordingError, match="does not understand"):
        configuration(Written([], {"configuration": '{"queue": "long"}'}), "llm", LlmConfig)


def reply(
    score: float = 0.8, left: float = 10.0, heat: int = 100, found: bool = True
) -> GroundingReply:
    box = Box(left=left, top=10.0, right=left + 100.0, bottom=60.0, score=score)
    evidence = PhraseEvidence(
        phrase="book",
        found=found,
        score=score,
        point=(left + 50.0, 35.0),
        boxes=[box],
        heatmap=np.full((2, 2), heat, np.uint8),
    )
    return GroundingReply(model="m", width=300, height=400, evidence=[evidence], milliseconds=1.0)


@pytest.mark.parametrize(
    ("other", "path", "size"),
    [
        (reply(score=0.75), "book.score", 0.05),
        (reply(left=15.0), "book.point", 0.01),
        (reply(left=15.0), "book.boxes[0]", 1.0 - 95.0 / 105.0),
        (reply(heat=151), "book.heatmap", 0.2),
        (reply(found=False), "book.found", np.inf),
    ],
)
def test_evidence_is_compared_by_share(other: GroundingReply, path: str, size: float) -> None:
    assert list(reply_differences(reply(), reply())) == []
    sizes = {one.path: one.size for one in reply_differences(reply(), other)}
    assert sizes[path] == pytest.approx(size)


def test_boxes_that_do_not_meet_share_nothing() -> None:
    first = Box(left=0.0, top=0.0, right=2.0, bottom=2.0, score=1.0)
    other = Box(left=3.0, top=0.0, right=5.0, bottom=2.0, score=1.0)
    assert overlap(first, other) == 0.0
    assert overlap(first, first) == 1.0
