"""Where the base is in the world: by the feet that stand.

The world's origin is midway between the soles when the robot is first seen. Each foot that stands
keeps its place in the world, its anchor; the base follows from the anchors and the joint angles. A
foot that is lifted has no say, the other one carries the estimate on; where it comes down it gets
a new anchor, or keeps its former one where it is still there. So nothing drifts while feet stand.
"""

from collections.abc import Callable
from dataclasses import dataclass

import numpy as np
import numpy.typing as npt

from w2c.geometry import Matrix, base_from_midfeet, inverse, transform, unit

Feet = tuple[bool, bool]
Soles = tuple[Matrix, Matrix]

STANDS = 60.0
"""A foot in the air stands once the floor pushes with more [N]"""
LIFTED = 25.0
"""A foot that stands is in the air once the floor pushes with less [N]"""
SETTLED_NS = 50_000_000
"""A foot must push for so long before it counts: it may still slide or roll"""
LOST_NS = 200_000_000
"""Without any foot on the ground for so long, the robot may be anywhere"""
SAME_PLACE = 0.003
"""A foot that comes down this near to where it stood has not moved [m]"""
SAME_TURN = 0.01
"""... nor turned [rad]"""


@dataclass(frozen=True)
class Stance:
    """Which feet stand, and where."""

    standing: Feet
    """Left, right; at least one"""
    anchors: Soles
    """world_from_sole (4, 4) left, right; of a foot in the air: where it stood last"""
    world: int
    """Number of the world: another one is not where the former was"""

    def world_from_base(self, base_from_soles: Soles) -> Matrix:
        """Return the pose (4, 4) of the base for soles (left, right) where the joints put them."""
        if all(self.standing):
            return midway(*self.anchors) @ inverse(midway(*base_from_soles))
        foot = self.standing.index(True)
        return np.asarray(self.anchors[foot] @ inverse(base_from_soles[foot]))


def midway(left: Matrix, right: Matrix) -> Matrix:
    """Return the frame (4, 4) midway between two soles, in the frame that both are given in."""
    return base_from_midfeet(left, right)


def both_feet(base_from_soles: Soles, world: int = 0) -> Stance:
    """Return the stance of a robot on both feet, with the world midway between them."""
    world_from_base = inverse(midway(*base_from_soles))
    left, right = (np.asarray(world_from_base @ sole) for sole in base_from_soles)
    return Stance((True, True), (left, right), world)


class StanceEstimator:
    """Follows the feet through the states of a robot. One for each boot of the robot."""

    def __init__(self) -> None:
        self._stance: Stance | None = None
        self._worlds = 0
        self._pushing_since_ns: list[int | None] = [None, None]
        self._seen_ns = -1

    @property
    def stance(self) -> Stance | None:
        """Return the present stance; None while no foot stands."""
        return self._stance

    def move(self, anchors: Soles) -> None:
        """Go on in the world of somebody else, in which the feet that stand are elsewhere.

        Args:
            anchors: world_from_sole (4, 4) left, right, in that world.
        """
        if self._stance is not None and not _agree(self._stance, anchors):
            self._worlds += 1
            self._stance = Stance(self._stance.standing, anchors, self._worlds)

    def update(
        self,
        stamp_ns: int,
        normal_forces: npt.ArrayLike,
        base_from_soles: Callable[[], Soles],
    ) -> Stance | None:
        """Take one state of the robot and return the stance; None while no foot stands.

        Args:
            stamp_ns: of the state.
            normal_forces: (2,) what the floor exerts along the soles' normals, left, right [N]. A
                sensor that does not read a number says nothing: its foot stays what it is.
            base_from_soles: gives the soles (4, 4) left, right; called when a foot comes down.
        """
        forces = np.asarray(normal_forces, dtype=np.float64)
        before: Feet = (False, False) if self._stance is None else self._stance.standing
        left, right = (self._stands(k, stamp_ns, float(forces[k]), before[k]) for k in (0, 1))
        standing = (left, right)
        if any(standing):
            self._seen_ns = stamp_ns
            if standing != before:
                self._stance = self._changed(standing, base_from_soles())
        elif self._stance is not None and stamp_ns - self._seen_ns > LOST_NS:
            self._stance = None
        return self._stance

    def _stands(self, foot: int, stamp_ns: int, force: float, stood: bool) -> bool:
        """Tell whether a foot stands now."""
        if not np.isfinite(force):
            return stood
        if force < (LIFTED if stood else STANDS):
            self._pushing_since_ns[foot] = None
            return False
        since = self._pushing_since_ns[foot]
        if since is None:
            since = self._pushing_since_ns[foot] = stamp_ns
        # The first stance is taken as it is: nothing was known before it.
        return stood or self._worlds == 0 or stamp_ns - since >= SETTLED_NS

    def _changed(self, standing: Feet, base_from_soles: Soles) -> Stance:
        """Return the stance after a foot was lifted or came down."""
        former = self._stance
        if former is None:
            self._worlds += 1
            return _first(standing, base_from_soles, self._worlds)
        if not any(a and b for a, b in zip(standing, former.standing, strict=True)):
            # Changed feet between two states: the world goes on from where the former ones stood.
            world_from_base = former.world_from_base(base_from_soles)
        else:
            kept = tuple(a and b for a, b in zip(standing, former.standing, strict=True))
            world_from_base = Stance(
                (kept[0], kept[1]), former.anchors, former.world
            ).world_from_base(base_from_soles)
        left, right = (
            _anchor(former.anchors[k], np.asarray(world_from_base @ base_from_soles[k]))
            if standing[k] and not former.standing[k]
            else former.anchors[k]
            for k in (0, 1)
        )
        return Stance(standing, (left, right), former.world)


def _first(standing: Feet, base_from_soles: Soles, world: int) -> Stance:
    """Return the first stance in a world. On one foot the other is taken as lifted straight up."""
    if all(standing):
        return both_feet(base_from_soles, world)
    foot = standing.index(True)
    ground, lifted = base_from_soles[foot], base_from_soles[1 - foot]
    normal = ground[:3, 2]
    height = float((lifted[:3, 3] - ground[:3, 3]) @ normal)
    forward = unit(lifted[:3, 0] - (lifted[:3, 0] @ normal) * normal)
    rotation = np.column_stack([forward, np.cross(normal, forward), normal])
    put_down = transform(rotation, lifted[:3, 3] - height * normal)
    soles = (ground, put_down) if foot == 0 else (put_down, ground)
    return Stance(standing, both_feet(soles).anchors, world)


def _anchor(former: Matrix, now: Matrix) -> Matrix:
    """Return the anchor of a foot that came down: the former one, where it is still there."""
    return former if _same_place(former, now) else now


def _agree(stance: Stance, anchors: Soles) -> bool:
    """Tell whether the feet that stand are where somebody else has them."""
    return all(_same_place(stance.anchors[k], anchors[k]) for k in (0, 1) if stance.standing[k])


def _same_place(one: Matrix, other: Matrix) -> bool:
    """Tell whether two poses of a sole (4, 4) are one."""
    moved = float(np.linalg.norm(other[:3, 3] - one[:3, 3]))
    turned = float(np.arccos(np.clip((np.trace(other[:3, :3].T @ one[:3, :3]) - 1) / 2, -1, 1)))
    return moved < SAME_PLACE and turned < SAME_TURN
