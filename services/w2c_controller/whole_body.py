"""The parts that make a command, around one desired state, and the order in which they work.

    measured loads -> switching -> targets -> Retargeting -> force control -> command

Whether they may work at all is the affair of `Controller`.
"""

from collections.abc import Mapping

import numpy as np
import numpy.typing as npt

from w2c.messages import RobotDescription, RobotState
from w2c_controller.kinematics.model import ControlledModel, Kinematics, standing_configuration
from w2c_controller.kinematics.vectors import largest_difference, look_ahead
from w2c_controller.motion.end_effectors import EndEffectors
from w2c_controller.motion.gaze import Gaze, find_neck
from w2c_controller.parameters import HANDS, LEFT_HAND, RIGHT_HAND, Parameters
from w2c_controller.safety.guards import SENSE_EVERY
from w2c_controller.seiko.force_control import ForceControl
from w2c_controller.seiko.retargeting import Retargeting
from w2c_controller.sensing.admittance import Admittance
from w2c_controller.sensing.loads import LoadEstimator, Measured
from w2c_controller.sensing.payload import Payloads
from w2c_controller.solvers import FallbackSolver
from w2c_controller.switching.events import Event
from w2c_controller.switching.supervision import Finding
from w2c_controller.switching.switching import Switching

Vector = npt.NDArray[np.float64]
Matrix = npt.NDArray[np.float64]

AWAY = 0.05
"""A hand farther from its rest can be released [m]."""


class WholeBody:
    """Sensing, switching, Retargeting, force control and gaze of one robot."""

    def __init__(
        self,
        description: RobotDescription,
        model: ControlledModel,
        parameters: Parameters,
        solvers: tuple[FallbackSolver, FallbackSolver],
    ) -> None:
        """Make all parts; none works before `begin`.

        Args:
            description: Of the robot.
            model: Of the same robot.
            parameters: Of all parts.
            solvers: Of the Retargeting, of the force control.
        """
        self._model = model
        self._ahead_time = parameters.motion.ahead_time
        self._dt = description.period_ns * 1e-9
        self._initial = np.array(description.initial_position)
        period = SENSE_EVERY * self._dt
        self.retargeting = Retargeting(model, parameters, self._dt, solvers[0])
        self.force_control = ForceControl(model, parameters, self._dt, solvers[1])
        self._admittance = Admittance(parameters.force_control, period)
        self.at_rest = Kinematics(model)
        """Of the initial posture"""
        self.at_rest.update_frames(standing_configuration(model, self.initial_joints))
        self._neck = find_neck(description, model.model)
        self._loads = LoadEstimator(model, period)
        self._payloads = Payloads(model, parameters.force_control, period)
        self.measured = Measured(
            feet=np.zeros((2, 6)), hands=np.zeros((2, 3)), torque=np.zeros(model.nj)
        )
        """The newest, without what the hands carry"""
        self._far = (False, False)
        """Hands that are away from their rest, as known since the last `give_way`"""
        self._gaze: Gaze | None = None
        self.end_effectors: EndEffectors
        """Targets of what is free; exist after `begin`."""
        self.switching: Switching
        """The state machine of goals; exists after `begin`."""

    @property
    def initial_joints(self) -> Vector:
        """Return the initial posture (nj,) in the model's order [rad]."""
        return np.asarray(self._initial[self._model.joint_indices])

    def begin(
        self,
        joints: Vector,
        supports: Mapping[int, Matrix],
        command: Vector,
        measured: Measured | None = None,
    ) -> None:
        """Stand in a posture, leaning on some hands.

        Args:
            joints: (nj,) in the model's order [rad].
            supports: Hands that lean, each with its world_from_contact (3, 3).
            command: (n,) in force, in the order of the bus [rad].
            measured: Loads of this posture: what hangs on free hands belongs to it; None: unknown.

        Raises:
            ControlError: the posture cannot stand.
        """
        if measured is not None:
            self._payloads.begin(measured, (HANDS[0] not in supports, HANDS[1] not in supports))
            self.measured = self._payloads.relieve(measured)
        self.retargeting.reset(joints, supports)
        self.retargeting.state.posture = self.initial_joints.copy()
        self.force_control.reset(self.retargeting)
        self.end_effectors = EndEffectors(self.retargeting, self.at_rest)
        self.end_effectors.displacements = self._admittance.displacements
        self.switching = Switching(self.retargeting, self.end_effectors, SENSE_EVERY * self._dt)
        if self._neck is not None:
            self._gaze = Gaze(self._neck, command[self._neck.bus_indices], self._dt)

    def weigh(self, state: RobotState) -> Measured:
        """Return the loads of one state, before `begin`."""
        return self._loads.update(state)

    def measure(self, state: RobotState) -> None:
        """Take the measurements of one state; `supervise` and `give_way` follow."""
        enabled = self.retargeting.state.enabled
        left, right = enabled[:2]
        feet = (0, 1) if left == right else (0, 0) if left else (1, 1)
        measured = self._loads.update(state, feet)
        if self.switching.phase == "hold":
            self._payloads.learn(measured, (not enabled[HANDS[0]], not enabled[HANDS[1]]))
        self.measured = self._payloads.relieve(measured)

    def supervise(self) -> list[Finding]:
        """Look at the newest forces; returns what is wrong with the contacts."""
        return self.switching.supervise(self.measured)

    def give_way(self) -> None:
        """Let what is free give way to the newest forces, and note which hands are away."""
        retargeting = self.retargeting
        rotations, enabled = retargeting.kinematics.rotations, retargeting.state.enabled
        self._admittance.step(self.measured, rotations, enabled)
        self._far = self._is_far(LEFT_HAND), self._is_far(RIGHT_HAND)

    def switch(self) -> list[Event]:
        """Advance goals by one tick; returns what happened to them."""
        events = self.switching.step(self.measured)
        self.end_effectors.step()
        return events

    def solve(self, scale: float) -> bool:
        """Move the desired state, and the offset that lets the robot follow it under load.

        Args:
            scale: In [0, 1], of the motion.

        Returns:
            Whether both programs had a solution.
        """
        solved = self.retargeting.tick(scale)
        return self.force_control.tick(self.retargeting, self.measured) and solved

    def command(self) -> Vector:
        """Return the desired posture with its offset (n,), in the order of the bus [rad]."""
        state = self.retargeting.state
        command = self._initial.copy()
        look_ahead(
            state.q,
            state.velocity,
            self._ahead_time,
            self.force_control.offset,
            self._model.joint_indices,
            command,
        )
        if self._gaze is not None:
            _, _, left, right = state.enabled
            leaning = left or right
            self._gaze.move_head(command, self.retargeting.kinematics, leaning=leaning)
        return command

    def away(self) -> tuple[bool, bool]:
        """Return which hands lean, or are away from their rest: left, right."""
        _, _, left, right = self.retargeting.state.enabled
        return left or self._far[0], right or self._far[1]

    def _is_far(self, hand: int) -> bool:
        return (
            largest_difference(self.end_effectors.targets[hand], self.end_effectors.rest[hand])
            > AWAY
        )
