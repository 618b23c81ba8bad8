"""SEIKO Controller: the command offset that makes a robot of springs carry the desired wrenches.

The rigid desired state goes in, with what is measured; a flexible model of the commanded robot is
moved by one QP a tick, and its command differs from the desired angles by the offset. The offset
never jumps: contact switches change what moves it, not its value.
"""

import numpy as np
import numpy.typing as npt

from w2c.errors import ControlError, SolverError
from w2c_controller.kinematics.model import ControlledModel, Kinematics
from w2c_controller.parameters import Parameters
from w2c_controller.seiko.contacts import per_contact_set
from w2c_controller.seiko.flexible_model import FlexibleState, find_equilibrium
from w2c_controller.seiko.flexible_program import FlexibleProgram
from w2c_controller.seiko.force_feedback import TorqueLimits, WrenchFeedback
from w2c_controller.seiko.retargeting import Retargeting
from w2c_controller.sensing.loads import Measured
from w2c_controller.solvers import FallbackSolver, Solver

Vector = npt.NDArray[np.float64]


class ForceControl:
    """Owns the flexible state and moves it by one tick at a time."""

    def __init__(
        self,
        controlled: ControlledModel,
        parameters: Parameters,
        dt: float,
        solver: Solver | None = None,
    ) -> None:
        self._controlled = controlled
        self._settings = parameters.force_control
        self._solver = solver if solver is not None else FallbackSolver()
        self._programs = per_contact_set(
            controlled.nv, lambda layout: FlexibleProgram(layout, controlled, parameters, dt)
        )
        self._command = np.zeros(controlled.nj)
        self._rates = np.zeros((4, 6))
        self.kinematics = Kinematics(controlled)
        """Of the flexible robot."""
        self.feedback = WrenchFeedback(self._settings, dt)
        self.torque_limits = TorqueLimits(self._settings, controlled.effort, dt)
        self.flexible = FlexibleState(
            q=np.zeros(controlled.model.nq), offset=np.zeros(controlled.nj)
        )
        self.failures = 0
        """Ticks without a solution: the offset stayed."""
        if isinstance(self._solver, FallbackSolver):
            for program in self._programs.values():
                self._solver.prepare(program.program)

    @property
    def active(self) -> bool:
        """Whether there is an offset at all."""
        return self._settings.mode != "off"

    @property
    def offset(self) -> Vector:
        """Of the command from the desired angles (nj,) [rad]."""
        return self.flexible.offset

    def reset(self, retargeting: Retargeting) -> None:
        """Start where the desired posture is the equilibrium of the command: offset = tau / K."""
        desired = retargeting.state
        self.flexible = FlexibleState.wound_up(desired, self._controlled.stiffness)
        self._rates[:] = 0.0
        self.feedback.reset(desired)
        self.feedback.switch(desired.enabled)
        self.torque_limits.reset()
        if not self.active:
            self.flexible.offset[:] = 0.0

    def tick(self, retargeting: Retargeting, measured: Measured) -> bool:
        """Move the offset by one period. Returns False where no solution was found: it stayed.

        Args:
            retargeting: After its own tick.
            measured: Wrenches and torques, NaN where a sensor reads NaN.
        """
        if not self.active:
            return True
        desired, flexible, kinematics = retargeting.state, self.flexible, self.kinematics
        if desired.enabled != flexible.enabled:
            self._switch(retargeting)
        np.add(desired.q[7:], flexible.offset, out=self._command)
        kinematics.update_statics(
            flexible.q,
            flexible.wrenches,
            desired.contact_rotations,
            flexible.enabled,
            desired.levers,
        )
        self.feedback.step(desired, measured, self._rates)
        self.torque_limits.step(measured.torque, kinematics.static[6:])
        program = self._programs[flexible.enabled]
        qp = program.fill(
            kinematics,
            flexible,
            retargeting.kinematics,
            self._command,
            self.feedback.effort_rates,
            self.torque_limits.limits,
        )
        try:
            x = self._solver.solve(qp)
        except SolverError:
            self.failures += 1
            self._rates[:] = 0.0
            self.settle(retargeting)
            return False
        program.advance(x, flexible, self._rates, kinematics, desired.levers)
        return True

    def _switch(self, retargeting: Retargeting) -> None:
        """Take over the contact set; a new contact is where the flexible robot has it now."""
        desired, flexible = retargeting.state, self.flexible
        self.kinematics.update_frames(flexible.q)
        for k in range(4):
            if desired.enabled[k] != flexible.enabled[k]:
                flexible.wrenches[k] = desired.wrenches[k]
                flexible.contact_positions[k] = self.kinematics.positions[k]
                flexible.contact_rotations[k] = self.kinematics.rotations[k]
                self._rates[k] = 0.0
        flexible.enabled = desired.enabled
        self.feedback.switch(desired.enabled)
        self.settle(retargeting)

    def settle(self, retargeting: Retargeting) -> None:
        """Bring the flexible robot to the equilibrium of its command, or leave it as it is."""
        desired, before = retargeting.state, self.flexible.copy()
        command = desired.q[7:] + before.offset
        try:
            find_equilibrium(
                self._controlled,
                self.kinematics,
                self.flexible,
                command,
                desired.contact_rotations,
                desired.levers,
            )
        except ControlError:
            self.failures += 1
            self.flexible = before
