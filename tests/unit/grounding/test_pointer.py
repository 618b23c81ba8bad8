"""The family `pointer`: a server that answers well, in prose, busily, never, or with garbage."""

import base64
import io
import json
import logging
import socket
from collections.abc import Iterator
from typing import Any

import numpy as np
import pytest
from PIL import Image

from fakes.chat_server import ChatServer, completion
from w2c.errors import ConfigError, DeadlineError, ModelError, RefusedError, W2CError
from w2c_grounding.evidence import find
from w2c_grounding.pointer.options import PointerOptions
from w2c_grounding.pointer.pointer import Pointer
from w2c_grounding.pointer.server import ServerTalker

KEY = "sk-very-secret-9b22"
IMAGE = np.full((180, 320, 3), 128, dtype=np.uint8)
CUP = completion('[{"point_2d": [250, 500]}]')


def pointer(server: ChatServer, template: str = "{}", **options: Any) -> Pointer:
    chosen = PointerOptions(url=server.url, **options)
    return Pointer(ServerTalker(chosen, "eye", KEY, pause=lambda _: None), chosen, template)


def points(family: Pointer, *phrases: str) -> list[tuple[float, float] | None]:
    evidence = family.query(family.prepare(IMAGE), phrases)
    family.close()
    return [find(one.heatmap, 0.5, "interior", one.boxes).point for one in evidence]


def test_a_named_place_becomes_a_pixel_of_the_picture() -> None:
    with ChatServer((200, CUP)) as server:
        assert points(pointer(server), "cup") == [pytest.approx((80, 90), abs=1)]
    (sent,) = server.requests
    assert server.authorizations == [f"Bearer {KEY}"]
    assert (sent["model"], sent["temperature"], sent["max_tokens"]) == ("eye", 0.0, 400)


def test_the_picture_travels_shrunk_as_a_data_url_beside_the_question() -> None:
    with ChatServer((200, CUP)) as server:
        points(pointer(server, longest_side=160), "red cup")
    picture, question = server.requests[0]["messages"][0]["content"]
    kind, _, data = picture["image_url"]["url"].partition(",")
    assert kind == "data:image/jpeg;base64"
    assert Image.open(io.BytesIO(base64.b64decode(data))).size == (160, 90)
    assert "red cup" in question["text"]


def test_pixels_are_those_of_the_picture_as_sent() -> None:
    with ChatServer((200, completion("(40, 45)"))) as server:
        family = pointer(server, longest_side=160, units="pixels")
        assert points(family, "cup") == [pytest.approx((80, 90), abs=1)]


def test_boxes_are_asked_for_and_read() -> None:
    with ChatServer((200, completion('[{"bbox_2d": [250, 500, 500, 1000]}]'))) as server:
        assert points(pointer(server, ask_for="boxes"), "cup") == [pytest.approx((120, 135), abs=2)]
    assert "bbox_2d" in server.requests[0]["messages"][0]["content"][1]["text"]


def test_a_template_of_a_model_replaces_the_question() -> None:
    with ChatServer((200, completion('<point x="25" y="50" alt="cup">cup</point>'))) as server:
        assert points(pointer(server, "Point to {}."), "cup") == [pytest.approx((80, 90), abs=1)]
    assert server.requests[0]["messages"][0]["content"][1]["text"] == "Point to cup."


def test_phrases_are_asked_one_by_one_and_answered_in_their_order() -> None:
    class Echo(ChatServer):
        """Answers with the number in the phrase, in whichever order it is asked."""

        def _next(self) -> tuple[Any, ...]:
            asked = self.requests[-1]["messages"][0]["content"][1]["text"]
            number = int("".join(filter(str.isdigit, asked)))
            return 200, completion(f"({number}, {number})")

    with Echo((200, {})) as server:
        family = pointer(server, "thing {}", units="thousand", concurrency=1)
        found = points(family, "100", "900", "500")
    assert found == [pytest.approx((n * 0.32, n * 0.18), abs=1) for n in (100, 900, 500)]


