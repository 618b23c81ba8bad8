"""Lifts a foot while a hand leans, holds it in the air, and judges by the truth."""

import time

import numpy as np

from w2c import topics
from w2c.bus import Bus
from w2c.messages import GoalEvent, ReleaseGoal
from w2c_evaluation.demo.operator import END_EFFECTORS, FINAL_STATES
from w2c_evaluation.scenarios.truth_log import TruthLog

LEFT_FOOT = END_EFFECTORS.index("left_foot")
LIFTED_M = 0.02
HELD_S = 3.0
PATIENCE_S = 300.0
"""Wall time: a lock step on a busy machine takes five times as long as the motion"""


def lift_left_foot(bus: Bus, log: TruthLog) -> str:
    """Lift the left foot and hold it. Returns what went wrong; empty = it was up all the time.

    Raises:
        CallError: the controller refuses, or does not answer.
    """
    before = log.samples[-1].effectors[LEFT_FOOT, 2]
    events = bus.queue(topics.GOAL_EVENT)
    goal = ReleaseGoal(goal_id="lift-left-foot", end_effector="left_foot")
    bus.call(topics.RELEASE, goal)
    deadline = time.monotonic() + PATIENCE_S
    while time.monotonic() < deadline:
        received = events.receive(0.5)
        if received is not None and _ends(received.message, goal.goal_id):
            return _hold(log, before, received.message)
    return f"the foot was not lifted within {PATIENCE_S:.0f} s"


def _ends(event: GoalEvent, goal_id: str) -> bool:
    return event.goal_id == goal_id and event.state in FINAL_STATES


def _hold(log: TruthLog, before: float, event: GoalEvent) -> str:
    """Watch the foot for a while."""
    if event.state != "released":
        return f"lifting the foot ended as {event.state}: {event.reason}"
    end_ns = event.stamp_ns + round(HELD_S * 1e9)
    if not log.wait_for(end_ns, PATIENCE_S):
        return "the simulator stopped telling the truth: is it still running?"
    heights = [s.effectors[LEFT_FOOT, 2] for s in log.samples if s.stamp_ns >= event.stamp_ns]
    lowest = float(np.min(heights)) - before
    if lowest < LIFTED_M:
        return f"the foot was {1e3 * lowest:.0f} mm up, at least {1e3 * LIFTED_M:.0f}"
    return ""
