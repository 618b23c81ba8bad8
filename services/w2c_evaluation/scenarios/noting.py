"""A turn of the conversation, written down beside what was true in its picture."""

from dataclasses import dataclass

from w2c.messages import Array, Box, Target, Turn
from w2c_evaluation.scenarios.phrase_book import PhraseBook
from w2c_evaluation.scenarios.record import Asks, Kind, Point3, Understood
from w2c_evaluation.scenarios.sight import Pixel
from w2c_evaluation.scenarios.true_boxes import see
from w2c_evaluation.scenarios.truth_log import TruthLog

Edges = tuple[float, float, float, float]
"""Left, top, right, bottom [px]"""


@dataclass(frozen=True)
class Said:
    """What the operator said or did, for what comes of it."""

    kind: Kind
    before: Target | None = None
    """Shown when it was said"""
    meant: Pixel | None = None
    """The move that the words of a correction ask for (du, dv) [px]"""


def note(
    turn: Turn, said: Said, log: TruthLog, book: PhraseBook, asks: Asks = "", *, answers: bool
) -> Understood:
    """Return a turn beside what is true in its picture.

    Args:
        turn: What was understood.
        said: What was said.
        log: Of what is true.
        book: Which objects phrases mean.
        asks: Whether the reply is a question, and whether it could be answered.
        answers: Whether what was said answers a question.
    """
    target, before = turn.target, said.before
    owner, true_point = "", None
    true_boxes: list[Edges | None] = []
    if target is not None:
        with log.moment(target.frame_stamp_ns) as witness:
            surface = witness.surface(target.u, target.v)
            if surface is not None:
                owner, true_point = surface.owner, _point(surface.point)
            for phrase in target.phrases if said.kind == "prompt" else ():
                names = book.find(phrase)
                seen = see(witness, names[0]) if names else None
                true_boxes.append(None if seen is None else _edges(seen.box()))
    return Understood(
        text=turn.text,
        kind=said.kind,
        module=turn.module,
        ok=turn.ok,
        reply=turn.reply,
        seconds=turn.seconds,
        asks=asks,
        asked=turn.evidence is not None,
        answers=answers,
        pixel=None if target is None else (target.u, target.v),
        before=None if before is None else (before.u, before.v),
        meant=said.meant,
        phrases=() if target is None else tuple(target.phrases),
        boxes=() if target is None else tuple(_edges(box) for box in target.boxes),
        true_boxes=tuple(true_boxes),
        point=None if target is None or target.point is None else _point(target.point),
        true_point=true_point,
        true_owner=owner,
        effector=turn.end_effector,
        task=turn.task,
        goal_id=turn.goal_id,
    )


def _point(point: Array) -> Point3:
    x, y, z = point.tolist()
    return x, y, z


def _edges(box: Box) -> Edges:
    return box.left, box.top, box.right, box.bottom
