"""The remote backend against a local server: retries, prose around JSON, the key stays secret."""

import json
import logging
import math
from collections.abc import Iterator
from pathlib import Path
from typing import Any

import httpx
import pytest

from fakes.chat_server import ChatServer, completion
from w2c.chat_server import extract_json, read_key
from w2c.clock import RealClock, StepClock
from w2c.errors import ConfigError, DeadlineError, ModelError, RefusedError, W2CError
from w2c.messages import ChatMessage, ChooseRequest, CompleteRequest
from w2c_llm.answering import choose, complete
from w2c_llm.backend import Budget
from w2c_llm.openai_backend import OpenAiBackend, OpenAiOptions

KEY = "sk-very-secret-7a31"
CHAT = [ChatMessage(role="system", content="analyze"), ChatMessage(role="user", content="the cup")]
SCHEMA: dict[str, Any] = {
    "type": "object",
    "properties": {"n": {"type": "integer"}},
    "required": ["n"],
}
REQUEST = CompleteRequest(messages=CHAT, schema=SCHEMA, seed=7, max_tokens=50)


def client(server: ChatServer, **options: Any) -> OpenAiBackend:
    return OpenAiBackend(
        OpenAiOptions(server.url, "some-model", **options), KEY, pause=lambda _: None
    )


def minute() -> Budget:
    return Budget(RealClock(), 60.0)


def test_json_wrapped_in_prose_is_found() -> None:
    with ChatServer((200, completion('Sure! ```json\n{"n": 3}\n``` Anything else?'))) as server:
        backend = client(server)
        answer = complete(backend, REQUEST, minute())
        backend.close()
    assert answer.value == {"n": 3}
    assert answer.usage.prompt_tokens == 20
    assert answer.usage.completion_tokens == 5


def test_the_request_carries_schema_seed_limit_and_key() -> None:
    with ChatServer((200, completion('{"n": 3}'))) as server:
        backend = client(server)
        complete(backend, REQUEST, minute())
        backend.close()
    sent = server.requests[0]
    assert server.authorizations == [f"Bearer {KEY}"]
    assert sent["model"] == "some-model"
    assert (sent["seed"], sent["temperature"], sent["max_tokens"]) == (7, 0.0, 50)
    assert sent["response_format"]["json_schema"]["schema"]["required"] == ["n"]
    assert "JSON schema" in sent["messages"][-1]["content"], "for servers that ignore the field"


def test_what_a_server_does_not_understand_is_not_sent() -> None:
    with ChatServer((200, completion('{"n": 3}'))) as server:
        backend = client(
            server, sampling=False, schema_mode="none", token_limit="max_completion_tokens"
        )
        complete(backend, REQUEST, minute())
        backend.close()
    assert set(server.requests[0]) == {"model", "messages", "max_completion_tokens"}


@pytest.mark.parametrize("status", [429, 500, 503])
def test_a_busy_server_is_asked_again(status: int) -> None:
    with ChatServer((status, {}), (status, {}), (200, completion('{"n": 1}'))) as server:
        backend = client(server)
        assert complete(backend, REQUEST, minute()).value == {"n": 1}
        backend.close()
    assert len(server.requests) == 3


def test_a_server_that_stays_busy_is_given_up() -> None:
    with ChatServer((503, {})) as server:
        backend = client(server)
        with pytest.raises(ModelError, match="failed 4 times, last: status 503"):
            complete(backend, REQUEST, minute())
        backend.close()


def test_pauses_grow_and_never_outlast_the_budget() -> None:
    clock, pauses = StepClock(), list[float]()

    def pause(seconds: float) -> None:
        pauses.append(seconds)
        clock.set(clock.now_ns() + int(seconds * 1e9))

    with ChatServer((429, {})) as server:
        backend = OpenAiBackend(OpenAiOptions(server.url, "m"), KEY, pause=pause)
        with pytest.raises(DeadlineError):
            complete(backend, REQUEST, Budget(clock, 2.0))
        backend.close()
    assert pauses == [0.5, 1.0, 0.5]


def test_a_server_that_says_when_to_come_back_is_not_asked_earlier() -> None:
    pauses = list[float]()
    busy: tuple[int, Any, dict[str, str]] = (429, {}, {"Retry-After": "7"})
    date = {"Retry-After": "Wed, 21 Oct 2026 07:28:00 GMT"}
    vague: tuple[int, Any, dict[str, str]] = (503, {}, date)
    with ChatServer(busy, vague, (200, completion('{"n": 1}'))) as server:
        backend = OpenAiBackend(OpenAiOptions(server.url, "m"), KEY, pause=pauses.append)
        assert complete(backend, REQUEST, minute()).value == {"n": 1}
        backend.close()
    assert pauses == [7.0, 1.0]


def test_a_reply_that_never_ends_is_cut_off() -> None:
    with ChatServer((200, b'{"choices": [' + b" " * 5_000_000)) as server:
        backend = client(server)
        with pytest.raises(ModelError, match="more than 4000000 bytes"):
            complete(backend, REQUEST, minute())
        backend.close()


