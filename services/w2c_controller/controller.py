"""The controller of one robot, pure of bus and clocks: one state in, one command out.

    command = desired posture + offset

The offset winds up the springs of position-controlled joints so that the contacts carry what the
desired state wants them to (`ForceControl`). Without it a hand touches, and carries nothing.
"""

from typing import Any

import numpy as np
import numpy.typing as npt
from msgspec.structs import replace

from w2c.messages import JointCommand, RobotDescription, RobotState
from w2c.messages.control import Phase, SafetyCause
from w2c_controller.goals.agenda import Agenda
from w2c_controller.goals.body import Body
from w2c_controller.goals.planner import RoutePlanner
from w2c_controller.goals.requests import Requests
from w2c_controller.kinematics.model import build_model
from w2c_controller.kinematics.vectors import largest_difference
from w2c_controller.loop.summary import Snapshot, summarize
from w2c_controller.motion.blend import Blend
from w2c_controller.parameters import Parameters
from w2c_controller.safety.guards import SENSE_EVERY, Guards, joint_limits
from w2c_controller.safety.hazards import Hazard, Holds, SafetyReport
from w2c_controller.safety.restraint import Restraint
from w2c_controller.safety.stop import Stop
from w2c_controller.safety.takeover import Takeover
from w2c_controller.safety.uptake import Uptake
from w2c_controller.seiko.desired import DesiredState
from w2c_controller.snapshots.handout import Handout
from w2c_controller.snapshots.snapshot import capture_controller
from w2c_controller.snapshots.state_tree import restore
from w2c_controller.solvers import FallbackSolver
from w2c_controller.switching.events import Event
from w2c_controller.whole_body import WholeBody

Vector = npt.NDArray[np.float64]

FOREIGN_COMMAND = 0.03
"""A command in force that differs more from ours is not ours: go on from it [rad]."""
OWN = (
    "requests", "description", "parameters", "model", "solvers", "_agenda", "_handout",
    "_restraint", "takeover", "retargeting", "force_control",
)  # fmt: skip
"""What a controller that goes on from a snapshot has of its own."""


