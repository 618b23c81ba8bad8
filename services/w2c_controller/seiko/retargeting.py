"""SEIKO Retargeting: desired posture and contact wrenches, one QP a tick, integrated.

Nothing measured enters. What comes out is a quasi-static motion that respects balance, friction,
joint and torque limits, with targets followed as closely as those allow.
"""

from collections.abc import Mapping

import numpy as np
import numpy.typing as npt

from w2c.errors import ControlError, SolverError
from w2c_controller.kinematics.model import ControlledModel, Kinematics, standing_configuration
from w2c_controller.parameters import EFFECTORS, FEET, HANDS, Parameters
from w2c_controller.seiko.balance import balance_at_rest
from w2c_controller.seiko.contacts import (
    Enabled,
    normal_force_limits,
    per_contact_set,
    wrench_rate_limits,
)
from w2c_controller.seiko.desired import DesiredState, with_contact
from w2c_controller.seiko.integration import advance
from w2c_controller.seiko.program import ProgramBuilder
from w2c_controller.solvers import FallbackSolver, Solver

Vector = npt.NDArray[np.float64]
Matrix = npt.NDArray[np.float64]

LIGHTEST = 0.5
"""Normal force of a contact that may be dropped, at most [N]."""


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
        self._configured_min = np.array(
            [normal_force_limits(parameters.limits, k)[0] for k in range(4)]
        )
        self._lightest = np.array([_lightest(parameters, dt, k) for k in range(4)])
        self.state = DesiredState(q=np.zeros(controlled.model.nq), posture=np.zeros(controlled.nj))
        self._builders = per_contact_set(
            controlled.nv, lambda layout: ProgramBuilder(layout, controlled, parameters, dt)
        )
        if isinstance(self._solver, FallbackSolver):
            for builder in self._builders.values():
                self._solver.prepare(builder.program)

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
            self._lean(state, k, rotation)
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

        Raises:
            ControlError: it is a contact already.
        """
        state = self.state
        if state.enabled[contact]:
            raise ControlError(
                f"the {EFFECTORS[contact]} is a contact already; release it, and wait until it is "
                "free, before it makes another"
            )
        self._lean(state, contact, contact_rotation)
        state.wrenches[contact] = 0.0
        state.force_min[contact] = 0.0
        state.releasing[contact] = state.lost[contact] = state.pushing[contact] = False
        self.kinematics.update_frames(state.q)
        state.target_positions[contact] = self.kinematics.positions[contact]
        state.target_rotations[contact] = self.kinematics.rotations[contact]
        state.enabled = with_contact(state.enabled, contact, True)

    def release(self, contact: int, *, lost: bool = False) -> None:
        """Begin to unload a contact; it is free when `enabled` no longer holds it.

        Args:
            contact: Index of the end effector.
            lost: Whether it carries nothing any more: then as fast as the others can take over.
        """
        if self.state.enabled[contact]:
            self.state.releasing[contact] = True
            self.state.lost[contact] = lost
            self.state.force_min[contact] = 0.0

    def keep(self, contact: int) -> None:
        """Load a contact again that was being released."""
        self.state.releasing[contact] = self.state.lost[contact] = False

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
        state, kinematics = self.state, self.kinematics
        builder = self._builders[state.enabled]
        try:
            x = self._solver.solve(builder.fill(kinematics, state))
        except SolverError:
            self.failures += 1
            state.velocity[:] = 0.0
            state.torque[:] = kinematics.static[6:]
            return False
        first, second, third, fourth = state.releasing
        light = advance(
            self.dt,
            scale,
            x,
            builder.program.lower,
            builder.program.upper,
            kinematics.static,
            builder.torque_rows,
            kinematics.jacobians,
            self.controlled.tree.supports,
            state.levers,
            builder.layout.table,
            (first, second, third, fourth),
            self.controlled.lower,
            self.controlled.upper,
            self._configured_min,
            self._lightest,
            state.q,
            state.velocity,
            state.torque,
            state.wrenches,
            state.force_min,
            state.target_positions,
        )
        if light:
            self._drop(light)
        return True

    def _lean(self, state: DesiredState, contact: int, contact_rotation: Matrix) -> None:
        """Note the surface of a contact, and where on it an end effector touches."""
        state.contact_rotations[contact] = contact_rotation
        if contact in HANDS:
            radius = self.controlled.hand_radius[contact - HANDS[0]]
            state.levers[contact] = -radius * contact_rotation[:, 2]

    def _drop(self, light: int) -> None:
        """Free the contacts of this mask; one foot stays."""
        state = self.state
        for k in range(4):
            if light >> k & 1:
                remaining = with_contact(state.enabled, k, False)
                if remaining not in self._builders:
                    continue
                state.enabled = remaining
                state.releasing[k] = state.lost[k] = state.pushing[k] = False
                state.wrenches[k] = 0.0


def _lightest(parameters: Parameters, dt: float, contact: int) -> float:
    """Return the normal force below which a released contact is dropped [N]: that of one tick."""
    rate = float(wrench_rate_limits(parameters.limits, contact)[2])
    return min(dt * rate, LIGHTEST)
