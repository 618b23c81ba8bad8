"""Push mode: the commanded normal force of a hand, as the QP may follow it.

The target keeps within a few newtons of the desired force (anti-windup), passes a low-pass, then a
planner with bounded rate and acceleration, as SEIKO commands forces.
"""

import math

from w2c_controller.motion.filters import low_pass_gain
from w2c_controller.switching.contact_parameters import Push


class PushCommand:
    """The target of one hand."""

    def __init__(self, push: Push, dt: float) -> None:
        self._push = push
        self._dt = dt
        self._share = 1.0 - low_pass_gain(push.low_pass_hz, dt)
        self.goal = 0.0
        """The force that was commanded [N]"""
        self.target = 0.0
        """What the QP shall track now [N]"""
        self._smooth = 0.0
        self._rate = 0.0

    def reset(self, force: float) -> None:
        """Start again, at rest, from a desired force [N]."""
        self.goal = self.target = self._smooth = force
        self._rate = 0.0

    def step(self, present: float) -> float:
        """Return the target of the next tick [N].

        Args:
            present: The desired force now [N]: the target leads it by a bounded amount.
        """
        push, dt = self._push, self._dt
        near = min(max(self.goal, present - push.lead), present + push.lead)
        self._smooth += self._share * (near - self._smooth)
        error = self._smooth - self.target
        half = 0.5 * push.acceleration * dt
        braking = math.sqrt(half * half + 2.0 * push.acceleration * abs(error)) - half
        wanted = math.copysign(min(braking, push.rate, abs(error) / dt), error)
        change = push.acceleration * dt
        self._rate += min(max(wanted - self._rate, -change), change)
        self.target += dt * self._rate
        return self.target
