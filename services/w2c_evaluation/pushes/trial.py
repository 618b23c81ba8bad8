"""One push: approach, touch, load, hold; what the surface truly feels is written down."""

from dataclasses import dataclass, field, replace
from typing import Any, Final

import numpy as np

from w2c.library import library
from w2c.messages import Array, EndEffector, PlaceGoal
from w2c_evaluation.closed_loop import ClosedLoop
from w2c_evaluation.pushes.cases import (
    BACK,
    TABLE_HEIGHT,
    UP,
    WALL_DISTANCE,
    PushCase,
    PushResult,
)

HAND: Final[EndEffector] = "right_hand"
HAND_INDEX: Final = 3
SAMPLE_TICKS: Final = 10
"""20 ms between two samples."""
STAND_S = 3.0
APPROACH_S = 60.0
HOLD_S = 12.0
REACH_S = 60.0
SETTLED_S = 2.0
"""At the end, for the steady state."""
UNLOADED_S = 5.0
"""Before the controller gave up loading: its errors count where it did."""
NOMINAL_FRICTION = 0.8
FAR = (1.4, 0.15, 0.95)
"""Out of reach, whatever the other hand does [m]."""
FAILURES = ("slip", "overload", "lost")
"""Words of reports on a contact. A hand that sticks again after a slip may be overloaded."""
SLIDING = 0.02
"""A ball whose point of contact is faster than this on average slips; one that rolls does not
[m/s]."""
SLIDING_SAMPLES = 5
"""Of the average: 0.1 s."""
SLIP_SAMPLES = 25
"""In which a slip must come that far: 0.5 s."""
LEAST_SLIP = 0.0025
"""What stops before is a jerk, and is not told [m]."""
CREEPING = 8e-4
"""What is faster on average creeps; contacts of the simulator are soft, and creep with half of it
where they hold [m/s]."""
CREEP_SAMPLES = 50
"""Of that average: 1 s."""
LEAST_CREEP = 0.004
"""What creeps less far without a report is none [m]."""
CARRIES = 25.0
"""All through this time; a hand hops about at the touch [N]."""


@dataclass
class Record:
    """Samples since the touch."""

    times: list[float] = field(default_factory=list)
    wanted: list[float] = field(default_factory=list)
    measured: list[float] = field(default_factory=list)
    sliding: list[Array] = field(default_factory=list)
    """Velocity of the point of the ball that touches, along the surface (3,) [m/s]"""


def run_push(case: PushCase, trial: int, seed: int) -> PushResult:
    """Run a case at a random place of its surface, the same for all cases of a trial."""
    return Push(case, trial, seed).run()


