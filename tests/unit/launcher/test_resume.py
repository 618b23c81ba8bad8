"""`w2c resume`: it ends a stop and a hold, and says what goes on holding."""

import pytest

from w2c import topics
from w2c.bus import CallContext, InProcessHub
from w2c.errors import UnavailableError
from w2c.messages import Empty, ResumeReply, StopReply
from w2c.messages.robot import DriverMode
from w2c_launcher.operator import end_holds


class Host:
    """A driver and a controller, either of which may be absent."""

    def __init__(self, *, robot: bool = True, controller: bool = True, holds: str = "") -> None:
        hub = InProcessHub()
        self.mode: DriverMode = "stopped"
        self.holds = holds
        self.resumed = False
        self.operator = hub.connect("operator")
        if robot:
            hub.connect("robot").serve(topics.ROBOT_RESUME, self._resume_robot)
        if controller:
            hub.connect("controller").serve(topics.CONTROLLER_RESUME, self._resume_controller)

    def _resume_robot(self, _: Empty, __: CallContext) -> StopReply:
        self.mode = "holding"
        return StopReply(mode=self.mode, stamp_ns=1)

    def _resume_controller(self, _: Empty, __: CallContext) -> ResumeReply:
        self.resumed = self.mode == "holding"  # the driver first: it would refuse what is commanded
        return ResumeReply(holding=bool(self.holds), text=self.holds)


def test_robot_and_controller_are_resumed_in_this_order(
    capsys: pytest.CaptureFixture[str],
) -> None:
    host = Host()
    assert end_holds(host.operator) == 0
    assert host.resumed
    assert capsys.readouterr().out == "the robot is holding\n"


def test_what_goes_on_holding_is_told_and_is_a_failure(capsys: pytest.CaptureFixture[str]) -> None:
    host = Host(holds="the left knee bears 900 Nm, limit 300")
    assert end_holds(host.operator) == 1
    assert "still holds: the left knee bears 900 Nm" in capsys.readouterr().err


def test_without_a_controller_the_driver_is_resumed_all_the_same(
    capsys: pytest.CaptureFixture[str],
) -> None:
    host = Host(controller=False)
    assert end_holds(host.operator) == 0
    assert host.mode == "holding"
    assert "the controller does not answer" in capsys.readouterr().err


def test_without_a_robot_it_fails() -> None:
    host = Host(robot=False)
    with pytest.raises(UnavailableError):
        end_holds(host.operator)
    assert not host.resumed
