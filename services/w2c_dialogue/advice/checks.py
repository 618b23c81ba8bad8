"""What can be found out about a target, check by check."""

from collections.abc import Callable
from dataclasses import dataclass, field

from w2c.messages import Advice, AdviceCheck, Remark, Unchecked
from w2c_dialogue.advice.guard import Guard
from w2c_dialogue.advice.heat import hits
from w2c_dialogue.advice.remarks import (
    named_materials,
    reach_remark,
    seen_materials,
    surface_remarks,
    veto_remarks,
)
from w2c_dialogue.advice.veto import unknown_text
from w2c_dialogue.advice.watch import Watch
from w2c_dialogue.advice.wordlist import named_in
from w2c_dialogue.conversation import Shown
from w2c_dialogue.interfaces import Controller, LanguageModel
from w2c_dialogue.limbs import Limbs
from w2c_dialogue.outcome import goal_of


@dataclass
class Draft:
    """Advice in the making."""

    shown: Shown
    start_ns: int
    pending: list[AdviceCheck]
    remarks: list[Remark] = field(default_factory=list)
    unchecked: list[Unchecked] = field(default_factory=list)
    refusal: str = ""

    def skip(self, check: AdviceCheck, reason: str) -> None:
        """Note that a check could not be made."""
        self.unchecked.append(Unchecked(check=check, reason=reason))

    def as_message(self, now_ns: int) -> Advice:
        """Return what is known so far."""
        target = self.shown.target
        return Advice(
            stamp_ns=now_ns,
            target_id=target.target_id,
            frame_stamp_ns=target.frame_stamp_ns,
            remarks=list(self.remarks),
            unchecked=list(self.unchecked),
            pending=list(self.pending),
            refusal=self.refusal,
            seconds=(now_ns - self.start_ns) * 1e-9,
        )


class Checks:
    """What can be found out about a target. Each check adds to a draft; it may raise W2CError."""

    def __init__(
        self,
        guard: Guard,
        watch: Watch,
        limbs: Limbs,
        model: LanguageModel,
        controller: Controller,
        *,
        fragile: tuple[str, ...],
        share: float,
    ) -> None:
        self._guard = guard
        self._watch = watch
        self._limbs = limbs
        self._model = model
        self._controller = controller
        self._fragile = fragile
        self._share = share
        self.all: tuple[tuple[AdviceCheck, Callable[[Draft], None]], ...] = (
            ("veto", self._veto),
            ("material", self._material),
            ("surface", self._surface),
            ("reach", self._reach),
        )

    def _veto(self, draft: Draft) -> None:
        verdict = self._guard.verdict(draft.shown)
        draft.remarks += veto_remarks(verdict)
        if verdict.vetoed:
            draft.refusal = self._guard.refusal(verdict)
        if verdict.failure:
            # No refusal yet: Confirm looks again, and by then grounding may answer.
            draft.skip("veto", verdict.failure)
        elif verdict.unknown:
            draft.skip("veto", unknown_text(verdict.unknown))

    def _material(self, draft: Draft) -> None:
        named = named_in(draft.shown.named, self._fragile)
        draft.remarks += named_materials(named)
        if not self._fragile:
            return
        seen = self._watch.look(draft.shown.frame)
        found = hits(seen.of(self._fragile), self._guard.place(draft.shown), self._share)
        draft.remarks += seen_materials([hit for hit in found if hit.phrase not in named])
        unknown = tuple(phrase for phrase in self._fragile if phrase in seen.unknown)
        if unknown:
            draft.skip("material", unknown_text(unknown))

    def _surface(self, draft: Draft) -> None:
        limb, task, _ = self._limbs.choose(draft.shown, self._model)
        if task == "reach":
            return  # what is only touched need not carry anything
        lifted = draft.shown.lifted
        if limb not in ("left_hand", "right_hand"):
            draft.skip("surface", "judged for hands only, and this is for a foot")
        elif lifted is None or not lifted.verdicts:
            draft.skip("surface", "perception has not judged it: there is no depth")
        else:
            draft.remarks += surface_remarks(lifted.verdicts)

    def _reach(self, draft: Draft) -> None:
        limb, task, _ = self._limbs.choose(draft.shown, self._model)
        preview = self._controller.preview(goal_of("advice", draft.shown.target, limb, task))
        draft.remarks.append(reach_remark(limb, task, preview))
