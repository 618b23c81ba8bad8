"""An end effector on a path: the path's clock waits for it, and tells when it is stuck."""

import math

import numpy as np
import numpy.typing as npt

from w2c_controller.motion.end_effectors import EndEffectors
from w2c_controller.motion.routes import at
from w2c_controller.motion.trajectory import Path
from w2c_controller.parameters import HANDS, Motion
from w2c_controller.switching.stall import StallDetector

Vector = npt.NDArray[np.float64]


class Travel:
    """One path at a time, of one end effector."""

    def __init__(self, end_effectors: EndEffectors, motion: Motion, lead: float, dt: float) -> None:
        """Stay where the left hand is.

        Args:
            end_effectors: Take the targets.
            motion: Limits of a stall.
            lead: How far the target may be ahead of the end effector [m].
            dt: Period [s].
        """
        self._end_effectors = end_effectors
        self._lead = lead
        self._dt = dt
        self._stall = StallDetector(motion, dt)
        self._effector = HANDS[0]
        self._keeps_up = True
        self.path: Path = at(end_effectors.position(self._effector))

    def start(self, effector: int, path: Path) -> None:
        """Begin a path at its start."""
        self._effector, self.path = effector, path
        self._end_effectors.targets[effector] = path.position()
        self._stall.reset()

    def present(self, effector: int) -> tuple[Vector, Vector]:
        """Return where a new path must begin so that the target goes on as it moves.

        Returns:
            Point (3,) [m] and velocity (3,) [m/s]: of the path that the end effector is on, or of
            the end effector itself where it is on none.
        """
        point = self.path.position()
        if effector == self._effector and (point == self._end_effectors.targets[effector]).all():
            return point, self.path.velocity() if self._keeps_up else np.zeros(3)
        return self._end_effectors.position(effector), self._end_effectors.velocity(effector)

    def follow(self, pace: float = 1.0) -> bool:
        """Advance by one tick while the end effector keeps up. Returns whether it is stuck.

        Args:
            pace: As a share of the speed that the path was planned for.
        """
        position = self._end_effectors.position(self._effector)
        target = self.path.position()
        self._keeps_up = math.dist(target.tolist(), position.tolist()) < self._lead
        if not self._keeps_up:
            self._end_effectors.targets[self._effector] = target
            return self._stall.step(position)
        self.path.advance(pace * self._dt)
        self._stall.reset()
        self._end_effectors.targets[self._effector] = self.path.position()
        return False

    def rests(self) -> bool:
        """Look at an end effector that follows no path: whether it stopped moving."""
        return self._stall.step(self._end_effectors.position(self._effector))

    def watch_anew(self) -> None:
        """Forget how long the end effector has not moved."""
        self._stall.reset()

    def next_leg(self) -> None:
        """Go to the start of the next leg, wherever this one was."""
        self.path.next_leg()
        self._stall.reset()

    def finish(self) -> None:
        """Take the end of the path as the target."""
        self._end_effectors.targets[self._effector] = self.path.end
