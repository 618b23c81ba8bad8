"""Whether a run succeeded, from what was true.

Success: each named end effector ends within 3 cm of the named place (a reach: of the point 2 cm
off the surface there), the support carries at least 20 N while the other hand reaches, the robot
does not fall, nothing else is hit, and nothing moves without a confirmation.

What is a hit stands in `hits`.
"""

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np

from w2c.messages import Array
from w2c_evaluation.demo.operator import REACH_STANDOFF_M
from w2c_evaluation.scenarios.eyewitness import Wanted
from w2c_evaluation.scenarios.hits import END_EFFECTORS, Robot, find_hits
from w2c_evaluation.scenarios.record import Motion, Played, Understood
from w2c_evaluation.scenarios.scenario import Prompt, Scenario
from w2c_evaluation.scenarios.truth_log import Sample

REACHED_M = 0.03
SUPPORT_N = 20.0
SUPPORT_PERCENTILE = 5.0
"""Of the force while reaching that must be SUPPORT_N: one sample is not a support that fails"""
LOWEST_BASE_M = 0.65
MOST_TILT_RAD = 1.2
"""Of the pelvis: a robot that leans far tilts it by 0.8"""
STILL_M = 0.03
"""A hand that moves farther before anything was confirmed moved by itself"""


@dataclass(frozen=True)
class Verdict:
    """What is wrong with a run; nothing = a success."""

    fell: bool
    unconfirmed_motions: int
    prompt_problems: tuple[tuple[str, ...], ...]
    """Of each prompt of the scenario"""
    hits: tuple[str, ...]
    place_errors_m: tuple[float, ...]
    """Between each confirmed target and the wanted place; NaN where none was confirmed"""
    hand_errors_m: tuple[float, ...]
    """Between each hand and where it should have come; NaN where none moved"""
    support_n: tuple[float, ...]
    """5th, 50th and 95th percentile while the other hand reached; empty without a reach"""

    @property
    def problems(self) -> tuple[str, ...]:
        """Return all of them, in words."""
        found = [text for texts in self.prompt_problems for text in texts]
        found += [f"hit: {text}" for text in self.hits]
        if self.fell:
            found.append("the robot fell")
        if self.unconfirmed_motions:
            found.append(f"{self.unconfirmed_motions} motions without a confirmation")
        return tuple(found)


def judge(
    scenario: Scenario,
    played: Played,
    samples: Sequence[Sample],
    robot: Robot,
) -> Verdict:
    """Judge one run.

    Args:
        scenario: What should have happened.
        played: What was said and done.
        samples: What was true meanwhile, in order.
        robot: What touched and where.
    """
    place_errors, hand_errors, problems = [], [], []
    for index, prompt in enumerate(scenario.prompts):
        run = played.prompts[index] if index < len(played.prompts) else None
        found: list[str] = []
        place_error = hand_error = float("nan")
        if run is not None and run.wanted is not None:
            target = _confirmed_point(run.turns)
            if target is not None:
                place_error = float(np.linalg.norm(target - run.wanted.point))
        if run is None or run.wanted is None or run.motion is None:
            found.append(run.problem if run and run.problem else f"'{prompt.text}' was not reached")
        else:
            hand_error = _hand_error(prompt, run.motion, run.wanted, samples, robot.hand_radius)
            found += _motion_problems(prompt, run.motion, hand_error)
        place_errors.append(place_error)
        hand_errors.append(hand_error)
        problems.append(found)
    support = _support_force(scenario, played, samples)
    if len(support) and support[0] < SUPPORT_N:
        problems[-1].append(
            f"the support carries {support[0]:.0f} N ({SUPPORT_PERCENTILE:.0f}th percentile) while "
            f"the other hand reaches, at least {SUPPORT_N:.0f}"
        )
    return Verdict(
        any(_is_down(sample) for sample in samples),
        count_unconfirmed(played, samples),
        tuple(tuple(texts) for texts in problems),
        find_hits(scenario, played, samples, robot),
        tuple(place_errors),
        tuple(hand_errors),
        support,
    )


