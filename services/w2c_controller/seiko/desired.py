"""The state that the Retargeting integrates: desired posture, contact wrenches, contact set.

Nothing measured enters it: measured wrenches or re-localised contacts would make the QP infeasible.
"""

from dataclasses import dataclass, field

import numpy as np
import numpy.typing as npt

from w2c_controller.seiko.contacts import Enabled

Vector = npt.NDArray[np.float64]
Matrix = npt.NDArray[np.float64]

STANDING: Enabled = (True, True, False, False)


@dataclass
class DesiredState:
    """Posture, wrenches and contacts; arrays over end effectors are in the order of `EFFECTORS`."""

    q: Vector
    """(nq,)"""
    posture: Vector
    """(nj,) joint angles that free motion tends to [rad]"""
    enabled: Enabled = STANDING
    releasing: list[bool] = field(default_factory=lambda: [False] * 4)
    """Contacts that are being unloaded"""
    lost: list[bool] = field(default_factory=lambda: [False] * 4)
    """Those of them that carry nothing any more: the others take over as fast as they can"""
    pushing: list[bool] = field(default_factory=lambda: [False] * 4)
    """Contacts whose normal force tracks `push_force`, and whose other components go to zero"""
    push_force: Vector = field(default_factory=lambda: np.zeros(4))
    """(4,) normal force wanted of each contact that pushes [N]"""
    wrenches: Matrix = field(default_factory=lambda: np.zeros((4, 6)))
    """(4, 6) feet: force, torque in the sole frame; hands: force in the contact frame, then
    zeros"""
    force_min: Vector = field(default_factory=lambda: np.zeros(4))
    """(4,) smallest normal force allowed now [N]; grows with the force of a new contact"""
    contact_rotations: Matrix = field(default_factory=lambda: np.tile(np.eye(3), (4, 1, 1)))
    """(4, 3, 3) world_from_contact of the hands"""
    levers: Matrix = field(default_factory=lambda: np.zeros((4, 3)))
    """(4, 3) of the hands in contact: from the frame's origin to the point that touches, in the
    world [m]. A ball rolls on it; zero where the origin itself stays."""
    target_positions: Matrix = field(default_factory=lambda: np.zeros((4, 3)))
    """(4, 3) in the world: of a contact, where it was made, and has rolled to since; of a free end
    effector, where it goes"""
    target_rotations: Matrix = field(default_factory=lambda: np.tile(np.eye(3), (4, 1, 1)))
    torque: Vector = field(default_factory=lambda: np.zeros(0))
    """(nj,) joint torques of the static equilibrium [Nm]"""
    velocity: Vector = field(default_factory=lambda: np.zeros(0))
    """(nv,) of the last tick"""

    def __post_init__(self) -> None:
        if not self.velocity.size:
            self.velocity = np.zeros(self.posture.size + 6)
        if not self.torque.size:
            self.torque = np.zeros(self.posture.size)

    def copy(self) -> "DesiredState":
        """Return an independent copy, to look ahead on."""
        return DesiredState(
            q=self.q.copy(),
            posture=self.posture.copy(),
            enabled=self.enabled,
            releasing=list(self.releasing),
            lost=list(self.lost),
            pushing=list(self.pushing),
            push_force=self.push_force.copy(),
            wrenches=self.wrenches.copy(),
            force_min=self.force_min.copy(),
            contact_rotations=self.contact_rotations.copy(),
            levers=self.levers.copy(),
            target_positions=self.target_positions.copy(),
            target_rotations=self.target_rotations.copy(),
            torque=self.torque.copy(),
            velocity=self.velocity.copy(),
        )

    def world_force(self, contact: int, rotations: Matrix) -> Vector:
        """Return the force (3,) that an end effector shall feel, in the world [N].

        Args:
            contact: Index of the end effector.
            rotations: (4, 3, 3) world_from_effector of this posture.
        """
        if not self.enabled[contact]:
            return np.zeros(3)
        frame = rotations[contact] if contact < 2 else self.contact_rotations[contact]
        return np.asarray(frame @ self.wrenches[contact, :3])


def with_contact(enabled: Enabled, contact: int, value: bool) -> Enabled:
    """Return the contact set with one contact set or cleared."""
    flags = list(enabled)
    flags[contact] = value
    return flags[0], flags[1], flags[2], flags[3]
