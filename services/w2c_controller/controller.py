"""The controller of one robot, pure of bus and clocks: one state in, one command out.

    command = desired posture + offset

The offset winds up the springs of position-controlled joints so that the contacts carry what the
desired state wants them to (`ForceControl`). Without it a hand touches, and carries nothing.
"""

from collections.abc import Mapping
from typing import Any

import numpy as np
import numpy.typing as npt

from w2c.messages import ControllerSnapshot, JointCommand, RobotDescription, RobotState
from w2c.messages.control import Phase
from w2c_controller.body import Body
from w2c_controller.desired import DesiredState
from w2c_controller.events import Event, EventState
from w2c_controller.filters import Blend
from w2c_controller.force_control import ForceControl
from w2c_controller.gaze import Gaze, find_neck
from w2c_controller.guards import SENSE_EVERY, Guards, joint_limits
from w2c_controller.handout import Handout
from w2c_controller.hands import Hands
from w2c_controller.model import Kinematics, build_model, standing_configuration
from w2c_controller.parameters import HANDS, Parameters
from w2c_controller.payload import Payloads
from w2c_controller.planner import RoutePlanner
from w2c_controller.requests import Request, Requests, Situation
from w2c_controller.retargeting import Retargeting
from w2c_controller.safety import Hazard, Holds, SafetyReport
from w2c_controller.sensing import LoadEstimator, Measured
from w2c_controller.snapshot import capture_controller, refusal
from w2c_controller.solvers import FallbackSolver
from w2c_controller.state_tree import SnapshotError, restore
from w2c_controller.stop import Stop
from w2c_controller.summary import Snapshot, summarize
from w2c_controller.switching import Switching
from w2c_controller.takeover import (
    find_supports,
    follow_command,
    starting_posture,
    unknown_contacts,
)

Vector = npt.NDArray[np.float64]
Matrix = npt.NDArray[np.float64]

FOREIGN_COMMAND = 0.03
"""A command in force that differs more from ours is not ours: go on from it [rad]."""
OWN = (
    "requests", "description", "parameters", "model", "solvers", "_events", "_holds", "_stop",
    "_handout", "_at_rest", "_initial", "_offered", "begun",
)  # fmt: skip
"""What a controller that goes on from a snapshot has of its own."""
AWAY = 0.05
"""A hand farther from its rest can be released [m]."""


