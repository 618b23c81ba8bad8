"""What the robot touched that it must not.

Hit: any part of the robot touches anything but the floor with its soles, the named support with
its hand, and the thing that it reaches for with less than 5 N; or parts of it overlap each other;
or a thing that it was not told to touch is displaced by more than 1 cm. Looked at 50 times a second
of robot time.
"""

from collections.abc import Mapping, Sequence
from dataclasses import dataclass

import numpy as np

from w2c_evaluation.scenarios.record import Played
from w2c_evaluation.scenarios.scenario import Scenario
from w2c_evaluation.scenarios.truth_log import Sample

END_EFFECTORS = ("left_foot", "right_foot", "left_hand", "right_hand")
TOUCH_N = 5.0
SELF_OVERLAP_M = 0.005
"""The robot's shapes are convex hulls, a little larger than what they stand for"""
DISPLACED_M = 0.01


@dataclass(frozen=True)
class Robot:
    """What the judge must know of the robot."""

    links: frozenset[str]
    """All of them"""
    effectors: Mapping[str, int]
    """Links of feet and hands, and which they belong to"""
    hand_radius: tuple[float, float]
    """Of the balls at the left and right hand frame [m]"""


def find_hits(
    scenario: Scenario,
    played: Played,
    samples: Sequence[Sample],
    robot: Robot,
) -> tuple[str, ...]:
    """Return what was touched that must not be, in words, each once."""
    hits: dict[str, tuple[float, float]] = {}
    for sample in samples:
        allowed = _allowed(scenario, played, sample.stamp_ns)
        for link, other, depth in sample.contacts:
            text, size = _hit(link, other, depth, sample, allowed, robot)
            if text:
                first_s, worst = hits.get(text, (sample.stamp_ns * 1e-9, size))
                hits[text] = (first_s, max(worst, size))
    told = (
        f"{text.format(size)}, first at {first_s:.1f} s" for text, (first_s, size) in hits.items()
    )
    return (*told, *_displaced(scenario, samples))


def _hit(
    link: str,
    other: str,
    depth: float,
    sample: Sample,
    allowed: Mapping[str, Mapping[int, float]],
    robot: Robot,
) -> tuple[str, float]:
    """Return how to say that a contact must not be, and its size; "" where it may be."""
    if other in robot.links:
        overlap = depth > SELF_OVERLAP_M
        return (f"{link} meets {other} ({{:.0f}} mm)" if overlap else "", 1e3 * depth)
    effector = robot.effectors.get(link, -1)
    if other == "floor" and effector in (0, 1):
        return "", 0.0
    limit = allowed.get(other, {}).get(effector, 0.0)
    force = float(np.linalg.norm(sample.forces[effector])) if effector >= 0 else 0.0
    if limit <= 0.0:
        return f"{link} touches {other} (up to {{:.0f}} N)", force
    return (f"{link} pushes {other} (up to {{:.0f}} N)" if force > limit else "", force)


def _allowed(scenario: Scenario, played: Played, stamp_ns: int) -> dict[str, dict[int, float]]:
    """Return object -> hand -> the force that is allowed from now on [N]."""
    allowed: dict[str, dict[int, float]] = {}
    for prompt, run in zip(scenario.prompts, played.prompts, strict=False):
        if run.motion is None or run.motion.confirmed_ns > stamp_ns:
            continue
        hand = END_EFFECTORS.index(prompt.meaning.effector)
        limit = np.inf if prompt.meaning.task == "contact" else TOUCH_N
        for name in (*prompt.place.surfaces, *prompt.touches):
            hands = allowed.setdefault(name, {})
            hands[hand] = max(limit, hands.get(hand, 0.0))
    return allowed


def _displaced(scenario: Scenario, samples: Sequence[Sample]) -> tuple[str, ...]:
    """Return what was moved that nobody named."""
    if not samples:
        return ()
    named = {name for p in scenario.prompts for name in (*p.place.surfaces, *p.touches)}
    before, after = samples[0].objects, samples[-1].objects
    moves = {
        name: float(np.linalg.norm(np.subtract(after[name], place)))
        for name, place in before.items()
        if name in after and name not in named
    }
    return tuple(
        f"{name} was displaced by {100 * way:.0f} cm"
        for name, way in moves.items()
        if way > DISPLACED_M
    )
