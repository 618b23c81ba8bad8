"""The veto list at the door: asked for the advice, and once more before anything moves."""

from w2c.errors import CallError, NotNowError, RefusedError
from w2c.messages import AllowedArea, Array
from w2c_dialogue.advice.heat import Place, hits
from w2c_dialogue.advice.mask import with_veto
from w2c_dialogue.advice.veto import UncheckedVeto, Verdict
from w2c_dialogue.advice.watch import Watch
from w2c_dialogue.advice.wordlist import named_in
from w2c_dialogue.conversation import Shown
from w2c_dialogue.frames import DEFAULT_PIXELS_PER_CM, pixels_per_cm
from w2c_dialogue.interfaces import Frame


class Guard:
    """Refuses targets on what must not be touched. Thread-safe."""

    def __init__(
        self,
        watch: Watch,
        phrases: tuple[str, ...],
        *,
        share: float,
        margin: float,
        unchecked: UncheckedVeto,
    ) -> None:
        """Prepare.

        Args:
            watch: Looks at pictures.
            phrases: What must not be touched; empty: anything may.
            share: Of a phrase's highest heat in the picture, from which on it is at a place.
            margin: Around the target that is looked at [m].
            unchecked: What follows where the picture cannot be looked at.
        """
        self._watch = watch
        self._phrases = phrases
        self._share = share
        self._margin = margin
        self._unchecked: UncheckedVeto = unchecked

    def verdict(self, shown: Shown) -> Verdict:
        """Return what the veto list says of a target.

        Waits for grounding as long as `Watch` does, or takes its answer from memory.
        """
        return self.verdict_at(shown.frame, self.place(shown), shown.named)

    def verdict_at(self, frame: Frame, place: Place, said: str = "") -> Verdict:
        """Return what the veto list says of a place in a picture.

        Args:
            frame: The picture.
            place: Where.
            said: What the operator called the place; "" = nothing.
        """
        if not self._phrases:
            return Verdict()
        named = next(iter(named_in(said, self._phrases)), "")
        try:
            seen = self._watch.look(frame)
        except CallError as error:
            return Verdict(named=named, failure=str(error), retryable=error.retryable)
        found = hits(seen.of(self._phrases), place, self._share)
        unknown = tuple(phrase for phrase in self._phrases if phrase in seen.unknown)
        return Verdict(found, named, unknown)

    def without_picture(self, reason: str) -> Verdict:
        """Return the verdict on a place of which there is no picture, for a reason."""
        return Verdict(failure=reason) if self._phrases else Verdict()

    def refusal(self, verdict: Verdict) -> str:
        """Return why a target of this verdict cannot be confirmed; "" = it can."""
        return verdict.refusal(self._unchecked)

    def check(self, shown: Shown) -> str:
        """Return what the operator should know of the check; "" = nothing.

        Raises:
            RefusedError: the target must not be touched.
            NotNowError: nobody could look whether it may, just now.
        """
        verdict = self.verdict(shown)
        refusal = self.refusal(verdict)
        if refusal:
            raise NotNowError(refusal) if verdict.retryable else RefusedError(refusal)
        if verdict.failure:
            return f" I did not look for what I must not touch: {verdict.failure}."
        return ""

    def forbid(self, area: AllowedArea, frame: Frame) -> AllowedArea:
        """Return an area without what must not be touched, with the margin around it.

        The margin is taken at the usual scale of a picture: depth differs over the area.

        Raises:
            CallError: grounding cannot look.
        """
        if not self._phrases:
            return area
        seen = self._watch.look(frame).of(self._phrases)
        return with_veto(area, seen, self._share, 100.0 * self._margin * DEFAULT_PIXELS_PER_CM)

    def place(self, shown: Shown) -> Place:
        """Return what is looked at around a target."""
        target = shown.target
        return self.place_at(shown.frame, (target.u, target.v), target.point)

    def place_at(self, frame: Frame, pixel: tuple[float, float], point: Array | None) -> Place:
        """Return what is looked at around a pixel of a picture.

        Args:
            frame: The picture.
            pixel: Where in it.
            point: (3,) of the world that it shows [m]; None: not known.
        """
        scale = pixels_per_cm(point, frame.view)
        return Place(*pixel, 100.0 * self._margin * scale, frame.width, frame.height)
