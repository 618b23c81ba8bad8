"""SEIKO Retargeting: desired posture and contact wrenches, one QP a tick, integrated.

Nothing measured enters. What comes out is a quasi-static motion that respects balance, friction,
joint and torque limits, with targets followed as closely as those allow.
"""

from collections.abc import Mapping

import numpy as np
import numpy.typing as npt

from w2c.errors import SolverError
from w2c_controller.balance import balance_at_rest
from w2c_controller.contacts import ContactLayout, Enabled, normal_force_limits
from w2c_controller.desired import DesiredState, with_contact
from w2c_controller.model import ControlledModel, Kinematics, standing_configuration
from w2c_controller.parameters import FEET, Parameters
from w2c_controller.program import ProgramBuilder
from w2c_controller.solvers import FallbackSolver, Solver

Vector = npt.NDArray[np.float64]
Matrix = npt.NDArray[np.float64]

LIGHTEST = 0.5
"""Normal force of a contact that may be dropped, at most [N]."""
FORCE_MIN_SLACK = 0.01
"""How far the growing minimum of a new contact stays below its force [N]."""


class Retargeting:
    """Owns the desired state and moves it by one tick at a time."""

    def __init__(
        self,
        controlled: ControlledModel,
        parameters: Parameters,
        dt: float,
        solver: Solver | None = None,
    ) -> None:
        self.controlled = controlled
        self.parameters = parameters
        self.dt = dt
        self.kinematics = Kinematics(controlled)
        self.failures = 0
        """Ticks without a solution: the robot held still instead."""
        self._solver = solver if solver is not None else FallbackSolver()
        self._builders: dict[Enabled, ProgramBuilder] = {}
        self._configured_min = np.array(
            [normal_force_limits(parameters.limits, k)[0] for k in range(4)]
        )
        self.state = DesiredState(q=np.zeros(controlled.model.nq), posture=np.zeros(controlled.nj))
        for left in (False, True):
            for right in (False, True):
                self._builder((True, True, left, right))

    def reset(self, joints: Vector, supports: Mapping[int, Matrix] | None = None) -> None:
        """Stand in this posture, world origin midway between the soles.

        Args:
            joints: (nj,) joint angles in the model's order [rad].
            supports: Hands that lean already, each with its world_from_contact (3, 3).

        Raises:
            ControlError: the posture cannot stand.
        """
        joints = np.clip(joints, self.controlled.lower, self.controlled.upper)
        q = standing_configuration(self.controlled, joints)
        state = DesiredState(q=q, posture=joints.copy(), velocity=np.zeros(self.controlled.nv))
        for k in FEET:
            state.force_min[k] = self._configured_min[k]
        for k, rotation in (supports or {}).items():
            state.enabled = with_contact(state.enabled, k, True)
            state.contact_rotations[k] = rotation
        balance_at_rest(self.controlled, self.kinematics, state, self.parameters, self._solver)
        state.target_positions[:] = self.kinematics.positions
        state.target_rotations[:] = self.kinematics.rotations
        self.state = state

    def adopt(self, state: DesiredState) -> None:
        """Go on from a copy of another state, to look ahead."""
        self.state = state.copy()
        self.kinematics.update_frames(self.state.q)

    @property
    def standing(self) -> Enabled:
        """Contacts that bear weight now."""
        return self.state.enabled

    def enable(self, contact: int, contact_rotation: Matrix) -> None:
        """Make a contact where the end effector is now, without force yet.

        Args:
            contact: Index of the end effector.
            contact_rotation: (3, 3) world_from_contact, z out of the surface; a foot's wrench is
                in its sole frame, whatever this says.
        """
        state = self.state
        state.contact_rotations[contact] = contact_rotation
        state.wrenches[contact] = 0.0
        state.force_min[contact] = 0.0
        state.releasing[contact] = False
        self.kinematics.update_frames(state.q)
        state.target_positions[contact] = self.kinematics.positions[contact]
        state.target_rotations[contact] = self.kinematics.rotations[contact]
        state.enabled = with_contact(state.enabled, contact, True)

    def release(self, contact: int) -> None:
        """Begin to unload a contact; it is free when `enabled` no longer holds it."""
        if self.state.enabled[contact]:
            self.state.releasing[contact] = True
            self.state.force_min[contact] = 0.0

    def keep(self, contact: int) -> None:
        """Load a contact again that was being released."""
        self.state.releasing[contact] = False

    def loaded(self, contact: int) -> bool:
        """Return whether a contact carries at least its configured minimum."""
        return bool(
            self.state.enabled[contact]
            and self.state.force_min[contact] >= self._configured_min[contact]
        )

    def tick(self, scale: float = 1.0) -> bool:
        """Move the desired state by one period. Returns False where no solution was found: it held.

        Args:
            scale: In [0, 1], multiplies the solution: 0 at the start, 1 after the blend.
        """
        state, kinematics, controlled = self.state, self.kinematics, self.controlled
        builder = self._builder(state.enabled)
        kinematics.update_statics(state.q, state.wrenches, state.contact_rotations, state.enabled)
        try:
            x = scale * self._solver.solve(builder.fill(kinematics, state))
        except SolverError:
            self.failures += 1
            state.velocity = np.zeros(controlled.nv)
            state.torque = kinematics.static[6:].copy()
            return False
        state.velocity = x[: controlled.nv]
        state.torque = kinematics.static[6:] + self.dt * builder.torque_rate(x)
        state.q = kinematics.integrate(state.q, self.dt * state.velocity)
        np.clip(state.q[7:], controlled.lower, controlled.upper, out=state.q[7:])
        for k, where in builder.layout.slices.items():
            size = where.stop - where.start
            state.wrenches[k, :size] += self.dt * x[where]
        self._grow_force_minimum()
        self._drop_unloaded()
        return True

    def _builder(self, enabled: Enabled) -> ProgramBuilder:
        """Return the program of a contact set; all sets on two feet are made at the start."""
        if enabled not in self._builders:
            layout = ContactLayout(enabled, self.controlled.nv)
            self._builders[enabled] = ProgramBuilder(
                layout, self.controlled, self.parameters, self.dt
            )
        return self._builders[enabled]

    def _grow_force_minimum(self) -> None:
        """Raise the minimum of a new contact with its force, so that it is never infeasible."""
        state = self.state
        for k in range(4):
            normal = float(state.wrenches[k, 2])
            configured = float(self._configured_min[k])
            growing = (
                state.enabled[k] and not state.releasing[k] and state.force_min[k] < configured
            )
            if growing and normal > state.force_min[k] + FORCE_MIN_SLACK:
                state.force_min[k] = min(normal - FORCE_MIN_SLACK, configured)

    def _drop_unloaded(self) -> None:
        """Free a released contact whose force is within one tick of zero."""
        state = self.state
        limits = self.parameters.limits
        for k in range(4):
            rate = limits.foot_force_rate if k in FEET else limits.hand_force_rate
            threshold = min(self.dt * rate, LIGHTEST)
            if state.enabled[k] and state.releasing[k] and state.wrenches[k, 2] < threshold:
                state.enabled = with_contact(state.enabled, k, False)
                state.releasing[k] = False
                state.wrenches[k] = 0.0
