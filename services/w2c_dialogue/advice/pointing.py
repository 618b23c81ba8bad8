"""Masked pointing: of all points on a thing, one where a hand may go and gets to."""

from collections.abc import Callable
from dataclasses import dataclass

import numpy as np

from w2c.clock import Clock
from w2c.errors import CallError, ModelError, RefusedError
from w2c.messages import AllowedArea, EndEffector, PhraseEvidence, PlaceGoal, Task
from w2c_dialogue import effector
from w2c_dialogue.advice.guard import Guard
from w2c_dialogue.advice.mask import Candidate, candidates, why_not
from w2c_dialogue.interfaces import Frame
from w2c_dialogue.limbs import Limbs
from w2c_dialogue.steps import Services

TRIED = 6
"""Points that are tried for reach: each takes 10 ms of perception and 5 ms of a preview"""

CELL = 8
"""Side of a cell where the whole picture is allowed [px]"""
_UNMASKED = "This is the point I would take without that; confirm it only if you mean it."


@dataclass(frozen=True)
class Pointed:
    """Where masked pointing points."""

    pixel: tuple[float, float] | None
    """None: it has nothing to say; the point of the heatmap stays"""
    warning: str = ""
    """For the operator"""


class MaskedPointing:
    """Chooses points. What it cannot find out in time is said, and not held against a point."""

    def __init__(
        self,
        guard: Guard,
        limbs: Limbs,
        publish: Callable[[AllowedArea], None],
        clock: Clock,
        *,
        budget_s: float,
    ) -> None:
        """Prepare.

        Args:
            guard: Knows what must not be touched.
            limbs: Knows which limb an instruction means.
            publish: Shows the allowed area to the operator.
            clock: Of this process.
            budget_s: After so long no second, third ... point is tried [s].
        """
        self._guard = guard
        self._limbs = limbs
        self._publish = publish
        self._clock = clock
        self._budget_s = budget_s

    def point(
        self, seen: PhraseEvidence, frame: Frame, instruction: str, services: Services
    ) -> Pointed:
        """Return where on a thing that was found a hand may go."""
        problem = ""
        limb: EndEffector | None = None
        task: Task = "contact"
        try:
            limb, task = self._limbs.hear(instruction, services)
        except (CallError, ModelError) as error:
            problem = str(error)
        try:
            area = self._area(frame, task, services)
        except CallError as error:
            return Pointed(None, f"I could not see where a hand may go ({error}).")
        found = candidates(seen, area, TRIED)
        if not found:
            return Pointed(
                None,
                f"Nothing on '{seen.phrase}' is allowed: {why_not(seen, area)}. {_UNMASKED}",
            )
        if problem:
            return Pointed(found[0].pixel, f"I could not find out whether I get there ({problem}).")
        return self._first_reachable(found, seen.phrase, frame, (limb, task), services)

    def _area(self, frame: Frame, task: Task, services: Services) -> AllowedArea:
        """Return where a hand may go, for leaning also shown to the operator. Raises CallError."""
        if task == "contact":
            area = self._guard.forbid(services.allowed(frame), frame)
            self._publish(area)
            return area
        # What is only touched need be neither flat nor large: a cup is neither.
        anywhere = AllowedArea(
            stamp_ns=frame.stamp_ns,
            width=frame.width,
            height=frame.height,
            cells=np.zeros((-(-frame.height // CELL), -(-frame.width // CELL)), np.uint8),
            reasons=[],
        )
        return self._guard.forbid(anywhere, frame)

    def _first_reachable(
        self,
        found: list[Candidate],
        phrase: str,
        frame: Frame,
        heard: tuple[EndEffector | None, Task],
        services: Services,
    ) -> Pointed:
        start_ns = self._clock.now_ns()
        best = found[0].pixel
        reason = ""
        try:
            for candidate in found:
                if (self._clock.now_ns() - start_ns) * 1e-9 > self._budget_s:
                    return Pointed(best, "I ran out of time to find a point within reach.")
                reason = self._obstacle(candidate, frame, *heard, services)
                if not reason:
                    return Pointed(candidate.pixel)
        except CallError as error:
            return Pointed(best, f"I could not find out whether I get there ({error}).")
        return Pointed(
            None, f"Nothing that is allowed on '{phrase}' is within reach: {reason}. {_UNMASKED}"
        )

    def _obstacle(
        self,
        candidate: Candidate,
        frame: Frame,
        limb: EndEffector | None,
        task: Task,
        services: Services,
    ) -> str:
        """Return why a limb does not get to a point; "" = it does. Raises CallError."""
        try:
            lifted = services.lift(*candidate.pixel, frame)
        except RefusedError as error:
            return str(error)
        chosen = limb or effector.nearest_hand(lifted.point)
        try:
            goal = PlaceGoal(
                goal_id="pointing",
                end_effector=chosen,
                task=effector.task_of(chosen, task),
                point=lifted.point,
                normal=lifted.normal,
            )
        except ValueError as error:
            raise RefusedError(f"no goal of that point: {error}") from error
        preview = services.preview(goal)
        return "" if preview.reachable else preview.reason