def test_a_reply_that_drips_ends_with_the_budget() -> None:
    """Each byte is in time, all of them are not."""
    clock = StepClock()

    class Dripping(httpx.SyncByteStream):
        def __iter__(self) -> Iterator[bytes]:
            for _ in range(1000):
                clock.set(clock.now_ns() + 100_000_000)
                yield b" "

    transport = httpx.MockTransport(lambda _: httpx.Response(200, stream=Dripping()))
    backend = OpenAiBackend(OpenAiOptions("http://somewhere/v1", "m"), KEY)
    backend._server.client = httpx.Client(base_url="http://somewhere/v1/", transport=transport)
    with pytest.raises(DeadlineError, match="2 s"):
        complete(backend, REQUEST, Budget(clock, 2.0))
    assert clock.now_ns() < 3_000_000_000
    backend.close()


@pytest.mark.parametrize("url", ["localhost:8080", "ftp://x/v1", "http://", "http://a:b", ""])
def test_an_address_that_is_none_is_a_config_error(url: str) -> None:
    with pytest.raises(ConfigError, match="--openai-url"):
        OpenAiBackend(OpenAiOptions(url, "m"), KEY)


def test_a_server_that_takes_grammars_gets_the_grammar_of_the_schema() -> None:
    with ChatServer((200, completion('{"n": 3}'))) as server:
        backend = client(server, schema_mode="gbnf")
        assert complete(backend, REQUEST, minute()).value == {"n": 3}
        backend.close()
    assert server.requests[0]["grammar"].startswith("root ::= ")
    assert "response_format" not in server.requests[0]


def test_invalid_json_twice_is_a_model_error_and_the_model_saw_the_reason() -> None:
    with ChatServer((200, completion("no idea")), (200, completion('{"n": "x"}'))) as server:
        backend = client(server)
        with pytest.raises(ModelError, match="twice"):
            complete(backend, REQUEST, minute())
        backend.close()
    assert "does not fit" in server.requests[1]["messages"][-1]["content"]


@pytest.mark.parametrize(
    ("reply", "error"),
    [
        ((401, {"error": KEY}), ModelError),
        ((400, {"error": f"bad {KEY}"}), RefusedError),
        ((200, b"<html>"), ModelError),
        ((200, {"choices": []}), ModelError),
        ((200, {"choices": [{"message": {"content": 5}}]}), ModelError),
        ((500, {"error": KEY}), ModelError),
        ((200, completion("no")), ModelError),
    ],
)
def test_the_key_is_in_no_log_and_no_error(
    reply: tuple[int, Any], error: type[W2CError], caplog: pytest.LogCaptureFixture
) -> None:
    with caplog.at_level(logging.DEBUG), ChatServer(reply) as server:
        backend = client(server)
        with pytest.raises(error) as caught:
            complete(backend, REQUEST, minute())
        backend.close()
    logged = caplog.text + json.dumps([vars(record) for record in caplog.records], default=str)
    assert KEY not in logged + str(caught.value) + repr(backend)


def test_a_server_that_is_not_there_is_named() -> None:
    backend = OpenAiBackend(OpenAiOptions("http://127.0.0.1:9/v1", "m"), "", pause=lambda _: None)
    with pytest.raises(ModelError, match=r"127\.0\.0\.1:9"):
        complete(backend, REQUEST, minute())
    backend.close()


CHOICE = ChooseRequest(messages=CHAT, options=["left", "right"], log_prior={"right": 1.0})


def test_without_logprobs_the_named_option_wins_against_a_moderate_prior() -> None:
    with ChatServer((200, completion(" A. "))) as server:
        backend = client(server)
        choice = choose(backend, CHOICE, minute())
        backend.close()
    assert choice.option == "left"
    assert choice.probabilities["left"] > 0.999
    assert "A: left\nB: right" in server.requests[0]["messages"][-1]["content"]


def test_with_logprobs_the_probabilities_are_the_servers() -> None:
    top = [
        {"token": "A", "logprob": math.log(0.5)},
        {"token": " A", "logprob": math.log(0.1)},
        {"token": "B", "logprob": math.log(0.2)},
    ]
    reply = completion("A", logprobs={"content": [{"token": "A", "top_logprobs": top}]})
    with ChatServer((200, reply)) as server:
        backend = client(server, logprobs=True)
        request = ChooseRequest(messages=CHAT, options=["left", "right"])
        choice = choose(backend, request, minute())
        backend.close()
    assert choice.probabilities["left"] == pytest.approx(0.75)


def test_an_answer_that_names_no_option_is_a_model_error() -> None:
    with ChatServer((200, completion("Z"))) as server:
        backend = client(server)
        with pytest.raises(ModelError, match="none of A, B"):
            choose(backend, CHOICE, minute())
        backend.close()


@pytest.mark.parametrize(
    ("text", "expected"),
    [
        ('{"a": 1}', '{"a": 1}'),
        ('so {1} or {"a": [2]} it is', '{"a": [2]}'),
        ("[1, 2] rest", "[1, 2]"),
        ("  nothing ", "nothing"),
        ("{" * 5000, "{" * 5000),
    ],
)
def test_extract_json_finds_the_first_value(text: str, expected: str) -> None:
    assert extract_json(text) == expected


def test_the_key_comes_from_a_file_or_the_environment(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setenv("OPENAI_API_KEY", "from-environment")
    assert read_key("") == "from-environment"
    (tmp_path / "key").write_text(KEY + "\n")
    assert read_key(str(tmp_path / "key")) == KEY
    (tmp_path / "key").write_text("two words")
    with pytest.raises(ConfigError) as caught:
        read_key(str(tmp_path / "key"))
    assert "two words" not in str(caught.value)
    with pytest.raises(ConfigError, match="cannot be read"):
        read_key(str(tmp_path / "missing"))
