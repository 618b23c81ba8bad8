"""Assembly of the Retargeting QP, one preallocated program a contact set.

x = [v (nv); wrench rates].

With s(q, lambda) the static residual, T_q and T_l its derivatives and tau = s_J (see
`model.Kinematics`),

    min  sum w |J x - target|^2
    s.t. contact Jacobians v = drift / dt,   (T_q v + T_l lambda')_base = -s_base / dt,
         joint, velocity, torque, wrench rate and normal force limits, friction cones after the
         step dt.

Every limit is widened to what the state has already, so that x = 0 satisfies all inequalities: a
state beyond a limit may not go farther, and is not thrown back within one tick.
"""

import numpy as np
import numpy.typing as npt
import pinocchio as pin

from w2c_controller.contacts import (
    ContactLayout,
    normal_force_limits,
    plane_cone,
    point_cone,
    wrench_rate_limits,
)
from w2c_controller.desired import DesiredState
from w2c_controller.model import ControlledModel, Kinematics
from w2c_controller.parameters import FEET, HANDS, Parameters
from w2c_controller.solvers import Program

Vector = npt.NDArray[np.float64]
Matrix = npt.NDArray[np.float64]


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
        self._clamps = parameters.clamps
        nv, nj = controlled.nv, controlled.nj
        self._nv, self._nj = nv, nj
        self._posed = [k for k in range(4) if k in HANDS or not layout.enabled[k]]
        """End effectors with a pose cost: free ones, and the orientation of hands in contact."""
        self._tasks = np.zeros((nj + 6 + 6 * len(self._posed), layout.size))
        self._goal = np.zeros(self._tasks.shape[0])
        self._task_weights = self._make_task_weights()
        self._diagonal = np.zeros(layout.size)
        self._wrench = np.zeros(layout.size - nv)
        self._static_dl = np.zeros((nv, layout.size - nv))
        """T_l = ds/dlambda"""
        self._cone = self._make_cone()
        equalities = layout.equality_rows
        self.program = Program.empty(layout.size, equalities, nj + self._cone.shape[0])
        self.program.rows[equalities + nj :, nv:] = self._cone
        self._fill_constant_bounds()

    def fill(self, kinematics: Kinematics, state: DesiredState) -> Program:
        """Return the program of this state; the next call overwrites it."""
        self._linearise(kinematics, state)
        self._fill_cost(kinematics, state)
        self._fill_equalities(kinematics, state)
        self._fill_bounds(kinematics, state)
        return self.program

    def torque_rate(self, x: Vector) -> Vector:
        """Return dtau/dt (nj,) of a solution [Nm/s]."""
        return np.asarray(self._tasks[: self._nj] @ x)

    def _make_task_weights(self) -> Vector:
        """Return the weights of the cost rows: torques, momentum, poses."""
        weights = np.zeros(self._tasks.shape[0])
        choice = self._parameters.weights
        for i, name in enumerate(self._controlled.joint_names):
            weights[i] = choice.arm_torque if name.startswith("arm_") else choice.body_torque
        weights[self._nj : self._nj + 6] = choice.momentum
        for row, k in enumerate(self._posed):
            start = self._nj + 6 + 6 * row
            position = choice.foot_position if k in FEET else choice.hand_position
            rotation = choice.foot_rotation if k in FEET else choice.hand_rotation[k - HANDS[0]]
            weights[start : start + 3] = 0.0 if self.layout.enabled[k] else position
            weights[start + 3 : start + 6] = rotation
        return weights

    def _make_cone(self) -> Matrix:
        """Return the friction rows (m, wrench size) over the wrenches of all contacts."""
        limits, nv = self._parameters.limits, self._nv
        blocks = []
        for k, where in self.layout.slices.items():
            cone = plane_cone(limits) if k in FEET else point_cone(limits)
            block = np.zeros((cone.shape[0], self.layout.size - nv))
            block[:, where.start - nv : where.stop - nv] = cone
            blocks.append(block)
        return np.vstack(blocks) if blocks else np.zeros((0, 0))

    def _fill_constant_bounds(self) -> None:
        """Prepare the limits that no state changes."""
        limits, controlled = self._parameters.limits, self._controlled
        margin = np.array(
            [
                limits.joint_margin * limits.joint_margin_factors.get(name, 1.0)
                for name in controlled.joint_names
            ]
        )
        self._joint_lower = controlled.lower + margin
        self._joint_upper = controlled.upper - margin
        self._velocity = limits.velocity_fraction * controlled.velocity
        self._torque = limits.torque_fraction * controlled.effort
        self._rates = np.concatenate(
            [wrench_rate_limits(limits, k) for k in self.layout.slices] or [np.zeros(0)]
        )

    def _linearise(self, kinematics: Kinematics, state: DesiredState) -> None:
        """Fill T_l and the stacked wrench."""
        for k, where in self.layout.slices.items():
            columns = slice(where.start - self._nv, where.stop - self._nv)
            if k in FEET:
                self._static_dl[:, columns] = -kinematics.local_jacobians[k].T
                self._wrench[columns] = state.wrenches[k]
            else:
                linear = kinematics.jacobians[k, :3]
                self._static_dl[:, columns] = -linear.T @ state.contact_rotations[k]
                self._wrench[columns] = state.wrenches[k, :3]

    def _fill_cost(self, kinematics: Kinematics, state: DesiredState) -> None:
        """Fill H = sum J' W J and g = -sum J' W target (the factor 2 of both is dropped)."""
        nv, nj, dt, clamps = self._nv, self._nj, self._dt, self._clamps
        weights, tasks, goal = self._parameters.weights, self._tasks, self._goal
        tasks[:nj, :nv] = kinematics.static_dq[6:]
        tasks[:nj, nv:] = self._static_dl[6:]
        goal[:nj] = kinematics.static[6:] / -dt
        tasks[nj : nj + 6, :nv] = kinematics.momentum
        for row, k in enumerate(self._posed):
            start = nj + 6 + 6 * row
            tasks[start : start + 6, :nv] = kinematics.jacobians[k]
            drift = state.target_positions[k] - kinematics.positions[k]
            turn = pin.log3(state.target_rotations[k] @ kinematics.rotations[k].T)
            goal[start : start + 3] = clamp_norm(drift, clamps.position) / dt
            goal[start + 3 : start + 6] = clamp_norm(turn, clamps.rotation) / dt
        program = self.program
        weighted = tasks * self._task_weights[:, None]
        np.matmul(tasks.T, weighted, out=program.hessian)
        program.gradient[:] = -(goal @ weighted)
        diagonal = self._diagonal
        diagonal[6:nv] = weights.joint_velocity + weights.posture
        error = np.minimum(np.maximum(state.posture - state.q[7:], -clamps.posture), clamps.posture)
        program.gradient[6:nv] -= weights.posture / dt * error
        self._fill_wrench_weights(state)
        program.gradient[nv:] += diagonal[nv:] * self._wrench / dt
        program.hessian.ravel()[:: self.layout.size + 1] += diagonal

    def _fill_wrench_weights(self, state: DesiredState) -> None:
        """Drive wrenches to zero: gently, and with all might those of a contact being released."""
        weights = self._parameters.weights
        for k, where in self.layout.slices.items():
            vector = np.array(weights.plane_wrench if k in FEET else weights.point_force)
            if state.releasing[k]:
                vector = vector * (weights.release_factor / vector[0])
            self._diagonal[where] = vector

    def _fill_equalities(self, kinematics: Kinematics, state: DesiredState) -> None:
        """Fill fixed contacts and the equilibrium of the base, each with a bounded correction."""
        dt, nv, clamps, program = self._dt, self._nv, self._clamps, self.program
        right = np.zeros(self.layout.equality_rows)
        row = 0
        for k in self.layout.slices:
            size = 6 if k in FEET else 3
            program.rows[row : row + size, :nv] = kinematics.jacobians[k, :size]
            drift = state.target_positions[k] - kinematics.positions[k]
            right[row : row + 3] = clamp_norm(drift, clamps.bias_position) / dt
            if size == 6:
                turn = pin.log3(state.target_rotations[k] @ kinematics.rotations[k].T)
                right[row + 3 : row + 6] = clamp_norm(turn, clamps.bias_rotation) / dt
            row += size
        program.rows[row : row + 6, :nv] = kinematics.static_dq[:6]
        program.rows[row : row + 6, nv:] = self._static_dl[:6]
        residual = kinematics.static
        right[row : row + 3] = -clamp_norm(residual[:3], clamps.bias_force) / dt
        right[row + 3 : row + 6] = -clamp_norm(residual[3:6], clamps.bias_torque) / dt
        at = slice(self.layout.size, self.layout.size + self.layout.equality_rows)
        program.lower[at] = right
        program.upper[at] = right

    def _fill_bounds(self, kinematics: Kinematics, state: DesiredState) -> None:
        """Fill limits of joints, wrenches, torques and cones; x = 0 stays inside all of them."""
        dt, nv, nj, program = self._dt, self._nv, self._nj, self.program
        lower, upper = program.lower, program.upper
        joints = state.q[7:]
        upper[6:nv] = np.minimum(self._velocity, (self._joint_upper - joints) / dt)
        lower[6:nv] = np.maximum(-self._velocity, (self._joint_lower - joints) / dt)
        size = self.layout.size
        upper[nv:size] = self._rates
        lower[nv:size] = -self._rates
        for k, where in self.layout.slices.items():
            normal = where.start + 2
            highest = normal_force_limits(self._parameters.limits, k)[1]
            force = state.wrenches[k, 2]
            upper[normal] = min(upper[normal], (highest - force) / dt)
            lower[normal] = max(lower[normal], (state.force_min[k] - force) / dt)
        start = size + self.layout.equality_rows
        program.rows[self.layout.equality_rows : self.layout.equality_rows + nj] = self._tasks[:nj]
        torque = kinematics.static[6:]
        upper[start : start + nj] = (self._torque - torque) / dt
        lower[start : start + nj] = (-self._torque - torque) / dt
        upper[start + nj :] = (self._cone @ self._wrench) / -dt
        np.maximum(upper[6:size], 0.0, out=upper[6:size])
        np.minimum(lower[6:size], 0.0, out=lower[6:size])
        np.maximum(upper[start:], 0.0, out=upper[start:])
        np.minimum(lower[start:], 0.0, out=lower[start:])
