"""What is drawn over a picture: target, boxes and heat of what was found."""

from dataclasses import dataclass

from w2c import messages as m
from w2c_recorder.history import History

Pixel = tuple[float, float]


@dataclass(frozen=True)
class Overlay:
    """Marks in pixels of the picture, (u right, v down)."""

    point: Pixel | None = None
    label: str = ""
    """Of the point, or why there is none"""
    boxes: tuple[tuple[m.Box, str], ...] = ()
    """Box and what it is of"""
    heat: tuple[m.Array, ...] = ()
    """(h, w) uint8 each, 255 = certain; each covers the whole picture"""


def overlay_of(history: History, target: m.Target) -> Overlay:
    """Return what belongs to a target, in the picture that it was chosen in."""
    proposal = history.proposal_of(target.target_id)
    first = (
        target if proposal is None or proposal.message.target is None else (proposal.message.target)
    )
    evidence = history.evidence_of(first)
    heat: tuple[m.Array, ...] = ()
    if evidence is not None and isinstance(evidence.reply, m.GroundingReply):
        heat = tuple(
            one.heatmap
            for one in evidence.reply.evidence
            if one.heatmap is not None and one.phrase in first.phrases
        )
    phrases = [*first.phrases, *[""] * len(first.boxes)]
    return Overlay(
        point=(target.u, target.v),
        label=f"{target.target_id}, {target.state}",
        boxes=tuple(zip(first.boxes, phrases, strict=False)),
        heat=heat,
    )
