"""Masked pointing: of all points on a thing, one where a hand may go and gets to."""

from collections.abc import Callable
from dataclasses import dataclass

from w2c.clock import Clock
from w2c.errors import CallError, RefusedError, W2CError
from w2c.messages import AllowedArea, EndEffector, PhraseEvidence, PlaceGoal, Task
from w2c_dialogue import effector
from w2c_dialogue.advice.guard import Guard
from w2c_dialogue.advice.mask import Candidate, candidates, why_not
from w2c_dialogue.interfaces import Frame
from w2c_dialogue.limbs import Limbs
from w2c_dialogue.steps import Services

TRIED = 6
"""Points that are tried for reach: each takes 10 ms of perception and 5 ms of a preview"""


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
        try:
            area = services.allowed(frame.stamp_ns)
            area = self._guard.forbid(area, frame)
        except CallError as error:
            return Pointed(None, f"I could not see where a hand may go ({error}).")
        self._publish(area)
        found = candidates(seen, area, TRIED)
        if not found:
            return Pointed(
                None,
                f"Nothing on '{seen.phrase}' is allowed: {why_not(seen, area)}. This is the point "
                "I would take without that; confirm it only if you mean it.",
            )
        return self._first_reachable(found, seen.phrase, frame, instruction, services)

    def _first_reachable(
        self,
        found: list[Candidate],
        phrase: str,
        frame: Frame,
        instruction: str,
        services: Services,
    ) -> Pointed:
        start_ns = self._clock.now_ns()
        best = found[0].pixel
        try:
            limb, task = self._limbs.hear(instruction, services)
            reason = ""
            for candidate in found:
                late = (self._clock.now_ns() - start_ns) * 1e-9 > self._budget_s
                if late and candidate is not found[0]:
                    return Pointed(best, "I ran out of time to find a point within reach.")
                reason = self._obstacle(candidate, frame, limb, task, services)
                if not reason:
                    return Pointed(candidate.pixel)
        except W2CError as error:
            return Pointed(best, f"I could not find out whether I get there ({error}).")
        return Pointed(
            None,
            f"Nothing that is allowed on '{phrase}' is within reach: {reason}. This is the point "
            "I would take without that; confirm it only if you mean it.",
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
            lifted = services.lift(*candidate.pixel, frame.stamp_ns)
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
