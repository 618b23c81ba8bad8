"""Requests of the page, on a model and hands that are fakes."""

import threading
from typing import Any

import pytest
from starlette.websockets import WebSocketDisconnect

from fakes.console_operator import STAMP, Page
from fakes.table_picture import make_target
from support.waiting import wait_until
from w2c.errors import DeadlineError, RefusedError, RemoteError, UnavailableError, W2CError
from w2c.messages import ConfirmRequest, PointRequest, SayRequest
from w2c_console.app import STOPS_AT_ONCE

THREADS_OF_STARLETTE = 40


def test_the_page_and_its_modules_are_served_with_a_policy(page: Page) -> None:
    index = page.client.get("/")
    assert index.status_code == 200
    assert "script-src" not in index.text
    assert "default-src 'self'" in index.headers["content-security-policy"]
    script = page.client.get("/static/console.js")
    assert script.status_code == 200
    assert "javascript" in script.headers["content-type"]


def test_an_utterance_keeps_the_stamp_to_the_nanosecond(page: Page) -> None:
    body = {
        "text": "to the book",
        "frame_stamp": str(STAMP),
        "robot_boot": "b-1",
        "target_id": "t-3",
    }
    assert page.client.post("/api/say", json=body).json()["reply"] == "done"
    (asked,) = page.operator.asked
    assert isinstance(asked, SayRequest)
    assert (asked.text, asked.frame_stamp_ns, asked.target_id) == ("to the book", STAMP, "t-3")
    assert asked.robot_boot_id == "b-1"


def test_a_click_names_the_picture_and_the_robot_in_it(page: Page) -> None:
    body = {"u": 3.5, "v": 4.5, "frame_stamp": str(STAMP), "robot_boot": "b-1"}
    page.client.post("/api/point", json=body)
    (asked,) = page.operator.asked
    assert isinstance(asked, PointRequest)
    assert (asked.u, asked.v, asked.frame_stamp_ns, asked.robot_boot_id) == (3.5, 4.5, STAMP, "b-1")


def test_a_confirmation_names_the_target_it_was_given(page: Page) -> None:
    page.model.on_target(make_target("t-9", 1))  # newer than what the page showed
    page.client.post("/api/confirm", json={"target_id": "t-8"})
    (asked,) = page.operator.asked
    assert isinstance(asked, ConfirmRequest)
    assert asked.target_id == "t-8"


@pytest.mark.parametrize(
    ("problem", "status", "code"),
    [
        (RefusedError("t-8 is no longer the target"), 409, "refused"),
        (UnavailableError("dialogue is not running"), 503, "unavailable"),
        (DeadlineError("no answer within 120 s"), 504, "deadline"),
        (RemoteError("dialogue failed"), 502, "remote"),
    ],
)
def test_an_error_keeps_its_reason(page: Page, problem: W2CError, status: int, code: str) -> None:
    page.operator.problem = problem
    response = page.client.post("/api/confirm", json={"target_id": "t-8"})
    assert response.status_code == status
    assert response.json() == {"code": code, "message": str(problem)}


@pytest.mark.parametrize(
    ("path", "body"),
    [
        ("/api/say", {"text": "", "frame_stamp": "1"}),
        ("/api/say", {"text": "x" * 501, "frame_stamp": "1"}),
        ("/api/say", {"text": "x", "frame_stamp": 1}),
        ("/api/say", {"text": "x", "frame_stamp": "-2"}),
        ("/api/say", {"text": "x" * 20_000, "frame_stamp": "1"}),
        ("/api/say", {"text": "x", "frame_stamp": "1", "colour": "red"}),
        ("/api/confirm", {"target_id": ""}),
        ("/api/confirm", {}),
        ("/api/point", {"u": -1.0, "v": 2.0, "frame_stamp": "1"}),
        ("/api/point", {"u": "left", "v": 2.0, "frame_stamp": "1"}),
    ],
)
def test_a_malformed_request_is_refused_and_goes_nowhere(
    page: Page, path: str, body: dict[str, Any]
) -> None:
    response = page.client.post(path, json=body)
    assert response.status_code == 400
    assert response.json()["code"] == "message"
    assert page.operator.asked == []


def test_a_body_that_another_page_could_send_unasked_is_refused(page: Page) -> None:
    """A form of another site can send text, but no JSON, without the browser asking first."""
    response = page.client.post(
        "/api/confirm", content=b'{"target_id": "t-1"}', headers={"content-type": "text/plain"}
    )
    assert response.status_code == 400
    assert page.operator.asked == []


@pytest.mark.parametrize(
    "headers",
    [
        {"origin": "http://evil.example"},
        {"origin": "http://localhost:9999"},
        {"origin": "null"},
        {"host": "rebound.example:8080"},
    ],
)
def test_other_sites_cannot_drive_the_robot(page: Page, headers: dict[str, str]) -> None:
    response = page.client.post("/api/confirm", json={"target_id": "t-1"}, headers=headers)
    assert response.status_code == 403
    with (
        pytest.raises(WebSocketDisconnect),
        page.client.websocket_connect("ws://localhost:8080/ws/news", headers=headers),
    ):
        pass
    assert page.operator.asked == []


def test_the_page_itself_may_send_its_origin(page: Page) -> None:
    headers = {"origin": "http://localhost:8080"}
    response = page.client.post("/api/confirm", json={"target_id": "t-1"}, headers=headers)
    assert response.status_code == 200


def test_stop_takes_no_body_and_tells_the_outcome(page: Page) -> None:
    held = page.client.post("/api/stop")
    assert (held.status_code, held.json()["acknowledged"]) == (200, True)
    page.operator.acknowledges = False
    lost = page.client.post("/api/stop", data={"form": "field"})
    assert (lost.status_code, lost.json()["acknowledged"]) == (504, False)


def test_stop_works_while_every_other_request_hangs(page: Page) -> None:
    """More utterances wait for an answer than the server has threads for them."""
    page.operator.answering.clear()
    body = {"text": "x", "frame_stamp": "1"}
    callers = [
        threading.Thread(target=lambda: page.client.post("/api/say", json=body), daemon=True)
        for _ in range(THREADS_OF_STARLETTE + 5)
    ]
    for caller in callers:
        caller.start()
    try:
        wait_until(lambda: len(page.operator.asked) >= THREADS_OF_STARLETTE)
        for _ in range(STOPS_AT_ONCE + 1):
            assert page.client.post("/api/stop").json()["acknowledged"] is True
        assert page.operator.answered == 0
    finally:
        page.operator.answering.set()
        for caller in callers:
            caller.join(timeout=10.0)


def test_resume_tells_the_mode_or_why_not(page: Page) -> None:
    assert page.client.post("/api/resume").json() == {"mode": "tracking", "stamp": str(STAMP)}
    page.operator.problem = RefusedError("the robot fell")
    assert page.client.post("/api/resume").status_code == 409