class Push:
    """The experiment, with its robot and controller."""

    def __init__(self, case: PushCase, trial: int, seed: int) -> None:
        self._case = case
        self._trial = trial
        rng = np.random.default_rng((seed, trial))
        self._normal, self._point, block = _surface(case, rng)
        description = library("make_description")(lock_step=True)
        perturbation = library("perturbation")(
            stiffness=case.stiffness,
            ball_friction=case.friction / NOMINAL_FRICTION,
            sole_pitch=(0.0, float(np.radians(case.sole_pitch_deg))),
        )
        self._robot = library("study_robot")(perturbation, (block,), description=description)
        self._radius = description.hand_radius[HAND_INDEX - 2]
        self._controller = library("controller")(description, _parameters(case))
        self._loop = ClosedLoop(self._robot, self._controller)
        self._period_s = description.period_ns * 1e-9
        self._record = Record()
        self._told_s = -1.0
        self._answer = ""

    def run(self) -> PushResult:
        """Run it to its end, or to a fall."""
        self._wait(STAND_S)
        goal = PlaceGoal(
            goal_id="push",
            end_effector=HAND,
            task="contact",
            point=self._point,
            normal=self._normal,
            force=self._case.force,
        )
        refusal = self._loop.ask(goal)
        outcome = refusal or self._wait(APPROACH_S, "loaded", "aborted", "unreachable")
        begin = len(self._record.times)
        if outcome and not refusal:
            if self._case.reach:
                self._reach()
            self._wait(HOLD_S)
        return self._result(outcome, begin)

    def _reach(self) -> None:
        far = PlaceGoal(
            goal_id="reach",
            end_effector="left_hand",
            task="reach",
            point=np.array(FAR),
            normal=np.array(UP),
        )
        self._answer = self._loop.ask(far)
        self._wait(REACH_S, "reached", "unreachable", "aborted")

    def _wait(self, seconds: float, *states: str) -> str:
        if self._robot.fell:
            return "fell"
        return self._loop.run(round(seconds / self._period_s), until=states, watch=self._sample)

    def _sample(self) -> bool:
        """Note what the surface feels, and when the controller says that the contact fails."""
        time = self._robot.tick * self._period_s
        for event in self._loop.events[-2:]:
            fails = event.state == "aborted" and any(word in event.reason for word in FAILURES)
            if self._told_s < 0.0 and fails:
                self._told_s, self._answer = time, f"{event.state}: {event.reason}"
        if self._robot.tick % SAMPLE_TICKS == 0:
            truth = self._robot.truth()
            force = float(truth.contact_forces[HAND_INDEX] @ self._normal)
            if force > 0.0 or self._record.times:
                desired = self._controller.retargeting.state
                self._record.times.append(time)
                self._record.measured.append(force)
                self._record.wanted.append(float(desired.wrenches[HAND_INDEX, 2]))
                point = -self._radius * self._normal
                velocity = self._robot.point_velocity(HAND_INDEX, point)
                self._record.sliding.append(velocity - (velocity @ self._normal) * self._normal)
        return bool(self._robot.fell)

    def _result(self, outcome: str, begin: int) -> PushResult:
        case, record = self._case, self._record
        before = round(UNLOADED_S / (SAMPLE_TICKS * self._period_s))
        window = slice(begin, None) if outcome == "loaded" else slice(max(begin - before, 0), begin)
        measured = np.array(record.measured[window])
        wanted = np.array(record.wanted[window]) if case.force == 0.0 else case.force
        errors = measured - wanted
        settled = round(SETTLED_S / (SAMPLE_TICKS * self._period_s))
        slip, slip_seconds = self._slip(begin)
        creep_seconds = self._creep(begin)
        start = record.times[0] if record.times else 0.0
        events = [f"{event.state} {event.reason}".strip() for event in self._loop.events]
        return PushResult(
            case=case,
            trial=self._trial,
            fell=bool(self._robot.fell),
            loaded=outcome == "loaded",
            mean_abs_error=float(np.abs(errors).mean()) if errors.size else float("nan"),
            rms_error=float(np.sqrt((errors**2).mean())) if errors.size else float("nan"),
            steady_error=float(errors[-settled:].mean()) if errors.size else float("nan"),
            slip=slip,
            slip_seconds=slip_seconds,
            creep_seconds=creep_seconds,
            answer=self._answer,
            detail="; ".join(events[-3:]) or outcome,
            times=[round(time - start, 3) for time in record.times],
            wanted=[round(value, 2) for value in record.wanted],
            measured=[round(value, 2) for value in record.measured],
        )

    def _slip(self, begin: int) -> tuple[float, float]:
        """Return how far the hand slipped [m], and how long that went unnoticed [s]."""
        velocities = np.array(self._record.sliding[begin:])
        if len(velocities) < SLIDING_SAMPLES:
            return 0.0, -1.0
        forces = np.array(self._record.measured[begin:])
        carries = carried(forces)[:, np.newaxis]
        sample_s = SAMPLE_TICKS * self._period_s
        ways = sample_s * velocities * carries
        farthest = float(np.linalg.norm(ways.cumsum(axis=0), axis=1).max())
        sliding = first_slip(velocities, forces, sample_s)
        if sliding < 0:
            return farthest, -1.0
        if self._told_s < 0.0:
            return farthest, -2.0
        began = self._record.times[begin + sliding]
        return farthest, max(self._told_s - began, 0.0)

    def _creep(self, begin: int) -> float:
        """Return how long a slow slide went on before its report [s]; -1: none, -2: no report.

        It began where the hand was at rest last.
        """
        velocities = np.array(self._record.sliding[begin:])
        if len(velocities) < CREEP_SAMPLES:
            return -1.0
        times, sample_s = self._record.times[begin:], SAMPLE_TICKS * self._period_s
        slides = slow_slides(velocities, np.array(self._record.measured[begin:]))
        if self._told_s < 0.0:
            ways = [
                float(np.linalg.norm(sample_s * velocities[first : last + 1].sum(axis=0)))
                for first, last in slides
            ]
            return -2.0 if max(ways, default=0.0) > LEAST_CREEP else -1.0
        for first, last in slides:
            if times[first] <= self._told_s <= times[last] + sample_s:
                return float(self._told_s - times[first])
        return -1.0


