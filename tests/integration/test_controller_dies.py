"""The controller is killed while the robot leans: the hand stays, and the conversation goes on."""

import os
import signal

import numpy as np
import pytest

from support.running import RunningSystem
from support.waiting import wait_until
from w2c import topics
from w2c.bus.zenoh_bus import ZenohBus
from w2c.errors import CallError
from w2c.messages import ControllerStatus, Empty, PlaceGoal, SayRequest, Truth
from w2c_sim_robot.scenes.scenario_a import scenario_a

pytestmark = pytest.mark.slow

RIGHT_HAND = 3


def newest_truth(bus: ZenohBus) -> Truth:
    received = bus.latest(topics.TRUTH).wait(10.0)
    assert received is not None, "the robot publishes no truth"
    return received.message


def newest_status(bus: ZenohBus) -> ControllerStatus | None:
    received = bus.latest(topics.CONTROLLER_STATUS).wait(2.0)
    return None if received is None else received.message


def controller_pid(bus: ZenohBus) -> int | None:
    table = bus.latest(topics.PROCESS_TABLE).wait(20.0)
    assert table is not None
    row = next(row for row in table.message.processes if row.name == "controller")
    return row.pid if row.phase == "ready" else None


def lean(bus: ZenohBus) -> None:
    """Bring the right hand onto the book, and wait until its load has come to rest."""
    goal = PlaceGoal(
        goal_id="lean",
        end_effector="right_hand",
        task="contact",
        point=np.array(scenario_a().object("book").top_in_world),
        normal=np.array([0.0, 0.0, 1.0]),
    )
    bus.call(topics.PLACE, goal)

    def leans() -> bool:
        status = newest_status(bus)
        return status is not None and status.phase == "contact"

    wait_until(leans, 120)
    seen: list[float] = []

    def rests() -> bool:
        status = newest_status(bus)
        if status is not None:
            seen.append(float(np.linalg.norm(status.desired_forces[RIGHT_HAND])))
        return len(seen) > 20 and max(seen[-20:]) - min(seen[-20:]) < 0.5

    wait_until(rests, 60)


def test_a_controller_killed_while_leaning_goes_on_from_its_snapshot(system: RunningSystem) -> None:
    with system.connect() as bus:
        lean(bus)
        before, pid = newest_truth(bus), controller_pid(bus)
        assert np.linalg.norm(before.contact_forces[RIGHT_HAND]) > 15.0
        assert pid is not None
        least_force, moved = np.inf, 0.0
        os.kill(pid, signal.SIGKILL)

        def back() -> bool:
            nonlocal least_force, moved
            truth = newest_truth(bus)
            assert not truth.fell
            least_force = min(least_force, float(np.linalg.norm(truth.contact_forces[RIGHT_HAND])))
            way = truth.world_from_base[:3] - before.world_from_base[:3]
            moved = max(moved, float(np.abs(way).max()))
            status = newest_status(bus)
            again = controller_pid(bus)
            return (
                again not in (None, pid)
                and status is not None
                and status.phase in ("hold", "contact")
                and status.in_contact[RIGHT_HAND]
            )

        wait_until(back, 90)
        for _ in range(20):
            back()
        assert least_force > 10.0
        assert moved < 0.004
        assert bus.call(
            topics.SAY, SayRequest(text="Place your left hand on the cup")
        ).message.reply


def test_a_snapshot_can_be_asked_for(system: RunningSystem) -> None:
    with system.connect() as bus:

        def answers() -> bool:
            try:
                snapshot = bus.call(topics.SNAPSHOT, Empty()).message
            except CallError:
                return False
            return snapshot.state["body"]["@"].endswith("WholeBody")

        wait_until(answers, 60)
    assert (system.directory / "controller_snapshot.msgpack").is_file()
