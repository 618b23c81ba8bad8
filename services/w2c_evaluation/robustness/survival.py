"""Whether a robot survived a reach: a judgement on what the simulator knows, sample by sample."""

from dataclasses import dataclass, field

import numpy as np

from w2c.messages import Truth
from w2c_evaluation.robustness.grid import Cause, Target

ENOUGH = 0.9
"""Share of the way that counts as reached."""
LOWEST_PELVIS = 0.85
"""A robot that stands has its pelvis above this [m]; ready, it is at 1.0 m."""
STEEPEST_PELVIS = np.radians(20.0)
STILL = 0.05
"""The pelvis of a robot that stands moves slower than this [m/s]."""
LEAST_FOOT_FORCE = 20.0
"""A foot that stands bears more [N]."""
HANDS = (2, 3)
SAMPLE_S = 0.05
"""Between two samples of robot time [s]."""


@dataclass
class Trace:
    """What happened so far."""

    target: Target
    times: list[float] = field(default_factory=list)
    """[s]"""
    shares: list[float] = field(default_factory=list)
    """Of the way to the target, along it"""
    hands: list[np.ndarray] = field(default_factory=list)
    """(3,) of the reaching hand [m]"""
    pelvis: list[np.ndarray] = field(default_factory=list)
    """(7,) position, quaternion xyzw"""
    foot_forces: tuple[float, float] = (0.0, 0.0)
    """Vertical, now [N]"""
    fell: bool = False
    touched: bool = False
    """A hand touched something"""

    def add(self, truth: Truth, time: float, hand: int) -> None:
        """Add a sample."""
        start, point = np.array(self.target.start), np.array(self.target.point)
        way = point - start
        position = truth.end_effector_positions[hand]
        self.times.append(time)
        self.hands.append(np.array(position))
        self.shares.append(float((position - start) @ way / (way @ way)))
        self.pelvis.append(np.array(truth.world_from_base))
        forces = truth.contact_forces
        self.foot_forces = (float(forces[0, 2]), float(forces[1, 2]))
        self.fell = self.fell or truth.fell
        self.touched = self.touched or bool(np.abs(forces[list(HANDS)]).max() > 0.0)


def judge(trace: Trace, deadline: float) -> Cause:
    """Return why the trial was not survived, "" = it was.

    Args:
        trace: From the start to the end of the last rest.
        deadline: By when the target had to be reached [s].
    """
    if trace.fell:
        return "fell"
    if trace.touched:
        return "touched"
    if reached(trace, deadline) < ENOUGH:
        return "short"
    return "" if stands(trace) else "not_standing"


def reached(trace: Trace, deadline: float) -> float:
    """Return the largest share of the way that the hand came by the deadline."""
    shares = [s for s, time in zip(trace.shares, trace.times, strict=True) if time <= deadline]
    return max(shares, default=0.0)


def stands(trace: Trace) -> bool:
    """Return whether the robot is upright, on both feet and at rest, now and half a second ago."""
    if len(trace.pelvis) < 2 or min(trace.foot_forces) < LEAST_FOOT_FORCE:
        return False
    now, before = trace.pelvis[-1], trace.pelvis[max(len(trace.pelvis) - 11, 0)]
    passed = trace.times[-1] - trace.times[max(len(trace.times) - 11, 0)]
    x, y = now[3], now[4]
    upright = np.arccos(np.clip(1.0 - 2.0 * (x * x + y * y), -1.0, 1.0))
    speed = float(np.linalg.norm(now[:3] - before[:3])) / max(passed, 1e-9)
    return bool(now[2] > LOWEST_PELVIS and upright < STEEPEST_PELVIS and speed < STILL)


def achieved_speed(trace: Trace) -> float:
    """Return the mean speed from 10 to 90 % of the way [m/s]; -1 where that was not reached."""
    times = []
    for share in (0.1, ENOUGH):
        later = (t for s, t in zip(trace.shares, trace.times, strict=True) if s >= share)
        time = next(later, None)
        if time is None:
            return -1.0
        times.append(time)
    way = np.array(trace.target.point) - np.array(trace.target.start)
    passed = max(times[1] - times[0], SAMPLE_S)
    return float(np.linalg.norm(way)) * (ENOUGH - 0.1) / passed


def top_speed(trace: Trace) -> float:
    """Return the largest mean speed over 0.1 s [m/s] until 90 % of the way, or all of it."""
    past = (i for i, share in enumerate(trace.shares) if share >= ENOUGH)
    end = next(past, len(trace.shares) - 1)
    speeds = [
        float(np.linalg.norm(trace.hands[i + 2] - trace.hands[i]))
        / (trace.times[i + 2] - trace.times[i])
        for i in range(end - 1)
    ]
    return max(speeds, default=0.0)