class Controller:
    """Retargeting, force control and switching around one robot's state."""

    def __init__(self, description: RobotDescription, parameters: Parameters | None = None) -> None:
        self.parameters = parameters or Parameters()
        self.description = description
        self.model = build_model(description)
        self.dt = description.period_ns * 1e-9
        self.solvers = (FallbackSolver(), FallbackSolver())
        """Of the Retargeting, of the force control."""
        self.retargeting = Retargeting(self.model, self.parameters, self.dt, self.solvers[0])
        self.force_control = ForceControl(self.model, self.parameters, self.dt, self.solvers[1])
        self._initial = np.array(description.initial_position)
        self._at_rest = Kinematics(self.model)
        self._at_rest.update_frames(
            standing_configuration(self.model, self._initial[self.model.joint_indices])
        )
        self.requests = Requests(
            self.model.hand_radius,
            self.parameters.limits,
            Body(self.model),
            self.posture,
            RoutePlanner(self.model, self._at_rest, self.parameters.motion),
        )
        self._neck = find_neck(description, self.model.model)
        self._gaze: Gaze | None = None
        self._hands: Hands
        self._switching: Switching
        self._loads = LoadEstimator(self.model, SENSE_EVERY * self.dt)
        self._payloads = Payloads(self.model, self.parameters.force_control, SENSE_EVERY * self.dt)
        self._guards = Guards(
            description, joint_limits(description), self.parameters.guards, self.dt
        )
        self._holds = Holds(self.dt)
        self._started = False
        self._events: list[Event] = []
        self._measured = Measured(
            feet=np.zeros((2, 6)), hands=np.zeros((2, 3)), torque=np.zeros(self.model.nj)
        )
        self._command = self._initial.copy()
        self._blend = Blend(self._initial, self.parameters.motion.blend_time, self.dt)
        self._tick = 0
        self._solved = True
        self._aborted = False
        self._stop = Stop()
        self._adopts_contacts = False
        self._handout: Handout[DesiredState] = Handout()
        self._offered: tuple[ControllerSnapshot, str] | None = None
        self.begun = ""
        """How this controller began with the robot, for the log"""

    @property
    def started(self) -> bool:
        """Whether the robot was taken over."""
        return self._started

    @property
    def command(self) -> Vector:
        """Return the answer to the last tick (n,), a copy [rad]."""
        return self._command.copy()

    @property
    def switching(self) -> Switching:
        """Return the state machine of goals; exists after the first tick."""
        return self._switching

    def tick(self, state: RobotState) -> JointCommand:
        """Answer one state.

        Raises:
            ControlError: at the first tick, where the robot's posture cannot stand.
        """
        self._tick = state.tick
        self._guard_state(state)
        if self._stop.obey(state.mode, self._holds, self._tick):
            self._adopts_contacts = True
        if not self._started:
            self._take_over(state)
        if self._holds:
            return self._hold(state)
        self._go_on(state)
        self._begin_requests()
        self._sense(state)
        self._switch()
        self._solve()
        self._command_joints()
        self._publish_situation()
        self._handout.serve(self.retargeting.state.copy)
        return self._answer()

    def export(self) -> Any:
        """Return all that is needed to go on from this tick, bit by bit."""
        return capture_controller(self, OWN)

    def restore(self, tree: Any, state: RobotState) -> None:
        """Go on from where another controller of this robot was.

        Raises:
            SnapshotError: this is the state of something else. Make a new controller.
        """
        self._begin(self._initial[self.model.joint_indices], {}, state)
        restore(self, tree)

    def offer(self, snapshot: ControllerSnapshot, robot_boot_id: str) -> None:
        """Before the first tick: begin from a snapshot of a controller that is no more.

        Args:
            snapshot: Its newest.
            robot_boot_id: Of the robot that sends the states now.
        """
        self._offered = snapshot, robot_boot_id

    # --- asked for from other threads ------------------------------------------------------------
    def freeze(self, reason: str) -> None:
        """Hold from the next tick on, until an operator says resume. From any thread."""
        self._stop.ask(reason)

    def resume(self) -> None:
        """End holds that wait for an operator at the next tick. From any thread."""
        self._stop.resume()

    def found(self, hazard: Hazard) -> None:
        """Take a hazard that was found outside: it holds until the next good tick. For the loop."""
        self._holds.found(hazard, self._tick)

    def posture(self) -> Vector:
        """Return a copy of the desired posture (nq,). From any thread."""
        return self.retargeting.state.q.copy()

    def desired_copy(self, timeout_s: float) -> DesiredState:
        """Return a copy of the desired state. Raises GoalRefusedError when no tick comes."""
        return self._handout.ask(timeout_s)

    def take_safety_reports(self) -> list[SafetyReport]:
        """Return which hazards began and ended since the last call."""
        return self._holds.take_reports()

    def take_events(self) -> list[Event]:
        """Return what happened to goals since the last call."""
        if not self._events:
            return []
        events, self._events = self._events, []
        return events

    def set_stale(self, stale: bool) -> None:
        """Note that states stopped coming: goals are refused until they come again."""
        situation = self.requests.situation
        if situation.stale != stale:
            self.requests.situation = Situation(
                tick=situation.tick, ready=situation.ready, stopped=situation.stopped, stale=stale
            )

    def snapshot(self) -> Snapshot:
        """Return what the controller does now."""
        switching = self._switching if self._started else None
        return summarize(
            self._tick, self.phase, self._message(), self.retargeting, switching, self._measured
        )

    # --- start, hold and go on -------------------------------------------------------------------
    def _take_over(self, state: RobotState) -> None:
        """Begin with a robot that stands, or that leans already; or hold until it may begin."""
        if self._holds:
            return
        measured = self._loads.update(state)
        why_not = self._begin_from_snapshot(state, measured)
        if self._started:
            return
        supports = find_supports(measured)
        if supports and not self._adopts_contacts:
            self._holds.found(unknown_contacts(supports, measured, why_not), self._tick)
            return
        initial = self._initial[self.model.joint_indices]
        joints = starting_posture(state.position[self.model.joint_indices], initial, supports)
        self._begin(joints, supports, state)
        self._measured = measured
        self.begun = f"leaning with {len(supports)} hands" if supports else "standing"

    def _begin_from_snapshot(self, state: RobotState, measured: Measured) -> str:
        """Go on where another controller was, contacts kept; returns why not, "" = done or none."""
        if self._offered is None:
            return ""
        snapshot, robot_boot_id = self._offered
        why = refusal(snapshot, state, robot_boot_id, measured)
        if why:
            return why
        self._offered = None
        try:
            self.restore(snapshot.state, state)
        except SnapshotError as error:
            self._started = False
            return str(error)
        self._tick, self._measured, self._aborted = state.tick, measured, False
        change = (state.command - snapshot.command)[self.model.joint_indices]
        if change.any():
            follow_command(self.retargeting, change)
            self.force_control.settle(self.retargeting)
        self._abort_goals("the controller was restarted; hands stay where they are")
        self._rejoin(state)
        self.begun = f"from the snapshot of tick {snapshot.tick}"
        return ""

    def _begin(self, joints: Vector, supports: Mapping[int, Matrix], state: RobotState) -> None:
        """Stand in a posture (nj,) [rad], leaning on these hands, from the command in force."""
        self.retargeting.reset(joints, supports)
        self.retargeting.state.posture = self._initial[self.model.joint_indices].copy()
        self.force_control.reset(self.retargeting)
        self._hands = Hands(self.retargeting, self._at_rest)
        self._switching = Switching(self.retargeting, self._hands, SENSE_EVERY * self.dt)
        if self._neck is not None:
            self._gaze = Gaze(self._neck, state.command[self._neck.bus_indices], self.dt)
        self._rejoin(state)
        self._started = True

    def _guard_state(self, state: RobotState) -> None:
        """Look for what forbids to use this state, or to move on."""
        if self._holds:
            self._abort_when_overdue()
            self._holds.advance(self._tick)
        for hazard in self._guards.inspect(state, first=not self._started):
            self._holds.found(hazard, self._tick)

    def _hold(self, state: RobotState) -> JointCommand:
        """Keep the command in force; goals wait, or are aborted where this is more than a pause."""
        self._abort_when_overdue()
        if state.mode == "stopped" or not self._started or self._holds.active("command_not_taken"):
            self._keep(state)
        if not self._holds.active("sensor_not_finite"):
            self._sense(state)
        self._publish_situation()
        return self._answer()

    def _abort_when_overdue(self) -> None:
        """End goals once this is more than a pause."""
        if not self._aborted and self._holds.must_hold(self._tick):
            self._aborted = True
            self._abort_goals(self._holds.text())

    def _go_on(self, state: RobotState) -> None:
        """Begin again from the command in force, after a hold or where it is not ours."""
        foreign = np.abs(state.command - self._command).max() > FOREIGN_COMMAND
        if self._aborted or foreign:
            self._aborted = False
            self._rejoin(state)

    def _rejoin(self, state: RobotState) -> None:
        self._keep(state)
        self._blend = Blend(self._command, self.parameters.motion.blend_time, self.dt)

    def _keep(self, state: RobotState) -> None:
        """Take the command in force, whoever gave it, for one's own."""
        if np.isfinite(state.command).all():
            self._command = state.command.copy()

    def _abort_goals(self, reason: str) -> None:
        for request in self.requests.clear():
            self._events.append(_event(request, "aborted", reason))
        if self._started:
            self._switching.abort(reason)
            self._events.extend(self._switching.step(self._measured))

    # --- parts of a tick -------------------------------------------------------------------------
    def _sense(self, state: RobotState) -> None:
        if state.tick % SENSE_EVERY:
            return
        left, right = self.retargeting.state.enabled[:2]
        feet = (0, 1) if left == right else (0, 0) if left else (1, 1)
        measured = self._loads.update(state, feet)
        if self._started and self._switching.phase == "hold":
            enabled = self.retargeting.state.enabled
            self._payloads.learn(measured, (not enabled[HANDS[0]], not enabled[HANDS[1]]))
        self._measured = self._payloads.relieve(measured)
        overload = self._guards.inspect_loads(self._measured, SENSE_EVERY * self.dt)
        if overload is not None:
            self._holds.found(overload, self._tick)
        if self._started:
            for finding in self._switching.supervise(self._measured):
                self._holds.tell(finding.hazard(), self._tick)

    def _switch(self) -> None:
        self._events.extend(self._switching.step(self._measured))
        self._hands.step()

    def _solve(self) -> None:
        """Move the desired state, and the offset that lets the robot follow it under load."""
        solved = self.retargeting.tick(self._blend.advance())
        self._solved = self.force_control.tick(self.retargeting, self._measured) and solved
        hazard = self._guards.inspect_solution(self._solved)
        if hazard is not None:
            self._holds.found(hazard, self._tick)

    def _command_joints(self) -> None:
        """Send what the robot can follow; otherwise the last command, and hold from here on."""
        command = self._blend.mix(self._own_command())
        hazard = self._guards.inspect_command(command, self._command)
        if hazard is None:
            self._command = command
        else:
            self._holds.found(hazard, self._tick)

    def _answer(self) -> JointCommand:
        return JointCommand(tick=self._tick, position=self._command.copy())

    def _begin_requests(self) -> None:
        for request in self.requests.due(self._tick):
            conflict = self.requests.conflict(request.effector)
            if conflict:
                self._events.append(_event(request, "aborted", conflict))
                continue
            self._events.append(_event(request, "accepted"))
            if request.goal is not None:
                self._switching.place(request.goal)
            else:
                self._switching.release(request.goal_id, request.effector)
            self._publish_situation()

    def _own_command(self) -> Vector:
        """Return the desired posture with its offset (n,), in the bus's order [rad]."""
        state, model = self.retargeting.state, self.model
        joints = state.q[7:] + self.parameters.motion.ahead_time * state.velocity[6:]
        command = self._initial.copy()
        command[model.joint_indices] = joints + self.force_control.offset
        if self._gaze is not None:
            leaning = any(state.enabled[k] for k in HANDS)
            self._gaze.move_head(command, self.retargeting.kinematics, leaning=leaning)
        return command

    def _publish_situation(self) -> None:
        if not self._started:
            return
        switching, state = self._switching, self.retargeting.state
        away = [
            state.enabled[k]
            or float(np.abs(self._hands.targets[k] - self._hands.rest[k]).max()) > AWAY
            for k in HANDS
        ]
        self.requests.situation = Situation(
            tick=self._tick,
            ready=True,
            stopped=self._holds.active("stopped"),
            holding=self._holds.text(),
            busy_id=switching.busy_with(),
            busy_effector=switching.busy_effector(),
            away=(away[0], away[1]),
            enabled=state.enabled,
        )

    def _message(self) -> str:
        """Return for the operator why the robot holds; "" = it does not."""
        if self._holds:
            return self._holds.text()
        return "" if self._solved else "no solution of the balance problem: the robot holds"

    @property
    def phase(self) -> Phase:
        """Return what is under way."""
        if self._holds:
            return "stopped" if self._holds.active("stopped") else "held"
        if not self._started or (not self._blend.done and self._switching.phase == "hold"):
            return "starting"
        return self._switching.phase


def _event(request: Request, state: EventState, reason: str = "") -> Event:
    task = request.goal.task if request.goal is not None else "contact"
    return Event(request.goal_id, request.effector, task, state, reason)
