"""The controller of one robot, pure of bus and clocks: one state in, one command out.

    command = desired posture + tau / K

tau is the torque of the static equilibrium with all contact forces: a position-controlled joint of
stiffness K bears it when it is wound up by tau / K. Without it a hand touches, and carries nothing.
"""

from collections import deque
from dataclasses import dataclass
from queue import Empty, SimpleQueue

import numpy as np
import numpy.typing as npt

from w2c.errors import GoalRefusedError
from w2c.geometry import frame_from_normal
from w2c.messages import JointCommand, RobotDescription, RobotState
from w2c.messages.control import Phase
from w2c_controller.desired import DesiredState
from w2c_controller.events import Event, EventState
from w2c_controller.filters import Blend
from w2c_controller.gaze import Gaze, find_neck
from w2c_controller.hands import Hands
from w2c_controller.model import Kinematics, build_model, standing_configuration
from w2c_controller.parameters import HANDS, Parameters
from w2c_controller.requests import Request, Requests, Situation
from w2c_controller.retargeting import Retargeting
from w2c_controller.sensing import LoadEstimator, Measured
from w2c_controller.switching import Switching

Vector = npt.NDArray[np.float64]
Matrix = npt.NDArray[np.float64]

FRESH_POSTURE = 0.05
"""A robot within this of its initial posture starts from it exactly [rad]."""
LEANING_FORCE = 15.0
"""A hand that measures more at the start leans: it is a support from the first tick on [N]."""
FOREIGN_COMMAND = 0.03
"""A command in force that differs more from ours is not ours: go on from it [rad]."""
SENSE_EVERY = 4
"""Ticks between two looks at the loads: 125 Hz, well above the 10 Hz of their filter."""
STOPPED = "stopped by the operator"
AWAY = 0.05
"""A hand farther from its rest can be released [m]."""


@dataclass(frozen=True)
class Snapshot:
    """What the controller does, for the status message; arrays over end effectors, in the world."""

    tick: int
    phase: Phase
    goal_id: str
    end_effector: str
    task: str
    distance: float
    in_contact: tuple[bool, bool, bool, bool]
    desired_forces: Matrix
    """(4, 3) [N]"""
    positions: Matrix
    """(4, 3) [m]"""
    loads: Vector
    """(4,) [N]"""
    solver_failures: int
    message: str


