"""The Retargeting QP, one preallocated program a contact set.

x = [v (nv); wrench rates].

With s(q, lambda) the static residual, T_q and T_l its derivatives and tau = s_J (see
`model.Kinematics`),

    min  sum w |J x - target|^2
    s.t. Jacobians of touching points v = drift / dt,   (T_q v + T_l lambda')_base = -s_base / dt,
         joint, velocity, torque, wrench rate and normal force limits, friction cones after the
         step dt

(SEIKO Retargeting: Rouxel et al., T-Mech 2022, and RA-L 2024, section III). Costs: joint velocity
and posture; centroidal momentum; poses of free end effectors, orientation of hands in contact;
torques; and wrenches towards zero, towards the commanded force of a contact that pushes, or off a
contact that is released.

Every limit is widened to what the state has already, so that x = 0 satisfies all inequalities: a
state beyond a limit may not go farther, and is not thrown back within one tick.
"""

from typing import Any

import numpy as np
import numpy.typing as npt

from w2c_controller.kinematics.model import ControlledModel, Kinematics
from w2c_controller.parameters import FEET, HANDS, Parameters
from w2c_controller.seiko.assembly import place_and_assemble
from w2c_controller.seiko.contacts import (
    ContactLayout,
    normal_force_limits,
    plane_cone,
    point_cone,
    wrench_rate_limits,
)
from w2c_controller.seiko.corrections import CLAMPS
from w2c_controller.seiko.desired import DesiredState
from w2c_controller.solvers import Program

Vector = npt.NDArray[np.float64]
Matrix = npt.NDArray[np.float64]
Indices = npt.NDArray[np.intp]


def clamp_norm(vector: Vector, limit: float) -> Vector:
    """Return the vector, shortened to the limit where it is longer."""
    length = float(np.sqrt(vector @ vector))
    return vector * (limit / length) if length > limit else vector


