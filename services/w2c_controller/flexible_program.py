"""Assembly of the SEIKO Controller QP (Rouxel, Ivaldi and Mouret, RA-L 2024), one a contact set.

x = [v (nv); wrench rates] of the flexible robot. Static equilibrium of its springs one tick ahead
determines the rate of the command:

    theta_cmd' = D x + d / dt
    D = K^-1 [T_q,J + K S', T_l,J],   d = K^-1 (s_J - K (theta_cmd - theta))

    min  sum w |wrench rate - effort rate|^2 + w |theta_cmd'|^2 + w |offset after the tick|^2
         + poses of free end effectors, orientation of hands in contact
    s.t. contact Jacobians v = drift / dt,   (T_q v + T_l lambda')_base = -s_base / dt,
         joint limits and offset limit of the command, torque limits

Limits are widened to what x = 0 gives, as in the Retargeting.
"""

import numpy as np
import numpy.typing as npt

from w2c_controller.compiled import compiled
from w2c_controller.contacts import ContactLayout
from w2c_controller.flexible_model import FlexibleState
from w2c_controller.force_parameters import FlexibleWeights
from w2c_controller.model import ControlledModel, Kinematics
from w2c_controller.parameters import FEET, HANDS, Clamps, Parameters
from w2c_controller.rotations import rotation_vector
from w2c_controller.solvers import Program

Vector = npt.NDArray[np.float64]
Matrix = npt.NDArray[np.float64]
Indices = npt.NDArray[np.intp]


class FlexibleProgram:
    """Fills the program of one contact layout, tick after tick, without allocating it again."""

    def __init__(
        self, layout: ContactLayout, controlled: ControlledModel, parameters: Parameters, dt: float
    ) -> None:
        self.layout = layout
        nv, nj = controlled.nv, controlled.nj
        self._nv, self._nj, self._dt = nv, nj, dt
        self._stiffness = controlled.stiffness
        self._contacts = np.array(list(layout.slices), dtype=np.intp)
        self._starts = np.array([where.start for where in layout.slices.values()], dtype=np.intp)
        weights, limits = parameters.force_control.weights, parameters.limits
        self._weights = _weight_vector(weights)
        self._poses = _pose_weights(weights, layout)
        self._clamps = _clamp_vector(parameters.clamps)
        margin = parameters.force_control.command_margin * np.array(
            [
                limits.joint_margin * limits.joint_margin_factors.get(name, 1.0)
                for name in controlled.joint_names
            ]
        )
        self._joint_lower = controlled.lower + margin
        self._joint_upper = controlled.upper - margin
        self._offset_limit = parameters.force_control.offset_limit
        equalities = layout.equality_rows
        self.program = Program.empty(layout.size, equalities, 2 * nj)
        self._lag = np.zeros(nj)
        self._scratch = np.zeros((6, layout.size))

    def fill(
        self,
        kinematics: Kinematics,
        flexible: FlexibleState,
        desired: Kinematics,
        surfaces: Matrix,
        command: Vector,
        effort_rates: Matrix,
        torque_limits: Vector,
    ) -> Program:
        """Return the program of this state; the next call overwrites it.

        Args:
            kinematics: Of the flexible robot.
            flexible: Its state.
            desired: Kinematics of the desired posture.
            surfaces: (4, 3, 3) world_from_contact of the hands.
            command: (nj,) desired angles + offset [rad].
            effort_rates: (4, 6) wrench rates wanted, in the contacts' frames.
            torque_limits: (nj,) of the flexible robot's joints [Nm].
        """
        program, equalities = self.program, self.layout.equality_rows
        size, nj = self.layout.size, self._nj
        _fill_rows(
            self._contacts,
            self._starts,
            self._dt,
            self._clamps,
            kinematics.jacobians,
            kinematics.local_jacobians,
            surfaces,
            kinematics.positions,
            kinematics.rotations,
            flexible.contact_positions,
            flexible.contact_rotations,
            kinematics.static,
            kinematics.static_dq,
            self._scratch,
            program.rows,
            program.lower[size : size + equalities],
            program.upper[size : size + equalities],
        )
        _fill_command_rows(
            self._dt,
            self._stiffness,
            kinematics.static,
            flexible.q[7:],
            command,
            flexible.offset,
            self._joint_lower,
            self._joint_upper,
            self._offset_limit,
            torque_limits,
            self._lag,
            program.rows[equalities : equalities + nj],
            program.rows[equalities + nj :],
            program.lower[size + equalities :],
            program.upper[size + equalities :],
        )
        _fill_cost(
            self._contacts,
            self._starts,
            self._dt,
            self._weights,
            self._poses,
            kinematics.jacobians,
            kinematics.positions,
            kinematics.rotations,
            desired.positions,
            desired.rotations,
            effort_rates,
            program.rows[equalities : equalities + nj],
            self._lag,
            flexible.offset,
            self._scratch,
            program.hessian,
            program.gradient,
        )
        return program

    def command_rate(self, x: Vector) -> Vector:
        """Return theta_cmd' (nj,) of a solution [rad/s]."""
        equalities = self.layout.equality_rows
        rows = self.program.rows[equalities : equalities + self._nj]
        return np.asarray(rows @ x + self._lag / self._dt)