def test_several_phrases_travel_at_once() -> None:
    with ChatServer((200, CUP)) as server:
        assert len(points(pointer(server), *["cup"] * 6)) == 6
    assert len(server.requests) == 6


def test_that_nothing_is_there_is_an_answer() -> None:
    with ChatServer((200, completion("[]"))) as server:
        assert points(pointer(server), "unicorn") == [None]


def test_prose_is_shown_to_the_model_once_with_what_is_wrong() -> None:
    with ChatServer((200, completion("A cup is a small bowl.")), (200, CUP)) as server:
        assert points(pointer(server), "cup") == [pytest.approx((80, 90), abs=1)]
    roles = [message["role"] for message in server.requests[1]["messages"]]
    assert roles == ["user", "assistant", "user"]
    assert "names no place" in server.requests[1]["messages"][2]["content"]


def test_prose_twice_is_an_error() -> None:
    prose = completion("A cup is a small bowl.")
    with ChatServer((200, prose)) as server, pytest.raises(ModelError, match="names no place"):
        points(pointer(server), "cup")
    assert len(server.requests) == 2


def test_places_outside_the_picture_are_dropped_and_counted(
    caplog: pytest.LogCaptureFixture,
) -> None:
    answer = completion(json.dumps([[5000, 5000], [250, 500], [float("nan"), 1]]))
    with ChatServer((200, answer)) as server:
        assert points(pointer(server), "cup") == [pytest.approx((80, 90), abs=1)]
    (record,) = [one for one in caplog.records if one.name.startswith("w2c.")]
    assert vars(record)["outside"] == 2


@pytest.mark.parametrize("status", [429, 500])
def test_a_busy_server_is_asked_again(status: int) -> None:
    with ChatServer((status, {}), (status, {}), (200, CUP)) as server:
        assert points(pointer(server), "cup") == [pytest.approx((80, 90), abs=1)]
    assert len(server.requests) == 3


@pytest.fixture
def silent_url() -> Iterator[str]:
    """Yield the address of a server that takes connections and says nothing."""
    with socket.create_server(("127.0.0.1", 0)) as listening:
        yield f"http://127.0.0.1:{listening.getsockname()[1]}/v1"


def test_a_server_that_hangs_ends_with_the_deadline(silent_url: str) -> None:
    options = PointerOptions(url=silent_url, deadline=0.2)
    family = Pointer(ServerTalker(options, "eye", ""), options, "{}")
    with pytest.raises(DeadlineError, match="did not answer in time"):
        points(family, "cup")


@pytest.mark.parametrize(
    ("reply", "error"),
    [
        ((503, {"error": KEY}), ModelError),
        ((401, {"error": KEY}), ModelError),
        ((400, {"error": f"bad {KEY}"}), RefusedError),
        ((200, b"<html>"), ModelError),
        ((200, {"choices": []}), ModelError),
        ((200, completion("(1, 2)" * 10_000)), ModelError),
        ((200, b'{"choices": [' + b" " * 5_000_000), ModelError),
        ((200, completion(f"I am {KEY}")), ModelError),
    ],
)
def test_what_fails_is_a_typed_error_and_the_key_is_in_no_log(
    reply: tuple[int, Any], error: type[W2CError], caplog: pytest.LogCaptureFixture
) -> None:
    caplog.set_level(logging.DEBUG)
    with ChatServer(reply) as server, pytest.raises(error) as caught:
        points(pointer(server), "cup")
    assert KEY not in caplog.text
    if reply[0] != 200:
        assert KEY not in str(caught.value)


def test_an_address_that_is_none_is_a_config_error() -> None:
    with pytest.raises(ConfigError, match=r"--pointer\.url"):
        ServerTalker(PointerOptions(url="localhost:80"), "eye", "")