class Controller:
    """Retargeting, force control and switching around one robot's state."""

    def __init__(self, description: RobotDescription, parameters: Parameters | None = None) -> None:
        self.parameters = parameters or Parameters()
        self.description = description
        self.model = build_model(description)
        self.dt = description.period_ns * 1e-9
        self.solvers = (FallbackSolver(), FallbackSolver())
        """Of the Retargeting, of the force control."""
        self.body = WholeBody(description, self.model, self.parameters, self.solvers)
        self.retargeting = self.body.retargeting
        self.force_control = self.body.force_control
        self.requests = Requests(
            self.model.hand_radius,
            self.parameters.limits,
            Body(self.model),
            RoutePlanner(self.model, self.body.at_rest, self.parameters.motion),
        )
        self._agenda = Agenda(self.requests, self.body)
        limits = joint_limits(description)
        self._guards = Guards(description, limits, self.parameters.guards, self.dt)
        names = [joint.name for joint in description.joints]
        self._restraint = Restraint(names, limits, self.dt)
        self._holds = Holds(self.dt)
        self._uptake = Uptake()
        self.takeover = Takeover(self.body, self.model.joint_indices)
        """Has to be done before anything moves"""
        self._command = np.array(description.initial_position)
        self._blend = Blend(self._command, self.parameters.motion.blend_time, self.dt)
        self._tick = 0
        self._solved = True
        self._block, self._measures = -1, False
        """The four ticks under way, and whether this one is the first of them that came"""
        self._unseen = 0
        """Steps of `_look` that the newest measurement still waits for"""
        self._aborted = False
        self._stop = Stop()
        self._handout: Handout[DesiredState] = Handout()

    @property
    def command(self) -> Vector:
        """Return the answer to the last tick (n,), a copy [rad]."""
        return self._command.copy()

    def tick(self, state: RobotState) -> JointCommand:
        """Answer one state.

        Raises:
            ControlError: at the first tick, where the robot's posture cannot stand.
        """
        self._tick = state.tick
        self._guard_state(state)
        self._obey_operator(state)
        if not self.takeover.done:
            self._take_over(state)
        if self._holds:
            return self._hold(state)
        if self._uptake.lags(state):
            return self._wait(state)
        self._uptake.went_on(self._tick)
        self._go_on(state)
        self._agenda.begin_due(self._tick, self._holds)
        self._sense(state)
        self._agenda.advance()
        self._solve()
        self._command_joints()
        self._agenda.publish(self._tick, self._holds)
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
        self.body.begin(self.body.initial_joints, {}, state.command)
        restore(self, tree)
        self.takeover.done = True
        self._agenda.open()
        self._agenda.publish(self._tick, self._holds)

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

    def desired_copy(self, timeout_s: float) -> DesiredState:
        """Return a copy of the desired state. Raises GoalRefusedError when no tick comes."""
        return self._handout.ask(timeout_s)

    def take_safety_reports(self) -> list[SafetyReport]:
        """Return which hazards began and ended since the last call."""
        return self._holds.take_reports()

    def take_events(self) -> list[Event]:
        """Return what happened to goals since the last call."""
        return self._agenda.take_events()

    @property
    def waits(self) -> tuple[SafetyCause, ...]:
        """Which hazards hold the robot until an operator says resume."""
        return self._holds.waiting

    def set_stale(self, stale: bool) -> None:
        """Note that states stopped coming: goals are refused until they come again."""
        if self.requests.situation.stale != stale:
            self.requests.situation = replace(self.requests.situation, stale=stale)

    def snapshot(self) -> Snapshot:
        """Return what the controller does now."""
        body, switching = self.body, self.body.switching if self.takeover.done else None
        return summarize(
            self._tick, self.phase, self._message(), body.retargeting, switching, body.measured
        )

    # --- start, hold and go on -------------------------------------------------------------------
    def _take_over(self, state: RobotState) -> None:
        """Begin with the robot from the command in force, or hold until that is possible."""
        if self._holds:
            return
        self.takeover.attempt(state, self._holds, self._stop)
        if self.takeover.done:
            self._agenda.open()
            self._agenda.abort("the controller was restarted; hands stay where they are")
            self._rejoin(state)

    def _guard_state(self, state: RobotState) -> None:
        """Look for what forbids to use this state, or to move on."""
        if self._holds:
            self._abort_when_overdue()
            self._holds.advance(self._tick)
        block = state.tick // SENSE_EVERY
        self._measures, self._block = block > self._block, block
        used = self._measures or not self.takeover.done
        for hazard in self._guards.inspect(state, used=used):
            self._holds.found(hazard, self._tick)

    def _obey_operator(self, state: RobotState) -> None:
        asks = self._holds.active("no_snapshot")
        if self._stop.obey(state.mode, self._holds, self._tick) and asks:
            self.takeover.adopts = True

    def _hold(self, state: RobotState) -> JointCommand:
        """Keep the command in force; goals wait, or are aborted where this is more than a pause."""
        self._abort_when_overdue()
        holds = self._holds
        if state.mode == "stopped" or not self.takeover.done or holds.active("command_not_taken"):
            self._keep(state)
        if not holds.active("sensor_not_finite"):
            self._sense(state)
        self._agenda.publish(self._tick, self._holds)
        return self._answer()

    def _wait(self, state: RobotState) -> JointCommand:
        """Say the last command again, until the robot takes it."""
        self._sense(state)
        self._agenda.publish(self._tick, self._holds)
        return self._answer()

    def _abort_when_overdue(self) -> None:
        """End goals once this is more than a pause."""
        if not self._aborted and self._holds.must_hold(self._tick):
            self._aborted = True
            self._agenda.abort(self._holds.text())

    def _go_on(self, state: RobotState) -> None:
        """Begin again from the command in force, after a hold or where it is not ours."""
        foreign = largest_difference(state.command, self._command) > FOREIGN_COMMAND
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

    # --- parts of a tick -------------------------------------------------------------------------
    def _sense(self, state: RobotState) -> None:
        """Measure once in four ticks, and look at it at the next two: no tick does all."""
        if not self.takeover.done:
            return
        if not self._measures:
            self._look()
            return
        while self._unseen:
            # A tick did not come.
            self._look()
        self.body.measure(state)
        self._unseen = 2

    def _look(self) -> None:
        """Look at the contacts by the newest measurement; at the next call, give way to it."""
        if self._unseen == 2:
            overload = self._guards.inspect_loads(self.body.measured, SENSE_EVERY * self.dt)
            if overload is not None:
                self._holds.found(overload, self._tick)
            for finding in self.body.supervise():
                self._holds.tell(finding.hazard(), self._tick)
        elif self._unseen == 1:
            self.body.give_way()
        self._unseen = max(self._unseen - 1, 0)

    def _solve(self) -> None:
        self._solved = self.body.solve(self._blend.advance())
        hazard = self._guards.inspect_solution(self._solved)
        if hazard is not None:
            self._holds.found(hazard, self._tick)

    def _command_joints(self) -> None:
        """Send what the robot can follow; after a fault the last command, and hold from here on."""
        command = self._blend.mix(self.body.command())
        hazard = self._restraint.apply(command, self._command)
        if hazard is None:
            self._command = command
        else:
            self._holds.found(hazard, self._tick)

    def _answer(self) -> JointCommand:
        return JointCommand(tick=self._tick, position=self._command.copy())

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
        if not self.takeover.done or (not self._blend.done and self.body.switching.phase == "hold"):
            return "starting"
        return self.body.switching.phase