def _weight_vector(weights: FlexibleWeights) -> Vector:
    """Return foot wrench, hand force, command rate, command offset, base velocity."""
    return np.array(
        [
            weights.foot_wrench,
            weights.hand_force,
            weights.command_rate,
            weights.command_offset,
            weights.base_velocity,
        ]
    )


def _pose_weights(weights: FlexibleWeights, layout: ContactLayout) -> Matrix:
    """Return (4, 2): weights of position and orientation of each end effector."""
    poses = np.zeros((4, 2))
    for k in FEET:
        if not layout.enabled[k]:
            poses[k] = weights.foot_position, weights.foot_rotation
    for k in HANDS:
        poses[k] = (
            (0.0, weights.hand_rotation) if layout.enabled[k] else (weights.hand_position, 0.0)
        )
    return poses


def _clamp_vector(clamps: Clamps) -> Vector:
    """Return the largest corrections of one tick: position, rotation, force, torque."""
    return np.array(
        [clamps.bias_position, clamps.bias_rotation, clamps.bias_force, clamps.bias_torque]
    )


@compiled
def _saturate(vector: Vector, limit: float, scale: float) -> None:
    """Shorten a vector to a limit where it is longer, then scale it; in place."""
    square = 0.0
    for value in vector:
        square += value * value
    if square > limit * limit:
        scale *= limit / np.sqrt(square)
    for i in range(vector.shape[0]):
        vector[i] *= scale


@compiled
def _fill_rows(
    contacts: Indices,
    starts: Indices,
    dt: float,
    clamps: Vector,
    jacobians: Matrix,
    local_jacobians: Matrix,
    surfaces: Matrix,
    positions: Matrix,
    rotations: Matrix,
    contact_positions: Matrix,
    contact_rotations: Matrix,
    static: Vector,
    static_dq: Matrix,
    scratch: Matrix,
    rows: Matrix,
    lower: Vector,
    upper: Vector,
) -> None:
    """Fill the equalities, and T = [T_q, T_l] of the joints into the last rows."""
    nv = static.shape[0]
    nj = nv - 6
    torque = rows.shape[0] - nj
    row = 0
    turn = scratch[:3, :3]
    for index in range(contacts.shape[0]):
        k, start = contacts[index], starts[index]
        height = 6 if k < 2 else 3
        for i in range(height):
            for j in range(nv):
                rows[row + i, j] = jacobians[k, i, j]
        for i in range(3):
            upper[row + i] = contact_positions[k, i] - positions[k, i]
        _saturate(upper[row : row + 3], clamps[0], 1.0 / dt)
        if height == 6:
            for i in range(3):
                for j in range(3):
                    total = 0.0
                    for m in range(3):
                        total += contact_rotations[k, i, m] * rotations[k, j, m]
                    turn[i, j] = total
            rotation_vector(turn, upper[row + 3 : row + 6])
            _saturate(upper[row + 3 : row + 6], clamps[1], 1.0 / dt)
        row += height
    for i in range(6):
        for j in range(nv):
            rows[row + i, j] = static_dq[i, j]
        upper[row + i] = -static[i]
    _saturate(upper[row : row + 3], clamps[2], 1.0 / dt)
    _saturate(upper[row + 3 : row + 6], clamps[3], 1.0 / dt)
    for i in range(nj):
        for j in range(nv):
            rows[torque + i, j] = static_dq[6 + i, j]
    for index in range(contacts.shape[0]):
        k, start = contacts[index], starts[index]
        if k < 2:
            for i in range(6):
                for j in range(6):
                    rows[row + j, start + i] = -local_jacobians[k, i, j]
                for j in range(nj):
                    rows[torque + j, start + i] = -local_jacobians[k, i, 6 + j]
        else:
            for i in range(3):
                for j in range(nv):
                    total = 0.0
                    for m in range(3):
                        total -= surfaces[k, m, i] * jacobians[k, m, j]
                    if j < 6:
                        rows[row + j, start + i] = total
                    else:
                        rows[torque + j - 6, start + i] = total
    for i in range(row + 6):
        lower[i] = upper[i]