class ProgramBuilder:
    """Fills the program of one contact layout, tick after tick, without allocating it again."""

    def __init__(
        self, layout: ContactLayout, controlled: ControlledModel, parameters: Parameters, dt: float
    ) -> None:
        self.layout = layout
        self._controlled = controlled
        self._parameters = parameters
        self._dt = dt
        nv, nj = controlled.nv, controlled.nj
        self._nv, self._nj = nv, nj
        cone = self._make_cone()
        equalities = layout.equality_rows
        self.program = Program.empty(
            layout.size, equalities, nj + cone.shape[0], layout.structure(controlled.tree)
        )
        self.program.rows[equalities + nj :, nv:] = cone
        self.torque_rows = self.program.rows[equalities : equalities + nj]
        """T_J (nj, n): dtau/dt of a solution x is T_J x."""
        self._diagonal = np.zeros(layout.size)
        self._wrench_goal = np.zeros(layout.size - nv)
        self._rates = np.zeros(layout.size - nv)
        self._velocity = np.zeros(nj)
        self._balance = controlled.balance_joints
        self._weighted: tuple[list[bool], list[bool], list[bool]] = ([], [], [])
        """Which contacts were being released, pushed and lost when weights and rates were filled"""
        choice = parameters.weights
        self._diagonal[6:nv] = choice.joint_velocity + choice.posture
        # Tuples of arguments, whose types differ one by one.
        self._constant: tuple[Any, ...] = (
            layout.table,
            layout.torque_columns(controlled.tree),
            self._diagonal,
            self._wrench_goal,
            choice.posture,
            choice.momentum,
            *self._make_weights(),
            self._make_clamps(),
            *self._make_limits(),
        )
        self._output: tuple[Any, ...] = (
            np.zeros((4, 6)),
            np.zeros(layout.size - nv),
            self.program.hessian,
            self.program.gradient,
            self.program.rows,
            self.program.lower,
            self.program.upper,
        )

    def fill(self, kinematics: Kinematics, state: DesiredState) -> Program:
        """Update the kinematics of a state, and return its program; the next call overwrites both.

        Args:
            kinematics: Receives all that depends on the posture.
            state: The desired state.
        """
        releasing, pushing, lost = self._weighted
        if releasing != state.releasing or pushing != state.pushing or lost != state.lost:
            self._weigh_wrenches(state)
        if True in state.pushing or True in state.releasing:
            self._aim(state)
        place_and_assemble(
            self._dt,
            state.q,
            state.wrenches,
            state.contact_rotations,
            self.layout.enabled,
            state.levers,
            state.posture,
            state.force_min,
            state.target_positions,
            state.target_rotations,
            *kinematics.under_load,
            *kinematics.in_motion,
            *self._constant,
            *self._output,
        )
        return self.program

    def _weigh_wrenches(self, state: DesiredState) -> None:
        """Drive wrenches to their goals: gently, or with all might those pushing or released.

        Where a contact was lost, faster than otherwise; legs and trunk are then as fast as arms.
        """
        weights, limits = self._parameters.weights, self._parameters.limits
        lost = True in state.lost
        self._velocity[:] = limits.velocity_fraction * self._controlled.velocity
        if not lost:
            slower = limits.balance_velocity_fraction * self._controlled.velocity
            self._velocity[self._balance] = slower[self._balance]
        self._wrench_goal[:] = 0.0
        for k, where in self.layout.slices.items():
            wrench = slice(where.start - self._nv, where.stop - self._nv)
            self._rates[wrench] = wrench_rate_limits(limits, k, lost=lost)
            vector = np.array(weights.plane_wrench if k in FEET else weights.point_force)
            if state.releasing[k]:
                vector = vector * (weights.release_factor / vector[0])
            elif state.pushing[k]:
                vector[:] = weights.push
            self._diagonal[where] = vector
        self._weighted = (list(state.releasing), list(state.pushing), list(state.lost))

    def _aim(self, state: DesiredState) -> None:
        """Give contacts that push or are released their goal.

        Who pushes: the commanded force along the normal, no other. The wrench of who is released
        shrinks as a whole, so that it stays where it is in its cone. Were each component to go to
        zero as fast as it may, the tangential ones would be there first, and the moments that they
        leave behind swing the robot at the full speed of its joints.
        """
        for k, where in self.layout.slices.items():
            start = where.start - self._nv
            if state.releasing[k]:
                normal = float(state.wrenches[k, 2])
                step = self._dt * float(self._rates[start + 2])
                share = max(0.0, 1.0 - step / normal) if normal > 0.0 else 0.0
                goal = self._wrench_goal[start : where.stop - self._nv]
                np.multiply(share, state.wrenches[k, : goal.size], out=goal)
            elif state.pushing[k]:
                self._wrench_goal[start + 2] = state.push_force[k]

    def _make_weights(self) -> tuple[Vector, Matrix]:
        """Return the weights of torques (nj,), and of positions and rotations (4, 2)."""
        choice = self._parameters.weights
        torques = np.array(
            [
                choice.arm_torque if name.startswith("arm_") else choice.body_torque
                for name in self._controlled.joint_names
            ]
        )
        poses = np.zeros((4, 2))
        for k in FEET:
            if not self.layout.enabled[k]:
                poses[k] = choice.foot_position, choice.foot_rotation
        for k in HANDS:
            free = not self.layout.enabled[k]
            poses[k] = choice.hand_position if free else 0.0, choice.hand_rotation[k - HANDS[0]]
        return torques, poses

    def _make_cone(self) -> Matrix:
        """Return the friction rows (m, wrench size) over the wrenches of all contacts."""
        limits, nv = self._parameters.limits, self._nv
        blocks = [np.zeros((0, self.layout.size - nv))]
        for k, where in self.layout.slices.items():
            cone = plane_cone(limits) if k in FEET else point_cone(limits)
            block = np.zeros((cone.shape[0], self.layout.size - nv))
            block[:, where.start - nv : where.stop - nv] = cone
            blocks.append(block)
        return np.vstack(blocks)

    def _make_clamps(self) -> Vector:
        """Return the clamps, in the order of `corrections`."""
        choice = self._parameters.clamps
        clamps = np.array(
            [
                choice.posture,
                choice.position,
                choice.rotation,
                choice.bias_force,
                choice.bias_torque,
                choice.bias_position,
                choice.bias_rotation,
            ]
        )
        return clamps.reshape(CLAMPS)

    def _make_limits(self) -> tuple[Vector, ...]:
        """Return largest normal forces, and limits of joints, velocities, torques, wrench rates."""
        limits, controlled = self._parameters.limits, self._controlled
        margin = np.array(
            [
                limits.joint_margin * limits.joint_margin_factors.get(name, 1.0)
                for name in controlled.joint_names
            ]
        )
        return (
            np.array([normal_force_limits(limits, k)[1] for k in range(4)]),
            controlled.lower + margin,
            controlled.upper - margin,
            self._velocity,
            limits.torque_fraction * controlled.effort,
            self._rates,
        )
