"""Router, publisher and recorder as processes; the recorder is killed, and goes on."""

import signal
import subprocess
import sys
import time
from collections.abc import Callable, Iterator
from pathlib import Path

import pytest

from support.ports import free_endpoint
from support.waiting import wait_until
from w2c import topics
from w2c.bus.zenoh_bus import ZenohBus, connect
from w2c.config import ServiceConfig
from w2c.messages import Empty, MarkRequest, RecorderStatus
from w2c_recorder.commands import record
from w2c_recorder.reading import Recorded, Recording
from w2c_recorder.recovery import is_closed

pytestmark = pytest.mark.real_time

CHATTER = Path(__file__).resolve().parents[1] / "support" / "chatter.py"
ROBOT = "recorded"
MAY_LOSE_S = 1.0

Start = Callable[..., subprocess.Popen[bytes]]


@pytest.fixture
def start() -> Iterator[Start]:
    """Start processes that end with the test."""
    processes: list[subprocess.Popen[bytes]] = []

    def run(*command: str) -> subprocess.Popen[bytes]:
        process = subprocess.Popen([sys.executable, *command])
        processes.append(process)
        return process

    yield run
    for process in reversed(processes):
        process.terminate()
    for process in processes:
        process.wait(timeout=20)


@pytest.fixture
def router(start: Start) -> str:
    endpoint = free_endpoint()
    start("-m", "w2c.cli", "router", "--listen", endpoint)
    return endpoint


@pytest.fixture
def operator(router: str) -> Iterator[ZenohBus]:
    config = ServiceConfig(robot=ROBOT, router=router)
    with connect(config, "operator", [router]) as bus:
        yield bus


def start_recorder(
    start: Start, operator: ZenohBus, router: str, directory: Path
) -> subprocess.Popen[bytes]:
    """Start a recorder and wait until it has recorded something of this process's own."""
    recorder = start(
        *("-m", "w2c_recorder", "--robot", ROBOT, "--router", router),
        *("--run-directory", str(directory), "--minimum-free-mb", "0"),
    )
    statuses = operator.queue(topics.RECORDER_STATUS)

    def records() -> bool:
        received = statuses.receive(0.2)
        return received is not None and received.message.recording and received.message.messages > 0

    wait_until(records)
    return recorder


def status_of(operator: ZenohBus) -> RecorderStatus:
    return operator.call(topics.RECORD_STATUS, Empty()).message


def read(path: Path, topic: topics.Topic[object]) -> list[Recorded]:  # type: ignore[type-var]
    """Return what the publisher's process sent on a topic."""
    key = topic.key(ROBOT, "robot")
    return [recorded for recorded in Recording(path).messages() if recorded.key == key]


def assert_consecutive(numbers: list[int]) -> None:
    assert numbers == list(range(numbers[0], numbers[0] + len(numbers)))


def test_kill_9_loses_less_than_a_second_and_the_next_recorder_goes_on(
    start: Start, operator: ZenohBus, router: str, tmp_path: Path
) -> None:
    start(str(CHATTER), ROBOT, router)
    recorder = start_recorder(start, operator, router, tmp_path)
    wait_until(lambda: status_of(operator).messages > 500)

    killed_ns = time.time_ns()
    recorder.kill()
    recorder.wait()

    first = tmp_path / "session.mcap"
    assert not is_closed(first)
    log = read(first, topics.LOG)
    assert killed_ns - log[-1].publish_time_ns < MAY_LOSE_S * 1e9
    assert_consecutive([recorded.sequence for recorded in log])
    states = [recorded.sequence for recorded in read(first, topics.ROBOT_STATE)]
    assert states == sorted(set(states))
    assert all(recorded.message is not None for recorded in log)
    before = [recorded.payload for recorded in log]

    second_recorder = start_recorder(start, operator, router, tmp_path)
    wait_until(lambda: status_of(operator).messages > 100)
    assert status_of(operator).path == str(tmp_path / "session-1.mcap")
    second_recorder.send_signal(signal.SIGTERM)
    assert second_recorder.wait(timeout=20) == 0

    assert is_closed(first)
    assert [recorded.payload for recorded in read(first, topics.LOG)] == before
    second = read(tmp_path / "session-1.mcap", topics.LOG)
    assert_consecutive([recorded.sequence for recorded in second])
    assert second[0].sequence > log[-1].sequence
    assert is_closed(tmp_path / "session-1.mcap")


def test_the_operators_verbs_and_calls_are_in_the_recording(
    start: Start,
    operator: ZenohBus,
    router: str,
    tmp_path: Path,
    capsys: pytest.CaptureFixture[str],
) -> None:
    start_recorder(start, operator, router, tmp_path)
    flags = ["--robot", ROBOT, "--router", router]

    assert record(["status", *flags]) == 0
    assert str(tmp_path / "session.mcap") in capsys.readouterr().out
    assert record(["mark", "it wobbled", *flags]) == 0
    assert record(["stop", *flags]) == 0
    assert "not recording" in capsys.readouterr().out

    path = tmp_path / "session.mcap"
    assert is_closed(path)
    messages = list(Recording(path).messages())
    marks = [m.message.text for m in messages if isinstance(m.message, MarkRequest)]
    assert marks == ["it wobbled"]
    keys = {recorded.key for recorded in messages}
    assert {
        f"w2c/v1/{ROBOT}/trace/operator/call",
        f"w2c/v1/{ROBOT}/health/recorder/status",
        f"w2c/v1/{ROBOT}/live/operator/0",
    } <= keys


def test_a_second_recorder_in_the_directory_leaves_the_first_ones_file_alone(
    start: Start, operator: ZenohBus, router: str, tmp_path: Path
) -> None:
    """Also a recorder that hangs in an upgrade must not cost the session."""
    first = start_recorder(start, operator, router, tmp_path)
    inode = (tmp_path / "session.mcap").stat().st_ino
    other = free_endpoint()
    start("-m", "w2c.cli", "router", "--listen", other)
    with connect(ServiceConfig(robot=ROBOT, router=other), "operator", [other]) as elsewhere:
        start_recorder(start, elsewhere, other, tmp_path)
        assert status_of(elsewhere).path == str(tmp_path / "session-1.mcap")

    assert (tmp_path / "session.mcap").stat().st_ino == inode
    first.send_signal(signal.SIGTERM)
    assert first.wait(timeout=20) == 0
    assert is_closed(tmp_path / "session.mcap")
