"""`w2c llm` as a process, with the model that is shipped."""

import signal
import subprocess
import sys
from collections.abc import Iterator

import pytest

from support.ports import free_endpoint
from support.waiting import wait_until
from w2c import topics
from w2c.bus.zenoh_bus import ZenohBus, connect
from w2c.config import ServiceConfig
from w2c.errors import RefusedError, UnavailableError
from w2c.messages import ChatMessage, ChooseRequest, CompleteRequest

ROBOT = "talkative"
CHAT = [
    ChatMessage(role="system", content="select"),
    ChatMessage(role="user", content="that's perfect"),
]
OPTIONS = ["prediction", "correction", "confirmation"]


@pytest.fixture(scope="module")
def router() -> Iterator[str]:
    endpoint = free_endpoint()
    process = subprocess.Popen([sys.executable, "-m", "w2c.cli", "router", "--listen", endpoint])
    yield endpoint
    process.terminate()
    process.wait(timeout=20)


@pytest.fixture(scope="module")
def caller(router: str) -> Iterator[ZenohBus]:
    with connect(ServiceConfig(robot=ROBOT, router=router), "dialogue", [router]) as bus:
        yield bus


def start(router: str, *flags: str) -> subprocess.Popen[bytes]:
    command = [sys.executable, "-m", "w2c_llm", "--robot", ROBOT, "--router", router, *flags]
    return subprocess.Popen(command, stderr=subprocess.PIPE)


def wait_until_ready(caller: ZenohBus, process: subprocess.Popen[bytes]) -> None:
    health = caller.queue(topics.HEALTH)

    def ready() -> bool:
        assert process.poll() is None, "the service ended"
        received = health.receive(0.2)
        return (
            received is not None
            and received.message.service == "llm"
            and received.message.phase == "ready"
        )

    wait_until(ready, 60.0)


def test_the_process_answers_refuses_and_ends(caller: ZenohBus, router: str) -> None:
    process = start(router)
    wait_until_ready(caller, process)

    chosen = caller.call(topics.CHOOSE, ChooseRequest(messages=CHAT, options=OPTIONS)).message
    assert chosen.option == "confirmation"
    request = CompleteRequest(messages=CHAT, schema={"enum": OPTIONS}, constant_messages=1)
    assert caller.call(topics.COMPLETE, request).message.value in OPTIONS
    with pytest.raises(RefusedError, match="maxLength"):
        caller.call(topics.COMPLETE, CompleteRequest(messages=CHAT, schema={"type": "string"}))

    process.send_signal(signal.SIGTERM)
    _, errors = process.communicate(timeout=20)
    assert process.returncode == 0, errors.decode()
    with pytest.raises(UnavailableError):
        caller.call(topics.COMPLETE, request, timeout_s=2.0)


@pytest.mark.parametrize(
    ("flags", "status", "says"),
    [
        (("--model", "/no/such/file.gguf"), 2, "no language model at"),
        (("--model", __file__), 1, "cannot load"),
        (("--backend", "openai"), 2, "--model"),
        (("--backend", "magic"), 2, "magic"),
    ],
)
def test_a_wrong_flag_ends_the_process_with_what_to_do(
    router: str, flags: tuple[str, ...], status: int, says: str
) -> None:
    process = start(router, *flags)
    _, errors = process.communicate(timeout=60)
    assert process.returncode == status
    assert says in errors.decode()