@compiled
def _fill_command_rows(
    dt: float,
    stiffness: Vector,
    static: Vector,
    joints: Vector,
    command: Vector,
    offset: Vector,
    joint_lower: Vector,
    joint_upper: Vector,
    offset_limit: float,
    torque_limits: Vector,
    lag: Vector,
    command_rows: Matrix,
    torque_rows: Matrix,
    lower: Vector,
    upper: Vector,
) -> None:
    """Fill D, d, and the limits of command and torque; `torque_rows` hold T already."""
    nj, size = command_rows.shape
    for i in range(nj):
        inverse = 1.0 / stiffness[i]
        lag[i] = static[6 + i] * inverse - command[i] + joints[i]
        for j in range(size):
            command_rows[i, j] = torque_rows[i, j] * inverse
        command_rows[i, 6 + i] += 1.0
        highest = min(joint_upper[i] - command[i], offset_limit - offset[i])
        lowest = max(joint_lower[i] - command[i], -offset_limit - offset[i])
        upper[i] = max((highest - lag[i]) / dt, 0.0)
        lower[i] = min((lowest - lag[i]) / dt, 0.0)
        torque = static[6 + i]
        upper[nj + i] = max((torque_limits[i] - torque) / dt, 0.0)
        lower[nj + i] = min((-torque_limits[i] - torque) / dt, 0.0)


@compiled
def _fill_cost(
    contacts: Indices,
    starts: Indices,
    dt: float,
    weights: Vector,
    poses: Matrix,
    jacobians: Matrix,
    positions: Matrix,
    rotations: Matrix,
    desired_positions: Matrix,
    desired_rotations: Matrix,
    effort_rates: Matrix,
    command_rows: Matrix,
    lag: Vector,
    offset: Vector,
    scratch: Matrix,
    hessian: Matrix,
    gradient: Vector,
) -> None:
    """Fill H = sum J' W J and g = -sum J' W target (the factor 2 of both is dropped)."""
    nj, size = command_rows.shape
    hessian[:] = 0.0
    gradient[:] = 0.0
    # Rate and offset after the tick are the same rows of x: one term each.
    together = weights[2] + weights[3] * dt * dt
    for r in range(nj):
        pull = (weights[2] * lag[r] / dt) + weights[3] * dt * (offset[r] + lag[r])
        for i in range(size):
            value = command_rows[r, i]
            if value != 0.0:
                gradient[i] += pull * value
                value *= together
                for j in range(i, size):
                    hessian[i, j] += value * command_rows[r, j]
    error, turn = scratch[3, :3], scratch[:3, :3]
    nv = nj + 6
    for k in range(4):
        for part in range(2):
            weight = poses[k, part]
            if weight == 0.0:
                continue
            if part == 0:
                for i in range(3):
                    error[i] = desired_positions[k, i] - positions[k, i]
            else:
                for i in range(3):
                    for j in range(3):
                        total = 0.0
                        for m in range(3):
                            total += desired_rotations[k, i, m] * rotations[k, j, m]
                        turn[i, j] = total
                rotation_vector(turn, error)
            for r in range(3):
                row = jacobians[k, 3 * part + r]
                pull = weight * error[r] / dt
                for i in range(nv):
                    value = row[i]
                    if value != 0.0:
                        gradient[i] -= pull * value
                        value *= weight
                        for j in range(i, nv):
                            hessian[i, j] += value * row[j]
    for i in range(6):
        hessian[i, i] += weights[4]
    for index in range(contacts.shape[0]):
        k, start = contacts[index], starts[index]
        weight = weights[0] if k < 2 else weights[1]
        for i in range(6 if k < 2 else 3):
            hessian[start + i, start + i] += weight
            gradient[start + i] -= weight * effort_rates[k, i]
    for i in range(size):
        for j in range(i):
            hessian[i, j] = hessian[j, i]
