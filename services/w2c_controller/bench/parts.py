"""Where the time of a tick goes: the clock is read around the parts, from outside."""

import time
from collections.abc import Callable
from typing import Any, Final

import numpy as np

from w2c_controller.controller import Controller

REST: Final = "rest"
"""Guards, sensing, switching, gaze, and what is left."""
FILTERS: Final = "filters"
STAGES: Final = ("assembly", "solve", "integration")


class Parts:
    """Times the parts of one controller from now on. The clock's own time is subtracted."""

    def __init__(self, controller: Controller) -> None:
        names = [f"{qp}_{stage}" for qp in ("retargeting", "force_control") for stage in STAGES]
        self.samples: dict[str, list[int]] = {name: [] for name in (FILTERS, *names, REST)}
        """[ns], one a tick"""
        self._now = dict.fromkeys((*self.samples, "retargeting", "force_control"), 0)
        self._clock = _clock_time()
        retargeting, force = controller.retargeting, controller.force_control
        self._watch(controller.body.end_effectors, "step", FILTERS)
        for name, owner, programs in (
            ("retargeting", retargeting, retargeting._builders),
            ("force_control", force, force._programs),
        ):
            self._watch(owner.kinematics, "update_statics", f"{name}_assembly")
            for program in programs.values():
                self._watch(program, "fill", f"{name}_assembly")
            self._watch(owner._solver, "solve", f"{name}_solve")
            self._watch(owner, "tick", name)

    def end_tick(self, total: int) -> None:
        """Book a tick that took this long [ns]."""
        now, rest = self._now, total
        for name in ("retargeting", "force_control"):
            inside = now[f"{name}_assembly"] + now[f"{name}_solve"]
            now[f"{name}_integration"] = max(now[name] - inside, 0)
            rest -= now[name]
        now[REST] = max(rest - now[FILTERS], 0)
        for name, samples in self.samples.items():
            samples.append(now[name])
        for name in now:
            now[name] = 0

    def _watch(self, owner: Any, method: str, part: str) -> None:
        """Put a clock around a method of one object."""
        inner: Callable[..., Any] = getattr(owner, method)
        now, clock = self._now, self._clock

        def timed(*arguments: Any, **keywords: Any) -> Any:
            begin = time.thread_time_ns()
            try:
                return inner(*arguments, **keywords)
            finally:
                now[part] += time.thread_time_ns() - begin - clock

        setattr(owner, method, timed)


def _clock_time() -> int:
    """Return what reading the clock twice takes [ns]."""
    readings = [-time.thread_time_ns() + time.thread_time_ns() for _ in range(1000)]
    return int(np.median(readings))
