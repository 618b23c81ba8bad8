"""The console as a process: stop without a router, a busy port, an orderly end."""

import subprocess
import sys
from collections.abc import Iterator
from typing import Any

import httpx
import pytest

from support.ports import free_endpoint, free_port
from support.waiting import wait_until
from w2c import topics
from w2c.bus.zenoh_bus import connect_hub
from w2c.config import ServiceConfig
from w2c.messages import StopReply

ROBOT = "stopped"


def start(*words: str) -> "subprocess.Popen[str]":
    command = [sys.executable, "-m", "w2c.cli", *words]
    return subprocess.Popen(command, stderr=subprocess.PIPE, text=True)


def post(url: str) -> dict[str, Any]:
    answer: dict[str, Any] = httpx.post(url, timeout=20.0).json()
    return answer


def is_served(url: str) -> bool:
    try:
        return "Words2Contact" in httpx.get(url, timeout=5.0).text
    except httpx.TransportError:
        return False


@pytest.fixture
def config() -> ServiceConfig:
    return ServiceConfig(robot=ROBOT, router=free_endpoint(), robot_endpoint=free_endpoint())


@pytest.fixture
def router(config: ServiceConfig) -> Iterator["subprocess.Popen[str]"]:
    process = start("router", "--listen", config.router)
    yield process
    process.terminate()
    process.communicate(timeout=20)


def test_stop_needs_no_router_and_a_second_console_no_port(
    config: ServiceConfig, router: "subprocess.Popen[str]"
) -> None:
    port = free_port()
    flags = ("--robot", ROBOT, "--router", config.router, "--robot-endpoint", config.robot_endpoint)
    console = start("console", *flags, "--port", str(port))
    url = f"http://127.0.0.1:{port}/"
    try:
        wait_until(lambda: is_served(url), 60)
        second = start("console", *flags, "--port", str(port))
        _, words = second.communicate(timeout=60)
        assert second.returncode == 2
        assert str(port) in words
        assert "--port" in words

        router.terminate()
        router.wait(20)
        with connect_hub(config, "robot") as robot:
            robot.serve(topics.ROBOT_STOP, lambda _, __: StopReply(mode="stopped", stamp_ns=7))
            for _ in range(2):
                outcome = post(url + "api/stop")
                assert outcome["acknowledged"] is True
                assert (outcome["mode"], outcome["line"]) == ("stopped", "robot endpoint")
        assert is_served(url)
    finally:
        console.terminate()
        console.communicate(timeout=20)
    assert console.returncode == 0
