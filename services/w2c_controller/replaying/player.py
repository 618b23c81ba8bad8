"""A controller that is told at each tick what the recorded one was told."""

from dataclasses import dataclass

from w2c.errors import ControlError, GoalRefusedError
from w2c.messages import (
    ControllerSnapshot,
    ControllerStatus,
    JointCommand,
    PlaceGoal,
    RobotState,
    SafetyEvent,
)
from w2c.through import Heard
from w2c_controller.controller import Controller
from w2c_controller.goals.goals import check_end_effector, check_place
from w2c_controller.goals.requests import Request
from w2c_controller.loop.summary import Snapshot
from w2c_controller.replaying.given import Given, Kept
from w2c_controller.safety.hazards import Hazard, SafetyReport
from w2c_controller.safety.outside import STALE, found_outside
from w2c_controller.switching.events import Event


class LostError(ControlError):
    """What the controller was told is not in the recording: nobody can go on from here."""


@dataclass(frozen=True)
class Done:
    """What one tick gave."""

    command: JointCommand
    events: list[Event]
    reports: list[SafetyReport]
    told: list[str]
    """What the controller was told before it, for people"""


@dataclass(frozen=True)
class Silence:
    """What came of it that no state came for too long: it is told at once, and of no state."""

    stamp_ns: int
    """Of the process's own clock, as recorded"""
    trouble: str
    """What the status tells of it"""
    reports: list[SafetyReport]
    snapshot: Snapshot
    """What the controller does then"""
    told: list[str]
    """What was read off the clock, for people"""


class Player:
    """One controller of one robot, from its first tick or from a snapshot on."""

    def __init__(self, given: Given, controller: str, robot: str) -> None:
        """Make a controller that has not ticked.

        Args:
            given: What the recording says.
            controller: Boot id.
            robot: Boot id.

        Raises:
            RecordingError: the description of the robot is not in the recording.
        """
        self._given = given
        self._boot_id = controller
        self._robot = robot
        self.controller = Controller(given.description(robot))
        self._judged: dict[str, Request] = {}
        """Goals that begin at a later tick"""
        self._snapshot_tick = -1
        """That it went on from; goals that were judged before cannot be judged again"""
        self._was_stopped = False

    def begin(self, previous: Kept | None) -> None:
        """Begin as a new process; with the snapshot of the one before it where there is one."""
        if previous is not None:
            self.controller.takeover.offer(previous.read(), self._robot)

    def go_on(self, snapshot: ControllerSnapshot, state: RobotState) -> None:
        """Go on from a snapshot that was made at this state. Raises SnapshotError."""
        self.controller.restore(snapshot.state, state)
        self._snapshot_tick = snapshot.tick
        self._was_stopped = state.mode == "stopped"

    def tick(self, state: Heard) -> Done:
        """Do what was done at a state.

        Raises:
            LostError: a goal began here that cannot be judged as it was.
            ControlError: the robot cannot stand so.
        """
        message: RobotState = state.message
        told = [*self._begin_goals(message), *self._obey_operator(message, state.seconds)]
        command = self.controller.tick(message)
        events, reports = self.controller.take_events(), self.controller.take_safety_reports()
        self._was_stopped = message.mode == "stopped"
        return Done(command, events, reports, told)

    def rest(self, state: RobotState) -> list[Silence]:
        """Do what was done between the tick of a state and the next.

        Raises:
            LostError: a goal that was admitted then is refused now.
        """
        for goal_id in self._given.judged_at(state.tick):
            self._judged[goal_id] = self._judge(goal_id)
        return self._find_outside(state)

    # --- goals -----------------------------------------------------------------------------------
    def _begin_goals(self, state: RobotState) -> list[str]:
        """Put into the slot what began at this tick."""
        told = []
        for goal_id in self._given.begun_at(self._boot_id, state.stamp_ns):
            request = self._judged.pop(goal_id, None)
            if request is None:
                request = self._late(goal_id)
            self.controller.requests.put(request)
            told.append(f"goal '{goal_id}' began: {self._given.wishes[goal_id].message}")
        return told

    def _late(self, goal_id: str) -> Request:
        """Judge a goal at the tick before it begins, where the recording does not say when."""
        wish = self._given.wishes.get(goal_id)
        if wish is None:
            raise LostError(f"the call that asked for goal '{goal_id}' is not in the recording")
        if wish.posture_tick >= 0:
            raise LostError(
                f"goal '{goal_id}' was judged by the posture of tick {wish.posture_tick}, and the "
                f"controller goes on from tick {self._snapshot_tick}"
            )
        return self._judge(goal_id)

    def _judge(self, goal_id: str) -> Request:
        """Return a goal with its way, by the posture of now. Raises LostError."""
        message, controller = self._given.wishes[goal_id].message, self.controller
        if not isinstance(message, PlaceGoal):
            return Request(goal_id, check_end_effector(message.end_effector), -1, None)
        try:
            goal = check_place(message, controller.model.hand_radius, controller.parameters.limits)
            _, goal = controller.requests.judge(goal, message.obstacles)
        except GoalRefusedError as error:
            raise LostError(f"goal '{goal_id}' was taken then, and is refused: {error}") from error
        return Request(goal_id, goal.effector, -1, goal)

    # --- stop, resume and what the process found -------------------------------------------------
    def _obey_operator(self, state: RobotState, seconds: float) -> list[str]:
        """Say stop and resume where the recorded controller obeyed them."""
        told = []
        for heard in self._given.hazards.get((self._boot_id, state.stamp_ns), ()):
            event = heard.message
            if event.cause == "stopped" and event.state == "begins":
                reason = self._given.stop_before(seconds)
                if reason is not None:
                    self.controller.freeze(reason)
                    told.append(f"stop: {reason}")
            elif event.state == "ends" and event.resumes == "after resume":
                if event.cause == "stopped" and self._was_stopped:
                    continue  # the driver went on, and its state says so
                self.controller.resume()
                told.append(f"resume, which ended: {event.text}")
        return told

    def _find_outside(self, state: RobotState) -> list[Silence]:
        """Find what the process found after a tick: its clock is given, all else is made again."""
        silences = []
        for stamp_ns, told in self._given.outside.get((self._boot_id, state.tick), {}).items():
            if stamp_ns == state.stamp_ns:
                continue  # the status of the tick itself
            events = [one.message for one in told if isinstance(one.message, SafetyEvent)]
            hazards = [found_outside(event.cause, event.value, event.limit) for event in events]
            for hazard in hazards:
                self.controller.found(hazard)
            if not any(one.envelope.inputs for one in told):  # else told with the next state
                silences.append(self._silence(stamp_ns, told, hazards))
        return silences

    def _silence(self, stamp_ns: int, told: list[Heard], hazards: list[Hazard]) -> Silence:
        """Return what is told while no state comes."""
        texts = [hazard.text for hazard in hazards if hazard.cause == STALE]
        # One that goes on after a state that came too late has no report of its own.
        texts += [one.message.message for one in told if isinstance(one.message, ControllerStatus)]
        reports = self.controller.take_safety_reports()
        clock = [f"the process's clock: {text}" for text in texts[:1]]
        return Silence(stamp_ns, "".join(texts[:1]), reports, self.controller.snapshot(), clock)
