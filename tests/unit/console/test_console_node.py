"""The node: from the bus to the page and back."""

import socket
import threading
from collections.abc import Iterator

import httpx
import pytest

from fakes.console_world import ConsoleWorld
from support.waiting import wait_until
from w2c.clock import RealClock
from w2c_console.config import ConsoleConfig
from w2c_console.node import ConsoleNode
from w2c_console.stop import BusLine


@pytest.fixture
def world() -> Iterator[ConsoleWorld]:
    world = ConsoleWorld()
    yield world
    world.close()


@pytest.fixture
def node(world: ConsoleWorld) -> Iterator[ConsoleNode]:
    config = ConsoleConfig(robot="test", port=0)
    node = ConsoleNode(config, world.console, RealClock(), [BusLine(world.console)])
    node.configure()
    stop = threading.Event()
    thread = threading.Thread(target=node.run, args=(stop,))
    thread.start()
    yield node
    stop.set()
    thread.join(timeout=5.0)
    node.close()


def post(node: ConsoleNode, path: str, body: dict[str, str] | None = None) -> dict[str, object]:
    answer: dict[str, object] = httpx.post(node.url + path, json=body, timeout=10.0).json()
    return answer


def test_requests_of_the_page_reach_dialogue_and_robot(
    world: ConsoleWorld, node: ConsoleNode
) -> None:
    answer = post(node, "api/say", {"text": "to the book", "frame_stamp": "12"})
    assert answer["ok"] is True
    assert [say.frame_stamp_ns for say in world.dialogue.said] == [12]
    outcome = post(node, "api/stop")
    assert (outcome["acknowledged"], outcome["controller"]) == (True, "acknowledged")
    assert world.robot.mode == "stopped"
    assert post(node, "api/stop")["acknowledged"] is True  # idempotent
    assert world.robot.stops == 2
    assert post(node, "api/resume")["mode"] == "tracking"


def test_resume_ends_what_the_controller_holds_for_or_says_that_it_goes_on_holding(
    world: ConsoleWorld, node: ConsoleNode
) -> None:
    world.holding = "the left knee bears 900 Nm"
    assert post(node, "api/resume")["mode"] == "tracking"
    assert world.holding == ""
    world.finds_it_again, world.holding = True, "the left knee bears 900 Nm"
    assert "still holds: the left knee bears 900 Nm" in str(post(node, "api/resume"))


def test_everything_that_is_published_arrives_in_the_model(
    world: ConsoleWorld, node: ConsoleNode
) -> None:
    model = node.model
    world.take_picture(1)
    world.publish_health()
    world.publish_controller("contact", "leaning")
    world.robot.publish()
    world.publish_goal("loaded")
    world.dialogue.turn("hello", "none", "what?", ok=False)

    def arrived() -> bool:
        panel = model.panel(0)
        ready = [row for row in panel.processes if row.phase == "ready"]
        return (
            model.scene(live=False).frame is not None
            and panel.robot is not None
            and panel.controller is not None
            and panel.recorder is not None
            and len(ready) >= 5
            and len(model.entries(0)) == 2
        )

    wait_until(arrived)


def test_the_port_is_free_again_after_the_end(world: ConsoleWorld) -> None:
    for _ in range(2):
        node = ConsoleNode(ConsoleConfig(robot="test", port=0), world.console, RealClock())
        node.configure()
        port = int(node.url.rsplit(":", 1)[1].strip("/"))
        node.close()
        with socket.socket() as probe:
            probe.bind(("127.0.0.1", port))