class Controller:
    """Retargeting, switching and elastic compensation around one robot's state."""

    def __init__(self, description: RobotDescription, parameters: Parameters | None = None) -> None:
        self.parameters = parameters or Parameters()
        self.description = description
        self.model = build_model(description)
        self.dt = description.period_ns * 1e-9
        self.retargeting = Retargeting(self.model, self.parameters, self.dt)
        self.requests = Requests(self.model.hand_radius)
        self._initial = np.array(description.initial_position)
        self._at_rest = Kinematics(self.model)
        self._at_rest.update_frames(
            standing_configuration(self.model, self._initial[self.model.joint_indices])
        )
        self._neck = find_neck(description, self.model.model)
        self._gaze: Gaze | None = None
        self._hands: Hands
        self._switching: Switching
        self._loads: LoadEstimator
        self._started = False
        self._stopped = False
        self._events: list[Event] = []
        self._measured = Measured(feet=np.zeros((2, 6)), hands=np.zeros((2, 3)))
        self._command = self._initial.copy()
        self._blend = Blend(self._initial, self.parameters.motion.blend_time, self.dt)
        self._tick = 0
        self._message = ""
        self._frozen = False
        self._stop_reason = STOPPED
        self._copies: deque[SimpleQueue[DesiredState]] = deque()

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
        if not self._started:
            self._start(state)
        if state.mode == "stopped" or self._frozen:
            return self._hold_stopped(state)
        if self._stopped:
            self._stopped = False
            self._stop_reason = STOPPED
            self._rejoin(state)
        elif np.max(np.abs(state.command - self._command)) > FOREIGN_COMMAND:
            self._rejoin(state)
        self._begin_requests()
        self._sense(state)
        self._events.extend(self._switching.step(self._measured))
        self._hands.step()
        scale = self._blend.advance()
        solved = self.retargeting.tick(scale)
        self._message = "" if solved else "no solution of the balance problem: the robot holds"
        command = self._blend.mix(self._own_command())
        if np.isfinite(command).all():
            self._command = command
        self._publish_situation()
        if self._copies:
            self._copies.popleft().put(self.retargeting.state.copy())
        return JointCommand(tick=state.tick, position=self._command.copy())

    def freeze(self, reason: str) -> None:
        """Hold from the next tick on, until the driver was stopped and resumed. From any thread."""
        self._stop_reason = f"stopped: {reason}" if reason else STOPPED
        self._frozen = True

    def desired_copy(self, timeout_s: float) -> DesiredState:
        """Return a copy of the desired state, made by the loop for another thread.

        Raises:
            GoalRefusedError: no tick came.
        """
        slot: SimpleQueue[DesiredState] = SimpleQueue()
        self._copies.append(slot)
        try:
            return slot.get(timeout=timeout_s)
        except Empty as error:
            raise GoalRefusedError(
                f"the robot did not move on within {timeout_s} s (stopped, or no state): no preview"
            ) from error

    def take_events(self) -> list[Event]:
        """Return what happened to goals since the last call."""
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
        retargeting = self.retargeting
        state, rotations = retargeting.state, retargeting.kinematics.rotations
        goal = self._switching.goal if self._started else None
        return Snapshot(
            tick=self._tick,
            phase=self._phase(),
            goal_id=goal.goal_id if goal else "",
            end_effector=goal.end_effector if goal else "",
            task=goal.task if goal else "",
            distance=self._switching.distance() if goal else -1.0,
            in_contact=state.enabled,
            desired_forces=np.stack([state.world_force(k, rotations) for k in range(4)]),
            positions=retargeting.kinematics.positions.copy(),
            loads=self._normal_loads(),
            solver_failures=retargeting.failures,
            message=self._message,
        )

    # --- start, stop and go on -------------------------------------------------------------------
    def _start(self, state: RobotState) -> None:
        """Take over a robot that stands, or that leans already."""
        self._loads = LoadEstimator(self.model, SENSE_EVERY * self.dt)
        measured = self._loads.update(state)
        joints = state.position[self.model.joint_indices]
        initial = self._initial[self.model.joint_indices]
        supports = {}
        for k in HANDS:
            force = measured.hands[k - HANDS[0]]
            if float(np.linalg.norm(force)) > LEANING_FORCE:
                supports[k] = frame_from_normal(force)
        fresh = not supports and float(np.max(np.abs(joints - initial))) < FRESH_POSTURE
        self.retargeting.reset(initial if fresh else joints, supports)
        self.retargeting.state.posture = initial.copy()
        self._hands = Hands(self.retargeting, self._at_rest)
        self._switching = Switching(self.retargeting, self._hands)
        self._measured = measured
        if self._neck is not None:
            self._gaze = Gaze(self._neck, state.command[self._neck.bus_indices], self.dt)
        self._rejoin(state)
        self._started = True

    def _rejoin(self, state: RobotState) -> None:
        """Go on from the command in force, whoever gave it."""
        self._command = state.command.copy()
        self._blend = Blend(self._command, self.parameters.motion.blend_time, self.dt)

    def _hold_stopped(self, state: RobotState) -> JointCommand:
        """Freeze: the driver holds its command; answer with it."""
        reason = self._stop_reason
        if not self._stopped:
            self._stopped = True
            self._switching.abort(reason)
            for request in self.requests.clear():
                self._events.append(_event(request, "aborted", reason))
            self._events.extend(self._switching.step(self._measured))
            self._command = state.command.copy()
        if state.mode == "stopped":
            # From here on the driver's own mode says when to go on.
            self._frozen = False
            self._command = state.command.copy()
        self._sense(state)
        self._message = f"{reason}; resume to go on"
        self._publish_situation()
        return JointCommand(tick=state.tick, position=self._command.copy())

    # --- parts of a tick -------------------------------------------------------------------------
    def _sense(self, state: RobotState) -> None:
        if state.tick % SENSE_EVERY == 0:
            left, right = self.retargeting.state.enabled[:2]
            feet = (0, 1) if left == right else (0, 0) if left else (1, 1)
            self._measured = self._loads.update(state, feet)

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
        """Return the desired posture wound up by its torques (n,), in the bus's order [rad]."""
        state, model = self.retargeting.state, self.model
        joints = state.q[7:] + self.parameters.motion.ahead_time * state.velocity[6:]
        command = self._initial.copy()
        command[model.joint_indices] = joints + state.torque / model.stiffness
        if self._gaze is not None:
            leaning = any(state.enabled[k] for k in HANDS)
            self._gaze.move_head(command, self.retargeting.kinematics, leaning=leaning)
        return command

    def _publish_situation(self) -> None:
        switching, state = self._switching, self.retargeting.state
        away = [
            state.enabled[k]
            or float(np.abs(self._hands.targets[k] - self._hands.rest[k]).max()) > AWAY
            for k in HANDS
        ]
        self.requests.situation = Situation(
            tick=self._tick,
            ready=True,
            stopped=self._stopped,
            busy_id=switching.busy_with(),
            busy_effector=switching.busy_effector(),
            away=(away[0], away[1]),
            enabled=state.enabled,
        )

    def _normal_loads(self) -> Vector:
        """Return the measured normal forces (4,) [N]."""
        loads = np.zeros(4)
        loads[:2] = self._measured.feet[:, 2]
        if self._started:
            for k in HANDS:
                loads[k] = self._switching.normal_load(k, self._measured)
        return loads

    def _phase(self) -> Phase:
        if self._stopped:
            return "stopped"
        if not self._started or (not self._blend.done and self._switching.phase == "hold"):
            return "starting"
        return self._switching.phase


def _event(request: Request, state: EventState, reason: str = "") -> Event:
    task = request.goal.task if request.goal is not None else "contact"
    return Event(request.goal_id, request.effector, task, state, reason)
