"""What the commanded robot does: a rigid tree whose joints are springs.

    tau = K (theta_cmd - theta),     s_J(q, lambda) = tau,     s_base(q, lambda) = 0

(SEIKO Controller, Rouxel, Ivaldi and Mouret, RA-L 2024). q and lambda are posture and contact
wrenches under the command theta_cmd = desired angles + offset.
"""

from dataclasses import dataclass, field

import numpy as np
import numpy.typing as npt

from w2c.errors import ControlError
from w2c_controller.kinematics.model import NO_LEVERS, ControlledModel, Kinematics
from w2c_controller.kinematics.rotations import rotation_vector
from w2c_controller.parameters import FEET
from w2c_controller.seiko.contacts import ContactLayout, Enabled
from w2c_controller.seiko.desired import STANDING, DesiredState
from w2c_controller.seiko.rolling import roll

Vector = npt.NDArray[np.float64]
Matrix = npt.NDArray[np.float64]

NEWTON_STEPS = 3


@dataclass
class FlexibleState:
    """Posture and wrenches of the flexible robot; arrays over end effectors as in `EFFECTORS`."""

    q: Vector
    """(nq,)"""
    offset: Vector
    """(nj,) of the command from the desired angles [rad]"""
    wrenches: Matrix = field(default_factory=lambda: np.zeros((4, 6)))
    """(4, 6) as in `DesiredState`"""
    enabled: Enabled = STANDING
    contact_positions: Matrix = field(default_factory=lambda: np.zeros((4, 3)))
    """(4, 3) where this model has its contacts, in the world [m]"""
    contact_rotations: Matrix = field(default_factory=lambda: np.tile(np.eye(3), (4, 1, 1)))
    """(4, 3, 3) world_from_effector there"""

    def copy(self) -> "FlexibleState":
        """Return an independent copy."""
        return FlexibleState(
            q=self.q.copy(),
            offset=self.offset.copy(),
            wrenches=self.wrenches.copy(),
            enabled=self.enabled,
            contact_positions=self.contact_positions.copy(),
            contact_rotations=self.contact_rotations.copy(),
        )

    @classmethod
    def wound_up(cls, desired: DesiredState, stiffness: Vector) -> "FlexibleState":
        """Return the state whose equilibrium is the desired one: offset = tau / K."""
        return cls(
            q=desired.q.copy(),
            offset=desired.torque / stiffness,
            wrenches=desired.wrenches.copy(),
            enabled=desired.enabled,
            contact_positions=desired.target_positions.copy(),
            contact_rotations=desired.target_rotations.copy(),
        )


def find_equilibrium(
    controlled: ControlledModel,
    kinematics: Kinematics,
    state: FlexibleState,
    command: Vector,
    surfaces: Matrix,
    levers: Matrix = NO_LEVERS,
) -> float:
    """Move the state to the equilibrium of a command; contacts stick, a ball may roll.

    Newton's method on s(q, lambda) = S K (theta_cmd - theta) and on the contacts' poses. That is
    the least elastic energy under these constraints: a tree of springs on plane contacts is
    determined, also where its rigid twin is not.

    Args:
        controlled: The robot.
        kinematics: Overwritten; of the result at the end.
        state: Changed in place.
        command: (nj,) joint angles [rad].
        surfaces: (4, 3, 3) world_from_contact of the hands.
        levers: (4, 3) as in `DesiredState`.

    Returns:
        The largest residual that is left, of forces [N, Nm].

    Raises:
        ControlError: the command has no equilibrium near this state.
    """
    layout = ContactLayout(state.enabled, controlled.nv)
    nv, size = controlled.nv, layout.size
    joints = np.arange(6, nv)
    matrix, right = np.zeros((size, size)), np.zeros(size)
    for step in range(NEWTON_STEPS + 1):
        kinematics.update_statics(state.q, state.wrenches, surfaces, state.enabled, levers)
        residual = kinematics.static.copy()
        residual[6:] -= controlled.stiffness * (command - state.q[7:])
        if step == NEWTON_STEPS:
            break
        matrix[:nv, :nv] = kinematics.static_dq
        matrix[joints, joints] += controlled.stiffness
        right[:nv] = -residual
        for k, where in layout.slices.items():
            rows = kinematics.jacobians[k] if k in FEET else kinematics.point_jacobians[k - 2]
            matrix[where, :nv] = rows
            right[where.start : where.start + 3] = (
                state.contact_positions[k] - kinematics.positions[k]
            )
            if k in FEET:
                matrix[:nv, where] = -kinematics.local_jacobians[k].T
                turn = state.contact_rotations[k] @ kinematics.rotations[k].T
                rotation_vector(turn, right[where.start + 3 : where.stop])
            else:
                matrix[:nv, where] = -rows.T @ surfaces[k]
        try:
            change = np.asarray(np.linalg.solve(matrix, right), dtype=np.float64)
        except np.linalg.LinAlgError as error:
            raise ControlError("the flexible model has no equilibrium on these contacts") from error
        if not np.isfinite(change).all():
            raise ControlError("the flexible model has no equilibrium: its state is not finite")
        roll(
            1.0,
            change,
            kinematics.jacobians,
            controlled.tree.supports,
            levers,
            layout.table,
            state.contact_positions,
        )
        state.q = kinematics.integrate(state.q, change[:nv])
        for k, where in layout.slices.items():
            state.wrenches[k, : where.stop - where.start] += change[where]
    return float(np.abs(residual).max())
