"""The joint torques of a robot that stands still on two feet."""

import mujoco
import numpy as np

from w2c.messages import Array
from w2c_sim_robot import talos


def standing_torque(model: mujoco.MjModel, configuration: Array) -> Array:
    """Return the generalized torque (nv,) of a static double support; zero in the base's rows.

    g(q) = S tau + J_soles(q)^T wrenches: the base's 6 rows determine the sum of the two wrenches,
    the least norm shares it out. A torque [Nm] counts ten times a force [N], which keeps the
    centres of pressure near the middle of the soles.
    """
    data = mujoco.MjData(model)
    data.qpos[:] = configuration
    # Positions and velocities only: contact must not enter, and qfrc_bias at rest is gravity.
    mujoco.mj_fwdPosition(model, data)
    mujoco.mj_fwdVelocity(model, data)
    jacobian = np.zeros((12, model.nv))
    for index, name in enumerate(talos.SOLE_FRAMES):
        rows = jacobian[6 * index : 6 * index + 6]
        mujoco.mj_jacBody(model, data, rows[:3], rows[3:], model.body(name).id)
    scale = np.tile([1.0, 1.0, 1.0, 0.1, 0.1, 0.1], 2)
    first = model.joint("base").dofadr[0]
    base = slice(first, first + 6)
    wrenches = (
        scale * np.linalg.lstsq(jacobian[:, base].T * scale, data.qfrc_bias[base], rcond=None)[0]
    )
    torque: Array = data.qfrc_bias - jacobian.T @ wrenches
    torque[base] = 0.0
    return torque