def count_unconfirmed(played: Played, samples: Sequence[Sample]) -> int:
    """Return how many goals were taken that no confirmation asked for, and own motions before."""
    confirmed = [run.motion for run in played.prompts if run.motion is not None]
    strangers = set(played.goal_ids) - {motion.goal_id for motion in confirmed}
    first_ns = min((motion.confirmed_ns for motion in confirmed), default=np.inf)
    still = [sample.effectors[2:] for sample in samples if sample.stamp_ns < first_ns]
    moved = bool(still) and bool(
        np.linalg.norm(np.array(still) - still[0], axis=-1).max() > STILL_M
    )
    return len(strangers) + int(moved)


def _is_down(sample: Sample) -> bool:
    """Tell whether the trunk is too low or too far from upright."""
    x, y = sample.base[3], sample.base[4]
    upright = 1.0 - 2.0 * (x * x + y * y)  # the z component of the base's z axis
    return bool(sample.base[2] < LOWEST_BASE_M or upright < np.cos(MOST_TILT_RAD))


def _confirmed_point(turns: Sequence[Understood]) -> Array | None:
    """Return the point that was on the screen when the operator said yes (3,); None = never."""
    if not any(turn.kind in ("yes", "button") for turn in turns):
        return None
    points = [turn.point for turn in turns if turn.point is not None]
    return np.array(points[-1]) if points else None


def _hand_error(
    prompt: Prompt,
    motion: Motion,
    wanted: Wanted,
    samples: Sequence[Sample],
    hand_radius: tuple[float, float],
) -> float:
    """Return how far the hand that was named is from where it should be, when it has settled [m].

    A sphere touches with its surface; a reach stops REACH_STANDOFF_M off the surface: at an edge,
    off the one or the other that meet there.
    """
    effector = END_EFFECTORS.index(prompt.meaning.effector)
    radius = hand_radius[effector - 2] if effector >= 2 else 0.0
    away = radius + (REACH_STANDOFF_M if prompt.meaning.task == "reach" else 0.0)
    settled = [s for s in samples if motion.ended_ns <= s.stamp_ns <= motion.settled_ns]
    if not settled:
        return float("nan")
    positions = np.array([sample.effectors[effector] for sample in settled])
    normals = (wanted.normal, *wanted.faces)
    return min(
        float(np.median(np.linalg.norm(positions - wanted.point - away * normal, axis=1)))
        for normal in normals
    )


def _motion_problems(prompt: Prompt, motion: Motion, hand_error: float) -> list[str]:
    end = "loaded" if prompt.meaning.task == "contact" else "reached"
    if motion.state != end:
        why = f": {motion.reason}" if motion.reason else ""
        return [f"'{prompt.text}' ended as {motion.state or 'nothing'}{why}"]
    if not hand_error <= REACHED_M:
        return [
            f"the {prompt.meaning.effector.replace('_', ' ')} is {1e3 * hand_error:.0f} mm from "
            f"where it should be, at most {1e3 * REACHED_M:.0f}"
        ]
    return []


def _support_force(
    scenario: Scenario, played: Played, samples: Sequence[Sample]
) -> tuple[float, ...]:
    """Return percentiles of the support's force along its normal while the other hand reached."""
    supports = [
        (prompt, run)
        for prompt, run in zip(scenario.prompts, played.prompts, strict=False)
        if prompt.meaning.task == "contact" and run.motion is not None and run.wanted is not None
    ]
    reaches = [
        run.motion
        for prompt, run in zip(scenario.prompts, played.prompts, strict=False)
        if prompt.meaning.task == "reach" and run.motion is not None
    ]
    if not supports or not reaches:
        return ()
    prompt, run = supports[-1]
    effector = END_EFFECTORS.index(prompt.meaning.effector)
    normal = run.wanted.normal if run.wanted is not None else np.zeros(3)
    end_ns = max(reaches[-1].settled_ns, reaches[-1].ended_ns)
    forces = [
        float(s.forces[effector] @ normal)
        for s in samples
        if reaches[-1].confirmed_ns <= s.stamp_ns <= end_ns
    ]
    if not forces:
        return ()
    low, middle, high = np.percentile(forces, (SUPPORT_PERCENTILE, 50.0, 95.0)).tolist()
    return low, middle, high
