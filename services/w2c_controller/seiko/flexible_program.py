"""The SEIKO Controller QP (Rouxel, Ivaldi and Mouret, RA-L 2024), one program a contact set.

x = [v (nv); wrench rates] of the flexible robot. Static equilibrium of its springs one tick ahead
determines the rate of the command:

    theta_cmd' = D x + d / dt
    D = K^-1 [T_q,J + K S', T_l,J],   d = K^-1 (s_J - K (theta_cmd - theta))

    min  sum w |wrench rate - effort rate|^2 + w |theta_cmd'|^2 + w |offset after the tick|^2
         + poses of free end effectors, orientation of hands in contact
    s.t. Jacobians of touching points v = drift / dt,   (T_q v + T_l lambda')_base = -s_base / dt,
         joint limits and offset limit of the command, torque limits

Corrections of the equalities are bounded, and limits widened to what x = 0 gives, as in the
Retargeting.
"""

from typing import Any

import numpy as np
import numpy.typing as npt

from w2c_controller.kinematics.model import NO_LEVERS, ControlledModel, Kinematics
from w2c_controller.parameters import FEET, HANDS, Clamps, Parameters
from w2c_controller.seiko.contacts import ContactLayout
from w2c_controller.seiko.corrections import (
    BIAS_FORCE,
    BIAS_POSITION,
    BIAS_ROTATION,
    BIAS_TORQUE,
    CLAMPS,
)
from w2c_controller.seiko.flexible_assembly import advance_flexible, assemble_flexible
from w2c_controller.seiko.flexible_model import FlexibleState
from w2c_controller.seiko.force_parameters import FlexibleWeights
from w2c_controller.solvers import Program

Vector = npt.NDArray[np.float64]
Matrix = npt.NDArray[np.float64]


class FlexibleProgram:
    """Fills the program of one contact layout, tick after tick, without allocating it again."""

    def __init__(
        self, layout: ContactLayout, controlled: ControlledModel, parameters: Parameters, dt: float
    ) -> None:
        self.layout = layout
        self._dt = dt
        settings, limits, nj = parameters.force_control, parameters.limits, controlled.nj
        equalities = layout.equality_rows
        self.program = Program.empty(
            layout.size, equalities, 2 * nj, layout.structure(controlled.tree)
        )
        self._first_row = equalities
        self._columns = layout.torque_columns(controlled.tree)
        self._supports = controlled.tree.supports
        self._lag = np.zeros(nj)
        self._offset_limit = settings.offset_limit
        margin = settings.command_margin * np.array(
            [
                limits.joint_margin * limits.joint_margin_factors.get(name, 1.0)
                for name in controlled.joint_names
            ]
        )
        # Tuples of arguments, whose types differ one by one.
        self._constant: tuple[Any, ...] = (
            controlled.tree.supports,
            layout.table,
            self._columns,
            controlled.stiffness,
            np.array([settings.weights.command_rate, settings.weights.command_offset]),
            _pose_weights(settings.weights, layout),
            _diagonal(settings.weights, layout),
            _clamps(parameters.clamps),
            self._offset_limit,
            controlled.lower + margin,
            controlled.upper - margin,
        )
        self._output: tuple[Any, ...] = (
            np.zeros((4, 6)),
            self._lag,
            self.program.hessian,
            self.program.gradient,
            self.program.rows,
            self.program.lower,
            self.program.upper,
        )

    def fill(
        self,
        kinematics: Kinematics,
        state: FlexibleState,
        desired: Kinematics,
        command: Vector,
        effort_rates: Matrix,
        torque_limits: Vector,
    ) -> Program:
        """Return the program of this state; the next call overwrites it.

        Args:
            kinematics: Of the flexible robot, statics included.
            state: Of the flexible robot.
            desired: Kinematics of the desired posture.
            command: (nj,) desired angles + offset [rad].
            effort_rates: (4, 6) wrench rates wanted, in the contacts' frames [N/s, Nm/s].
            torque_limits: (nj,) of the flexible robot's joints [Nm].
        """
        assemble_flexible(
            self._dt,
            state.q,
            state.offset,
            command,
            state.contact_positions,
            state.contact_rotations,
            kinematics.positions,
            kinematics.rotations,
            kinematics.jacobians,
            kinematics.point_jacobians,
            kinematics.static,
            kinematics.static_dq,
            kinematics.static_dl,
            desired.positions,
            desired.rotations,
            effort_rates,
            torque_limits,
            *self._constant,
            *self._output,
        )
        return self.program

    def advance(
        self,
        x: Vector,
        state: FlexibleState,
        rates: Matrix,
        kinematics: Kinematics,
        levers: Matrix = NO_LEVERS,
    ) -> None:
        """Move a state by one tick of a solution of its program.

        Args:
            x: (n,) the solution.
            state: Whose program was filled last; changed in place.
            rates: (4, 6) receives the wrench rates of the solution.
            kinematics: That the program was filled with.
            levers: (4, 3) as in `DesiredState`.
        """
        advance_flexible(
            self._dt,
            x,
            self.layout.table,
            self._columns,
            self.program.rows,
            self._first_row,
            self._lag,
            self._offset_limit,
            kinematics.jacobians,
            self._supports,
            levers,
            state.q,
            state.offset,
            state.wrenches,
            rates,
            state.contact_positions,
        )

    def command_rate(self, x: Vector) -> Vector:
        """Return theta_cmd' (nj,) of a solution [rad/s]."""
        rows = self.program.rows[self._first_row : self._first_row + self._lag.size]
        return np.asarray(rows @ x + self._lag / self._dt)


def _diagonal(weights: FlexibleWeights, layout: ContactLayout) -> Vector:
    """Return the weights on the variables themselves (n,)."""
    diagonal = np.zeros(layout.size)
    diagonal[:6] = weights.base_velocity
    for k, where in layout.slices.items():
        diagonal[where] = weights.foot_wrench if k in FEET else weights.hand_force
    return diagonal


def _pose_weights(weights: FlexibleWeights, layout: ContactLayout) -> Matrix:
    """Return the weights of position and orientation of each end effector (4, 2)."""
    poses = np.zeros((4, 2))
    for k in FEET:
        if not layout.enabled[k]:
            poses[k] = weights.foot_position, weights.foot_rotation
    for k in HANDS:
        free = not layout.enabled[k]
        poses[k] = (weights.hand_position, 0.0) if free else (0.0, weights.hand_rotation)
    return poses


def _clamps(clamps: Clamps) -> Vector:
    """Return the largest corrections of one tick, in the order of `corrections`."""
    vector = np.full(CLAMPS, np.inf)
    vector[BIAS_FORCE] = clamps.bias_force
    vector[BIAS_TORQUE] = clamps.bias_torque
    vector[BIAS_POSITION] = clamps.bias_position
    vector[BIAS_ROTATION] = clamps.bias_rotation
    return vector
