"""A controller that was killed while it held for an operator: its successor goes on holding."""

from collections.abc import Callable

import msgspec
import numpy as np
import pytest

from fakes.ideal_robot import IdealRobot
from w2c.bus.codec import decode_message, encode_message
from w2c.messages import Array, ControllerSnapshot, RobotDescription
from w2c_controller.controller import Controller
from w2c_controller.safety.hazards import Hazard

ROBOT = "boot id of the robot"
FAST = Hazard("velocity_limit", "the elbow turns at 9.00 rad/s, limit 3.00")


@pytest.fixture(scope="module")
def description(description: RobotDescription) -> RobotDescription:
    """A robot with ticks of 10 ms: five times faster tests."""
    return msgspec.structs.replace(description, period_ns=10_000_000)


class Relay:
    """One robot, and controllers that follow each other."""

    def __init__(self, description: RobotDescription) -> None:
        self._description = description
        self.robot = IdealRobot(description)
        self.controller = Controller(description)
        self.run(20)

    def run(self, ticks: int) -> Array:
        """Return the commands (ticks, n)."""
        return np.array([self.robot.step(self.controller).position for _ in range(ticks)])

    def snapshot(self) -> ControllerSnapshot:
        """Return what a file would hold now."""
        controller, state = self.controller, self.robot.state()
        snapshot = ControllerSnapshot(
            stamp_ns=state.stamp_ns,
            tick=state.tick - 1,
            reason="switch",
            robot_boot_id=ROBOT,
            controller_boot_id="controller",
            phase=controller.phase,
            in_contact=controller.retargeting.state.enabled,
            command=controller.command,
            state=controller.export(),
        )
        return decode_message(encode_message(snapshot), ControllerSnapshot)

    def replace_controller(
        self, change: Callable[[ControllerSnapshot], ControllerSnapshot] = lambda s: s
    ) -> None:
        """Kill the controller, and start another with what there is of a snapshot."""
        snapshot = change(self.snapshot())
        self.controller = Controller(self._description)
        self.controller.takeover.offer(snapshot, ROBOT)

    def phase(self) -> str:
        return self.controller.phase

    def causes(self) -> list[tuple[str, bool]]:
        return [(r.hazard.cause, r.begins) for r in self.controller.take_safety_reports()]


@pytest.fixture
def relay(description: RobotDescription) -> Relay:
    return Relay(description)


def stays(commands: Array) -> bool:
    """Tell whether commands (ticks, n) are all the same."""
    return bool((commands == commands[0]).all())


def test_a_hold_that_waits_for_an_operator_outlives_its_controller(relay: Relay) -> None:
    relay.controller.found(FAST)
    held = relay.run(5)[-1]
    assert relay.controller.waits == ("velocity_limit",)
    relay.replace_controller()
    after = relay.run(60)
    assert stays(np.vstack([held[None], after]))
    assert relay.controller.takeover.done
    assert "from the snapshot" in relay.controller.takeover.how
    assert relay.phase() == "held"
    message = relay.controller.snapshot().message
    assert FAST.text in message
    assert "w2c resume" in message
    assert relay.causes() == [("velocity_limit", True)]
    relay.controller.resume()
    relay.run(240)
    assert relay.phase() == "hold"
    assert relay.causes() == [("velocity_limit", False)]


def test_it_outlives_the_next_one_too(relay: Relay) -> None:
    relay.controller.found(FAST)
    relay.run(5)
    for _ in range(2):
        relay.replace_controller()
        relay.run(5)
        assert relay.controller.waits == ("velocity_limit",)


def test_a_snapshot_whose_posture_does_not_fit_still_tells_of_the_hold(relay: Relay) -> None:
    relay.controller.found(FAST)
    relay.run(5)
    relay.replace_controller(
        lambda snapshot: msgspec.structs.replace(snapshot, command=snapshot.command + 1.0)
    )
    relay.run(5)
    assert relay.controller.takeover.how == "standing"
    assert relay.controller.waits == ("velocity_limit",)


def test_a_pause_ends_with_its_controller(relay: Relay) -> None:
    relay.controller.found(Hazard("state_stale", "no state for 120 ms"))
    assert relay.controller.waits == ()
    relay.replace_controller()
    relay.run(5)
    assert relay.phase() != "held"


def test_another_robot_need_not_wait(relay: Relay) -> None:
    relay.controller.found(FAST)
    relay.run(5)
    relay.replace_controller(
        lambda snapshot: msgspec.structs.replace(snapshot, robot_boot_id="another")
    )
    relay.run(5)
    assert relay.controller.waits == ()


def test_a_stop_that_did_not_reach_the_driver_outlives_its_controller(relay: Relay) -> None:
    relay.controller.freeze("red button")
    relay.run(5)
    relay.replace_controller()
    after = relay.run(60)
    assert stays(after)
    assert relay.phase() == "stopped"
    assert "red button" in relay.controller.snapshot().message
    relay.controller.resume()
    relay.run(240)
    assert relay.phase() == "hold"


def test_a_stop_of_the_driver_ends_where_it_was_resumed_meanwhile(relay: Relay) -> None:
    relay.robot.mode = "stopped"
    relay.run(5)
    relay.replace_controller()
    relay.run(5)
    assert relay.phase() == "stopped"
    relay.replace_controller()
    relay.robot.mode = "holding"  # an operator said resume while no controller was there
    relay.run(5)
    assert relay.phase() != "stopped"


def test_holds_that_cannot_be_read_are_a_stop(relay: Relay) -> None:
    def garble(snapshot: ControllerSnapshot) -> ControllerSnapshot:
        state = {**snapshot.state, "_holds": {"@": "w2c_controller.safety.hazards.Other"}}
        return msgspec.structs.replace(snapshot, state=state)

    relay.replace_controller(garble)
    relay.run(5)
    assert relay.phase() == "stopped"
    assert "cannot be read" in relay.controller.snapshot().message
