"""Each process but the robot dies in turn; nonsense arrives. The robot stands."""

import os
import signal

import numpy as np
import pytest

from support.running import RunningSystem
from support.waiting import wait_until
from w2c import topics
from w2c.bus.zenoh_bus import ZenohBus
from w2c.errors import RefusedError
from w2c.messages import (
    ConfirmRequest,
    PlaceGoal,
    PointRequest,
    ProcessState,
    SayRequest,
    Turn,
)
from w2c_recorder.reading import Recording

pytestmark = [pytest.mark.slow, pytest.mark.real_time]

ALONE = ("router", "controller")
"""One at a time: much hangs on each."""
TOGETHER = (("camera", "recorder"), ("perception", "console"))
"""Two at once, which know nothing of each other."""


def processes(bus: ZenohBus) -> dict[str, ProcessState]:
    """Return the launcher's newest word on each process."""
    table = bus.latest(topics.PROCESS_TABLE).wait(20.0)
    assert table is not None, "the launcher publishes no table"
    return {row.name: row for row in table.message.processes}


def say(bus: ZenohBus, text: str, target_id: str = "") -> Turn:
    return bus.call(topics.SAY, SayRequest(text=text, target_id=target_id)).message


def stands(bus: ZenohBus) -> bool:
    """Tell whether the simulated robot has not fallen and the controller holds."""
    truth = bus.latest(topics.TRUTH).wait(10.0)
    status = bus.latest(topics.CONTROLLER_STATUS).wait(10.0)
    return (
        truth is not None
        and not truth.message.fell
        and status is not None
        and status.message.phase == "hold"
    )


def kill(bus: ZenohBus, *names: str) -> None:
    """Kill processes at once; return when each of them is there again."""
    before = processes(bus)
    for name in names:
        pid = before[name].pid
        assert pid is not None
        os.kill(pid, signal.SIGKILL)

    def back() -> bool:
        now = processes(bus)
        return all(
            now[name].phase == "ready" and now[name].pid not in (None, before[name].pid)
            for name in names
        )

    wait_until(back, 90 * len(names))


@pytest.mark.parametrize("names", [*TOGETHER, *((name,) for name in ALONE)], ids="-".join)
def test_processes_may_die_and_come_back(system: RunningSystem, names: tuple[str, ...]) -> None:
    with system.connect() as bus:
        kill(bus, *names)
        wait_until(lambda: stands(bus), 30)


def test_the_conversation_goes_on_after_the_models_died(system: RunningSystem) -> None:
    with system.connect() as bus:
        kill(bus, "llm", "grounding")
        wait_until(lambda: stands(bus), 30)

        def understood() -> bool:
            return say(bus, "Place your right hand on top of the book").ok

        wait_until(understood, 60)


def test_a_dialogue_that_died_says_what_was_lost(system: RunningSystem) -> None:
    with system.connect() as bus:
        turn = say(bus, "Place your right hand on top of the book")
        assert turn.target is not None, turn.reply
        kill(bus, "dialogue")
        answer = bus.call(topics.CONFIRM, ConfirmRequest(target_id=turn.target.target_id)).message
        assert not answer.ok
        assert not answer.goal_id
        assert stands(bus)


def test_an_object_that_is_not_there_is_an_answer(system: RunningSystem) -> None:
    with system.connect() as bus:
        turn = say(bus, "put your right hand on the violin")
        assert not turn.ok
        assert turn.target is None
        assert "violin" in turn.reply
        assert stands(bus)


def test_a_target_outside_the_picture_is_refused(system: RunningSystem) -> None:
    with system.connect() as bus:
        turn = bus.call(topics.POINT, PointRequest(u=5000.0, v=10.0)).message
        assert not turn.ok
        assert stands(bus)


def test_a_goal_from_the_moon_is_refused_by_the_controller(system: RunningSystem) -> None:
    answer = system.verb(
        "place", "--end-effector", "right_hand", "--point", "0.5", "-0.2", "2.9"
    )  # fmt: skip
    assert answer.returncode == 1
    assert answer.stderr.startswith("w2c place: ")


def test_garbage_on_a_command_key_is_counted_and_moves_nothing(system: RunningSystem) -> None:
    with system.connect() as bus:
        key = topics.PLACE.key(system.file.robot, "0")
        replies = list(bus._session.get(key, payload=b"\xc1 garbage", timeout=5.0))
        assert replies[0].err is not None
        assert stands(bus)


def test_a_pixel_outside_the_picture_moves_nothing(system: RunningSystem) -> None:
    answer = system.verb("place", "--end-effector", "right_hand", "--pixel", "5000", "10")
    assert answer.returncode == 1
    with system.connect() as bus:
        assert stands(bus)


def test_a_goal_with_nan_is_refused_by_whoever_receives_it(system: RunningSystem) -> None:
    with system.connect() as bus:
        goal = PlaceGoal(
            goal_id="nan",
            end_effector="right_hand",
            task="contact",
            point=np.array([0.5, -0.2, 0.8]),
            normal=np.array([0.0, 0.0, 1.0]),
        )
        np.copyto(goal.point, np.nan)  # behind the back of the struct, as a broken sender would
        with pytest.raises(RefusedError, match="NaN"):
            bus.call(topics.PLACE, goal)
        assert stands(bus)


def test_stop_is_acknowledged_and_a_goal_during_a_stop_is_refused(system: RunningSystem) -> None:
    assert "acknowledged" in system.verb("stop").stdout
    refused = system.verb("place", "--end-effector", "left_hand", "--point", "0.5", "0.2", "0.9")
    assert refused.returncode == 1
    assert "stop" in refused.stderr
    assert system.verb("resume").returncode == 0
    with system.connect() as bus:
        wait_until(lambda: stands(bus), 30)


def test_what_happened_is_in_the_recording(system: RunningSystem) -> None:
    """Runs with the others in any order: at least one utterance of its own is recorded."""
    with system.connect() as bus:
        say(bus, "put your left hand on the trombone")

    def is_recorded() -> bool:
        texts = [
            recorded.message.text
            for path in sorted(system.directory.glob("session*.mcap"))
            for recorded in Recording(path).of(topics.TURN)
            if isinstance(recorded.message, Turn)
        ]
        return any("trombone" in text for text in texts)

    wait_until(is_recorded, 20)