def slow_slides(velocities: Array, forces: Array) -> list[tuple[int, int]]:
    """Return the first and the last sample of each slide that went on for a second or longer.

    Args:
        velocities: (n, 3) of the point that touches, along the surface [m/s].
        forces: (n,) along the normal [N].
    """
    windows = np.lib.stride_tricks.sliding_window_view
    speeds = np.linalg.norm(windows(velocities, CREEP_SAMPLES, axis=0).mean(axis=-1), axis=1)
    creeps = (speeds > CREEPING) & (windows(forces, CREEP_SAMPLES).min(axis=1) > CARRIES)
    edges = np.flatnonzero(np.diff(np.concatenate([[0], creeps.astype(np.int8), [0]])))
    return [
        (int(first), int(end) + CREEP_SAMPLES - 2) for first, end in edges.reshape(-1, 2).tolist()
    ]


def first_slip(velocities: Array, forces: Array, period_s: float) -> int:
    """Return the sample at which a slip began, or -1.

    Args:
        velocities: (n, 3) of the point that touches, along the surface [m/s].
        forces: (n,) along the normal [N].
        period_s: Between two samples.
    """
    for last in np.flatnonzero(carried(forces)):
        first = int(last) - SLIDING_SAMPLES + 1
        mean = velocities[first : last + 1].mean(axis=0)
        if np.linalg.norm(mean) <= SLIDING:
            continue
        way = period_s * velocities[first : first + SLIP_SAMPLES].cumsum(axis=0)
        if np.linalg.norm(way, axis=1).max() > LEAST_SLIP:
            return first
    return -1


def carried(forces: Array) -> Array:
    """Return (n,) booleans: whether the hand carried weight all through the last 0.1 s."""
    least = np.lib.stride_tricks.sliding_window_view(forces, SLIDING_SAMPLES).min(axis=1)
    return np.concatenate([np.zeros(SLIDING_SAMPLES - 1, dtype=np.bool_), least > CARRIES])


def _surface(case: PushCase, rng: np.random.Generator) -> tuple[Array, Array, Any]:
    """Return the normal, the point that the goal names, and the block that is truly there."""
    block = library("block")
    if case.surface == "table":
        x, y = float(rng.uniform(0.45, 0.52)), float(rng.uniform(-0.32, -0.22))
        top = TABLE_HEIGHT + case.surface_error
        there = block(centre=(0.70, -0.25, top - 0.4), half_size=(0.30, 0.40, 0.40))
        return np.array(UP), np.array([x, y, TABLE_HEIGHT]), there
    y, z = float(rng.uniform(-0.35, -0.25)), float(rng.uniform(1.05, 1.20))
    face = WALL_DISTANCE - case.surface_error
    there = block(centre=(face + 0.05, 0.0, 1.0), half_size=(0.05, 1.0, 1.0))
    return np.array(BACK), np.array([WALL_DISTANCE, y, z]), there


def _parameters(case: PushCase) -> Any:
    """Return the controller's own parameters, with what the case says of them."""
    own = library("controller_parameters")()
    limits = own.limits
    if case.assumed_friction is not None:
        limits = replace(limits, friction=case.assumed_friction)
    force_control = replace(own.force_control, mode=case.force_control)
    return replace(own, limits=limits, force_control=force_control)
