"""The robot as capsules: where no goal can be, because the robot is there."""

import itertools
from collections.abc import Iterator
from dataclasses import dataclass

import numpy as np
import numpy.typing as npt
import pinocchio as pin

from w2c_controller.kinematics.model import ControlledModel
from w2c_controller.parameters import EFFECTORS, FEET, HANDS

Vector = npt.NDArray[np.float64]

TRUNK_RADIUS = 0.15
"""[m]"""
HEAD_HEIGHT = 0.35
"""Over the shoulders [m]."""
HEAD_RADIUS = 0.12
LEG_RADIUS = 0.08
ARM_RADIUS = 0.06
SOLE_HALF_LENGTH = 0.08
"""Of the line through the middle of a sole [m]."""
SOLE_HALF_WIDTH = 0.065
SHORTEST = 0.02
"""Joints closer together make no capsule of their own [m]."""


@dataclass(frozen=True)
class Capsule:
    """All points within `radius` of a line."""

    part: str
    """What people call it"""
    start: Vector
    """(3,) in the world [m]"""
    end: Vector
    radius: float

    def depth(self, point: Vector) -> float:
        """Return how deep inside a point (3,) is [m]; negative outside."""
        along = self.end - self.start
        length = float(along @ along)
        share = float((point - self.start) @ along) / length if length > 0.0 else 0.0
        nearest = self.start + min(max(share, 0.0), 1.0) * along
        return self.radius - float(np.linalg.norm(point - nearest))


class Body:
    """Capsules around trunk, legs and arms, from the model alone. Not thread-safe."""

    def __init__(self, controlled: ControlledModel) -> None:
        self._controlled = controlled
        self._data = controlled.model.createData()

    def place(self, q: Vector) -> None:
        """Take a posture (nq,)."""
        pin.framesForwardKinematics(self._controlled.model, self._data, q)

    def inside(self, point: Vector, effector: int) -> tuple[Capsule, float] | None:
        """Return the capsule that a point (3,) is deepest in, and how deep [m]; None: in no one.

        Args:
            point: In the world, of the posture that was placed last.
            effector: What shall go there: its own limb does not count.
        """
        found = [(capsule, capsule.depth(point)) for capsule in self.capsules(effector)]
        deepest = max(found, key=lambda pair: pair[1])
        return deepest if deepest[1] > 0.0 else None

    def capsules(self, without: int) -> Iterator[Capsule]:
        """Yield the capsules of all but one limb."""
        hips = np.mean([self._limb(k)[0] for k in FEET], axis=0)
        chest = np.mean([self._limb(k)[0] for k in HANDS], axis=0)
        up = HEAD_HEIGHT * np.array(self._data.oMi[1].rotation)[:, 2]
        yield Capsule("trunk", hips, chest, TRUNK_RADIUS)
        yield Capsule("head", chest, chest + up, HEAD_RADIUS)
        for k, name in enumerate(EFFECTORS):
            if k == without:
                continue
            part = name.replace("foot", "leg").replace("hand", "arm").replace("_", " ")
            points = self._limb(k)
            radius = LEG_RADIUS if k in FEET else ARM_RADIUS
            for start, end in itertools.pairwise(points):
                yield Capsule(part, start, end, radius)
            if k in FEET:
                placement = self._data.oMf[self._controlled.frames[k]]
                forward = SOLE_HALF_LENGTH * np.array(placement.rotation)[:, 0]
                middle = points[-1]
                # A sole needs its own half width beside the other one.
                radius = 2.0 * SOLE_HALF_WIDTH if without in FEET else SOLE_HALF_WIDTH
                foot = name.replace("_", " ")
                yield Capsule(foot, middle - forward, middle + forward, radius)

    def _limb(self, effector: int) -> list[Vector]:
        """Return the joints of a limb from its root, then its end effector, each (3,) [m]."""
        joints = [int(row) - 6 + 2 for row in self._controlled.joints_of(effector)]
        ends = [np.array(self._data.oMi[joint].translation) for joint in joints]
        ends.append(np.array(self._data.oMf[self._controlled.frames[effector]].translation))
        points = [ends[0]]
        for end in ends[1:]:
            if float(np.linalg.norm(end - points[-1])) > SHORTEST:
                points.append(end)
        return points
