"""The wrenches of a posture at rest: where the Retargeting starts.

    min  w_tau |tau|^2 + w_l |lambda|^2   s.t.  s_base = 0, torque limits, cones, normal force
    limits

with tau = s_J(q, lambda) (SEIKO's static inverse dynamics).
"""

import numpy as np
import numpy.typing as npt

from w2c.errors import ControlError, SolverError
from w2c_controller.kinematics.model import ControlledModel, Kinematics
from w2c_controller.parameters import FEET, Parameters
from w2c_controller.seiko.contacts import (
    ContactLayout,
    normal_force_limits,
    plane_cone,
    point_cone,
)
from w2c_controller.seiko.desired import DesiredState
from w2c_controller.solvers import UNBOUNDED, Program, Solver

Vector = npt.NDArray[np.float64]

TORQUE_WEIGHT = 2e-5


def balance_at_rest(
    controlled: ControlledModel,
    kinematics: Kinematics,
    state: DesiredState,
    parameters: Parameters,
    solver: Solver,
) -> None:
    """Fill the state's wrenches and torques with those that balance its posture.

    Raises:
        ControlError: no wrenches of these contacts balance it.
    """
    state.wrenches[:] = 0.0
    layout = ContactLayout(state.enabled, controlled.nv)
    kinematics.update_statics(
        state.q, state.wrenches, state.contact_rotations, state.enabled, state.levers
    )
    program, slices = _program(layout, controlled, kinematics, state, parameters)
    try:
        solution = solver.solve(program)
    except SolverError as error:
        raise ControlError(
            "this posture cannot stand on its contacts within friction, centre of pressure and "
            "torque limits; bring the robot to its initial posture"
        ) from error
    for k, where in slices.items():
        size = where.stop - where.start
        state.wrenches[k, :size] = solution[where]
    kinematics.update_statics(
        state.q, state.wrenches, state.contact_rotations, state.enabled, state.levers
    )
    state.torque[:] = kinematics.static[6:]


def _program(
    layout: ContactLayout,
    controlled: ControlledModel,
    kinematics: Kinematics,
    state: DesiredState,
    parameters: Parameters,
) -> tuple[Program, dict[int, slice]]:
    """Return the program over the wrenches, and where each contact stands in its variables."""
    nv, nj, limits = controlled.nv, controlled.nj, parameters.limits
    size = layout.size - nv
    slices = {k: slice(s.start - nv, s.stop - nv) for k, s in layout.slices.items()}
    static_dl = np.zeros((nv, size))
    weights = np.zeros(size)
    cones = []
    for k, where in slices.items():
        cone = plane_cone(limits) if k in FEET else point_cone(limits)
        block = np.zeros((cone.shape[0], size))
        block[:, where] = cone
        cones.append(block)
        if k in FEET:
            static_dl[:, where] = -kinematics.local_jacobians[k].T
            weights[where] = parameters.weights.plane_wrench
        else:
            static_dl[:, where] = -kinematics.point_jacobians[k - 2].T @ state.contact_rotations[k]
            weights[where] = parameters.weights.point_force
    cone_rows = sum(block.shape[0] for block in cones)
    program = Program.empty(size, 6, nj + cone_rows)
    torque, torque_dl = kinematics.static[6:], static_dl[6:]
    program.hessian[:] = TORQUE_WEIGHT * torque_dl.T @ torque_dl + np.diag(weights)
    program.gradient[:] = TORQUE_WEIGHT * torque_dl.T @ torque
    program.rows[:] = np.vstack([static_dl[:6], torque_dl, *cones])
    limit = limits.torque_fraction * controlled.effort
    right = -kinematics.static[:6]
    program.lower[size:] = np.concatenate([right, -limit - torque, np.full(cone_rows, -UNBOUNDED)])
    program.upper[size:] = np.concatenate([right, limit - torque, np.zeros(cone_rows)])
    for k, where in slices.items():
        highest = normal_force_limits(limits, k)[1]
        program.lower[where.start + 2] = state.force_min[k]
        program.upper[where.start + 2] = highest
    return program, slices
