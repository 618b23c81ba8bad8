"""Which contacts exist, where their wrenches stand among the variables, and their cones."""

from collections.abc import Callable
from dataclasses import dataclass
from functools import cached_property
from typing import TypeVar

import numpy as np
import numpy.typing as npt

from w2c_controller.kinematics.tree import Tree
from w2c_controller.parameters import FEET, HANDS, Limits
from w2c_controller.solvers.structure import Structure

Vector = npt.NDArray[np.float64]
Matrix = npt.NDArray[np.float64]
Indices = npt.NDArray[np.intp]

T = TypeVar("T")

Enabled = tuple[bool, bool, bool, bool]
"""Left foot, right foot, left hand, right hand."""

PLANE_SIZE = 6
POINT_SIZE = 3


@dataclass(frozen=True)
class ContactLayout:
    """Order of the QP's variables x = [v (nv); wrench rates], for one set of contacts."""

    enabled: Enabled
    nv: int

    @cached_property
    def slices(self) -> dict[int, slice]:
        """Where the wrench rate of each enabled contact stands in x."""
        result = {}
        start = self.nv
        for k in (*FEET, *HANDS):
            if self.enabled[k]:
                size = PLANE_SIZE if k in FEET else POINT_SIZE
                result[k] = slice(start, start + size)
                start += size
        return result

    @cached_property
    def size(self) -> int:
        """Number of variables."""
        sizes = [PLANE_SIZE if k in FEET else POINT_SIZE for k in self.slices]
        return self.nv + sum(sizes)

    @cached_property
    def equality_rows(self) -> int:
        """Six for the base's equilibrium, six a plane, three a point."""
        return 6 + self.size - self.nv

    @cached_property
    def table(self) -> Indices:
        """Contacts (nc, 3): end effector, first variable, number of variables."""
        rows = [(k, where.start, where.stop - where.start) for k, where in self.slices.items()]
        return np.array(rows, dtype=np.intp).reshape(-1, 3)

    def torque_columns(self, tree: Tree) -> Indices:
        """Return which columns of each joint's torque row T_J are not zero.

        They are (nj, n), ascending, then -1: those of the joints between base and tips through it,
        and of the wrenches of the end effectors beyond it.
        """
        joints = self.nv - 6
        above = [set[int]() for _ in range(joints)]
        for i in range(joints):
            body = i + 1
            while body > 0:
                above[i].add(body + 5)
                body = int(tree.parents[body])
        columns = np.full((joints, self.size), -1, dtype=np.intp)
        for i in range(joints):
            below = {j + 6 for j in range(joints) if i + 6 in above[j]}
            wrenches = {
                column
                for k, where in self.slices.items()
                if i + 6 in tree.supports[k]
                for column in range(where.start, where.stop)
            }
            # A moved base changes no torque, a turned one does.
            found = sorted({3, 4, 5} | above[i] | below | wrenches)
            columns[i, : len(found)] = found
        return columns

    def structure(self, tree: Tree) -> Structure:
        """Return the order in which a QP over these variables is eliminated: limb by limb.

        A limb is a branch of the base with all its joints, the wrenches of its contacts, and the
        equalities that fix them. The base and its equilibrium are the trunk. Equalities stand in
        the order of the contacts, the equilibrium last.
        """
        branches = np.arange(tree.parents.size)
        for body in range(1, branches.size):
            if tree.parents[body] > 0:
                branches[body] = branches[tree.parents[body]]
        limbs = []
        for branch in np.unique(branches[1:]):
            wrenches, fixed, row = list[int](), list[int](), self.size
            for k, where in self.slices.items():
                size = where.stop - where.start
                if branches[tree.effector_bodies[k]] == branch:
                    wrenches += range(where.start, where.stop)
                    fixed += range(row, row + size)
                row += size
            joints = [5 + int(body) for body in np.flatnonzero(branches == branch)[::-1]]
            limbs.append([*wrenches, *joints, *fixed])
        return Structure.of_limbs(self.size, self.equality_rows, limbs)


def contact_sets() -> list[Enabled]:
    """Return every set of contacts with at least one foot."""
    flags = (False, True)
    return [
        (left_foot, right_foot, left_hand, right_hand)
        for left_foot, right_foot in ((True, True), (True, False), (False, True))
        for left_hand in flags
        for right_hand in flags
    ]


def per_contact_set(nv: int, make: Callable[[ContactLayout], T]) -> dict[Enabled, T]:
    """Return what is made of the layout of each set of contacts, so that the loop makes nothing."""
    return {enabled: make(ContactLayout(enabled, nv)) for enabled in contact_sets()}


def plane_cone(limits: Limits) -> Matrix:
    """Return C (16, 6) of C w <= 0 for w = (fx, fy, fz, tx, ty, tz) in the sole frame.

    Friction, centre of pressure, and torsion of a rectangular sole with half sizes X, Y (Caron,
    Pham and Nakamura, ICRA 2015):

        |fx|, |fy| <= mu fz,   |tx| <= Y fz,   |ty| <= X fz,
        tz >= -mu (X+Y) fz + |Y fx - mu tx| + |X fy - mu ty|,
        tz <=  mu (X+Y) fz - |Y fx + mu tx| - |X fy + mu ty|.
    """
    mu, x, y = limits.friction, limits.cop_x, limits.cop_y
    rows = []
    for sign in (1.0, -1.0):
        rows.append([sign, 0, -mu, 0, 0, 0])
        rows.append([0, sign, -mu, 0, 0, 0])
        rows.append([0, 0, -y, sign, 0, 0])
        rows.append([0, 0, -x, 0, sign, 0])
    reach = mu * (x + y)
    for a in (1.0, -1.0):
        for b in (1.0, -1.0):
            rows.append([a * y, b * x, -reach, -a * mu, -b * mu, -1.0])
            rows.append([a * y, b * x, -reach, a * mu, b * mu, 1.0])
    return np.array(rows)


def point_cone(limits: Limits) -> Matrix:
    """Return C (4, 3) of C f <= 0 for f in the contact frame: |fx|, |fy| <= mu fz."""
    mu = limits.friction
    return np.array([[1, 0, -mu], [-1, 0, -mu], [0, 1, -mu], [0, -1, -mu]], dtype=np.float64)


def wrench_rate_limits(limits: Limits, contact: int, *, lost: bool = False) -> Vector:
    """Return the largest wrench rate (6,) or (3,) of a contact [N/s, Nm/s].

    Args:
        limits: All of them.
        contact: Index of the end effector.
        lost: Whether some contact carries nothing any more.
    """
    if contact in FEET:
        force, torque = limits.foot_force_rate, limits.foot_torque_rate
        if lost:
            force, torque = limits.lost_force_rate, limits.lost_torque_rate
        return np.array([force, force, force, torque, torque, torque])
    return np.full(POINT_SIZE, limits.lost_force_rate if lost else limits.hand_force_rate)


def normal_force_limits(limits: Limits, contact: int) -> tuple[float, float]:
    """Return the smallest and largest normal force of a loaded contact [N]."""
    if contact in FEET:
        return limits.foot_force_min, limits.foot_force_max
    return limits.hand_force_min, limits.hand_force_max
