"""Streams of the page, on a model and hands that are fakes."""

import json
import struct
from typing import Any

import pytest
from starlette.websockets import WebSocketDisconnect

from fakes.console_operator import Page
from fakes.table_picture import make_target
from w2c.messages import Advice, Remark, Turn


def unpack(packet: bytes) -> tuple[dict[str, Any], bytes]:
    (length,) = struct.unpack_from(">I", packet)
    return json.loads(packet[4 : 4 + length]), packet[4 + length :]


def test_the_camera_stream_answers_with_the_newest_picture_only(page: Page) -> None:
    for stamp in (1, 2, 3):
        page.picture(stamp, jpeg=f"jpeg {stamp}".encode())
    with page.client.websocket_connect("ws://localhost:8080/ws/camera") as socket:
        socket.send_text('{"shown": 0}')
        header, jpeg = unpack(socket.receive_bytes())
        assert (header["stamp"], jpeg) == ("3", b"jpeg 3")
        page.picture(4)
        page.picture(5, jpeg=b"jpeg 5")
        socket.send_text(json.dumps({"shown": header["sequence"]}))
        header, jpeg = unpack(socket.receive_bytes())
        assert (header["stamp"], jpeg) == ("5", b"jpeg 5")


def test_a_new_target_is_told_without_sending_the_picture_again(page: Page) -> None:
    page.picture(1)
    with page.client.websocket_connect("ws://localhost:8080/ws/camera") as socket:
        socket.send_text('{"shown": 0}')
        header, _ = unpack(socket.receive_bytes())
        assert header["marker"] is None
        page.model.on_target(make_target("t-1", 1))
        socket.send_text(json.dumps({"shown": header["sequence"]}))
        header, jpeg = unpack(socket.receive_bytes())
        assert header["marker"]["target_id"] == "t-1"
        assert jpeg == b""


def test_a_camera_stream_that_sends_rubbish_is_closed(page: Page) -> None:
    with page.client.websocket_connect("ws://localhost:8080/ws/camera") as socket:
        socket.send_text('{"shown": "all"}')
        with pytest.raises(WebSocketDisconnect):
            socket.receive_bytes()


def test_news_begin_where_the_page_left_off(page: Page) -> None:
    for text in ("one", "two", "three"):
        turn = Turn(stamp_ns=1, text=text, module="none", reply="", ok=True, seconds=0.0)
        page.model.on_turn(turn, 0)

    def chat(wish: dict[str, Any]) -> tuple[str, list[str]]:
        with page.client.websocket_connect("ws://localhost:8080/ws/news") as socket:
            socket.send_text(json.dumps(wish))
            hello = socket.receive_json()
            assert (hello["title"], hello["robot"]) == ("Title", "talos")
            texts = []
            while (news := socket.receive_json())["type"] != "panel":
                texts.append(news["text"])
            return hello["boot"], texts

    boot, texts = chat({})
    assert texts == ["one", "two", "three"]
    assert chat({"boot": boot, "after": 2})[1] == ["three"]
    # Numbers of an earlier start of the console mean nothing now.
    assert chat({"boot": "another", "after": 2})[1] == ["one", "two", "three"]


def test_advice_is_told_at_once_and_only_when_it_changes(page: Page) -> None:
    def advise(text: str) -> None:
        remark = Remark(
            kind="material", level="caution", text=text, source="grounding", value=0.5, limit=0.2
        )
        page.model.on_advice(
            Advice(stamp_ns=1, target_id="t", frame_stamp_ns=1, remarks=[remark], seconds=0.1)
        )

    with page.client.websocket_connect("ws://localhost:8080/ws/news") as socket:
        socket.send_text("{}")
        assert [socket.receive_json()["type"] for _ in range(2)] == ["hello", "panel"]
        advise("glass")
        while (news := socket.receive_json())["type"] != "advice":
            assert news["type"] == "panel"
        assert news["remarks"][0]["numbers"] == "0.50, limit 0.20"
        advise("glass")
        for text in ("one", "two"):  # each wakes the stream
            turn = Turn(stamp_ns=1, text=text, module="none", reply="", ok=True, seconds=0.0)
            page.model.on_turn(turn, 0)
            while (news := socket.receive_json())["type"] != "turn":
                assert news["type"] == "panel"
