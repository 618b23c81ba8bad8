"""What was found out about a target, in sentences with their numbers."""

from collections.abc import Sequence

from w2c.messages import EndEffector, FitnessVerdict, PreviewReply, Remark, Task
from w2c_dialogue.advice.heat import Hit
from w2c_dialogue.advice.veto import Verdict
from w2c_dialogue.advice.wordlist import fragility

WORDS = "operator"
"""Source of a remark that comes from the operator's own words"""


def veto_remarks(verdict: Verdict) -> list[Remark]:
    """Return why a target is on the veto list, or nothing."""
    if not verdict.vetoed:
        return []
    hit = None if verdict.named else verdict.hits[0]
    return [
        Remark(
            kind="veto",
            level="veto",
            text=verdict.refusal("refuse"),
            source="grounding" if hit else WORDS,
            value=hit.heat if hit else None,
            limit=hit.limit if hit else None,
        )
    ]


def named_materials(named: Sequence[str]) -> list[Remark]:
    """Return why what the operator's own words name as the place may not bear a hand."""
    return [
        Remark(kind="material", level="caution", text=fragility(phrase), source=WORDS)
        for phrase in named
    ]


def seen_materials(seen: Sequence[Hit]) -> list[Remark]:
    """Return why what the picture shows at the place may not bear a hand."""
    return [
        Remark(
            kind="material",
            level="caution",
            text=f"looks like {fragility(hit.phrase)}",
            source="grounding",
            value=hit.heat,
            limit=hit.limit,
        )
        for hit in seen
    ]


def surface_remarks(verdicts: Sequence[FitnessVerdict]) -> list[Remark]:
    """Return why the shape of a surface does not carry a hand, or one remark that it does."""
    unfit = [
        Remark(
            kind="surface",
            level="caution",
            text=verdict.reason,
            source="perception",
            value=verdict.value,
            limit=verdict.limit,
            unit="rad" if verdict.check == "slope" else "m",
        )
        for verdict in verdicts
        if not verdict.fit
    ]
    if unfit or not verdicts:
        return unfit
    text = "by its shape the surface can carry a hand"
    return [Remark(kind="surface", level="fine", text=text, source="perception")]


def reach_remark(limb: EndEffector, task: Task, preview: PreviewReply) -> Remark:
    """Return whether a limb gets to a target and can lean there, and what to beware of."""
    name = limb.replace("_", " ")
    does = "lean" if task == "contact" else "reach"
    known = preview.distance >= 0.0
    if preview.reachable:
        text = f"my {name} can {does} there from here"
        if preview.reason:
            text += f", but {preview.reason}"
    else:
        text = f"my {name} cannot {does} there from here: {preview.reason}"
    return Remark(
        kind="reach",
        level="fine" if preview.reachable and not preview.reason else "caution",
        text=text,
        source="controller",
        value=preview.distance if known else None,
        unit="m" if known else "",
    )
