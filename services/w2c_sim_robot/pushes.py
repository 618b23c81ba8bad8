"""Forces from outside on a simulated body, for a time."""

from dataclasses import dataclass

import mujoco
import numpy as np

from w2c.errors import ControlError
from w2c.messages import Array
from w2c.messages.base import all_finite

STRONGEST_N = 5000.0
LONGEST_S = 60.0


@dataclass(frozen=True)
class _Push:
    body: int
    force: Array
    first: int
    """Tick of its first step"""
    end: int
    """Tick before which it ends"""


class Pushes:
    """The forces that act on the bodies of a simulation. They add up."""

    def __init__(self, model: mujoco.MjModel, data: mujoco.MjData, period_ns: int) -> None:
        self._model = model
        self._applied = data.xfrc_applied
        self._period_ns = period_ns
        self._pushes: list[_Push] = []

    def reset(self) -> None:
        """Forget all. MuJoCo's reset has taken the forces away."""
        self._pushes.clear()

    def add(
        self, force: Array, duration_s: float, link: str, *, now: int, tick: int | None = None
    ) -> int:
        """Add one; see `Simulator.push`. Returns the tick at which it begins."""
        first = now if tick is None else tick
        body = mujoco.mj_name2id(self._model, mujoco.mjtObj.mjOBJ_BODY, link)
        if body <= 0:
            known = ", ".join(self._model.body(index).name for index in range(1, self._model.nbody))
            raise ControlError(f"no body '{link}' to push; there are: {known}")
        if first < now:
            raise ControlError(f"a push from tick {first} on is too late: the robot is at {now}")
        if np.shape(force) != (3,) or not all_finite(np.asarray(force, dtype=np.float64)):
            raise ControlError(f"a push of {force}: a force is three finite numbers [N]")
        if not np.linalg.norm(force) <= STRONGEST_N:
            raise ControlError(
                f"a push of {np.linalg.norm(force):.0f} N is beyond {STRONGEST_N:.0f} N"
            )
        if not 0.0 <= duration_s <= LONGEST_S:
            raise ControlError(f"a push of {duration_s:g} s is outside 0 to {LONGEST_S:g} s")
        ticks = max(1, round(duration_s * 1e9 / self._period_ns))
        self._pushes.append(_Push(body, np.array(force, dtype=np.float64), first, first + ticks))
        return first

    def begin(self, tick: int) -> None:
        """Apply what acts during a tick."""
        if self._pushes:
            self._apply(tick)

    def end(self, tick: int) -> None:
        """Take away what has ended when a tick begins."""
        if any(push.end <= tick for push in self._pushes):
            self._pushes = [push for push in self._pushes if push.end > tick]
            self._apply(tick)

    def _apply(self, tick: int) -> None:
        self._applied[:] = 0.0
        for push in self._pushes:
            if push.first <= tick:
                self._applied[push.body, :3] += push.force
