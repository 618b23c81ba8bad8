"""The service on a bus: both methods, errors with their codes, many callers at once."""

import re
import threading
from collections.abc import Iterator
from pathlib import Path
from typing import NamedTuple

import pytest

from w2c import topics
from w2c.bus import Bus
from w2c.bus.inprocess import InProcessHub
from w2c.clock import RealClock
from w2c.config import parse
from w2c.errors import ConfigError, DeadlineError, RefusedError, UnavailableError
from w2c.messages import ChatMessage, ChooseRequest, CompleteRequest
from w2c_llm.config import LlmConfig
from w2c_llm.node import LlmNode, make_backend

CHAT = [ChatMessage(role="system", content="task 1"), ChatMessage(role="user", content="the mug")]
SCHEMA = {"enum": ["left", "right"]}


class Running(NamedTuple):
    """A node that serves, its bus, and the hub of both."""

    hub: InProcessHub
    bus: Bus
    node: LlmNode


@pytest.fixture
def running(tiny_model: Path) -> Iterator[Running]:
    """Return the service while it runs."""
    hub = InProcessHub()
    bus = hub.connect("llm")
    config = LlmConfig(robot="talos", model=str(tiny_model), context=512, threads=1)
    node = LlmNode(config, bus, RealClock())
    node.configure()
    stop = threading.Event()
    thread = threading.Thread(target=node.run, args=(stop,))
    thread.start()
    assert node.queue_length == 0
    yield Running(hub, bus, node)
    stop.set()
    thread.join()
    node.close()
    bus.close()


@pytest.fixture
def caller(running: Running) -> Bus:
    """Return the bus of a caller, while the service runs."""
    return running.hub.connect("dialogue")


def test_complete_answers_with_what_it_cost(caller: Bus) -> None:
    request = CompleteRequest(messages=CHAT, schema=SCHEMA, constant_messages=1)
    first = caller.call(topics.COMPLETE, request).message
    second = caller.call(topics.COMPLETE, request).message
    assert first.value in ("left", "right")
    assert first.text == f'"{first.value}"'
    assert first.model == "tiny"
    assert (first.reused_tokens, second.reused_tokens > 0) == (0, True)
    assert first.prompt_tokens > 5
    assert first.prefill_ms > 0.0


def test_choose_answers_with_probabilities(caller: Bus) -> None:
    request = ChooseRequest(messages=CHAT, options=["left", "right"], log_prior={"right": 90.0})
    reply = caller.call(topics.CHOOSE, request).message
    assert reply.option == "right"
    assert sum(reply.probabilities.values()) == pytest.approx(1.0)


def test_a_refusal_reaches_the_caller_with_its_reason(caller: Bus) -> None:
    request = CompleteRequest(messages=CHAT, schema={"type": "string"})
    with pytest.raises(RefusedError, match="maxLength"):
        caller.call(topics.COMPLETE, request)


def test_a_request_is_given_up_at_its_own_deadline(running: Running, caller: Bus) -> None:
    """The model never comes to it: another request holds the model."""
    begun, release = threading.Event(), threading.Event()

    def hold(_: object, __: object) -> None:
        begun.set()
        release.wait(30.0)

    holder = threading.Thread(target=lambda: running.node._engine.submit(hold, 60.0))
    holder.start()
    assert begun.wait(30.0)
    request = ChooseRequest(messages=CHAT, options=["left", "right"], deadline=0.05)
    with pytest.raises(DeadlineError, match=r"0\.05 s"):
        caller.call(topics.CHOOSE, request)
    release.set()
    holder.join()
    assert running.bus.counters == {"request given up: deadline": 1}


def test_the_health_report_says_what_requests_cost_and_why_they_failed(
    running: Running, caller: Bus
) -> None:
    assert running.node.detail == ""
    for _ in range(3):
        caller.call(
            topics.COMPLETE,
            CompleteRequest(messages=CHAT, schema=SCHEMA, constant_messages=1),
        )
    assert re.match(
        r"3 answers; median of the last 3: queue \d+, prefill \d+, decode \d+ ms; "
        r"[1-9]\d % of prompts reused",
        running.node.detail,
    )
    with pytest.raises(RefusedError):
        caller.call(topics.COMPLETE, CompleteRequest(messages=CHAT, schema={"type": "string"}))
    assert running.bus.counters == {"request refused": 1}


def test_many_callers_are_all_answered_alike(caller: Bus) -> None:
    request = CompleteRequest(messages=CHAT, schema=SCHEMA, constant_messages=1)
    texts: list[str] = []

    def run() -> None:
        for _ in range(5):
            texts.append(caller.call(topics.COMPLETE, request).message.text)

    threads = [threading.Thread(target=run) for _ in range(4)]
    for thread in threads:
        thread.start()
    for thread in threads:
        thread.join()
    assert len(texts) == 20
    assert len(set(texts)) == 1


def test_a_closed_node_serves_no_more(tiny_model: Path) -> None:
    hub = InProcessHub()
    node = LlmNode(
        LlmConfig(robot="talos", model=str(tiny_model), context=512),
        hub.connect("llm"),
        RealClock(),
    )
    node.configure()
    node.close()
    node.close()
    request = CompleteRequest(messages=CHAT, schema=SCHEMA)
    with pytest.raises(UnavailableError):
        hub.connect("dialogue").call(topics.COMPLETE, request)


def test_flags_that_do_not_fit_are_refused(tmp_path: Path) -> None:
    with pytest.raises(ConfigError, match="needs --model"):
        make_backend(LlmConfig(robot="talos", backend="openai"))
    with pytest.raises(ConfigError, match="no language model"):
        make_backend(LlmConfig(robot="talos", model=str(tmp_path / "none.gguf")))
    with pytest.raises(ConfigError, match="context"):
        parse(LlmConfig, ["--robot", "talos", "--context", "3"], program="w2c llm")
