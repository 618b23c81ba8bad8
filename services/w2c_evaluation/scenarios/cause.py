"""Why a run failed: words, vision, geometry or control.

Taken from the first prompt that failed. Where its target was not confirmed, or was confirmed
farther from the wanted place than what counts as reached, the first turn that was answered wrongly
decides; in each turn, in this order:

system    what asks for something was refused before a model heard it: no picture, a lost link.
words     the turn went to another module than it was meant for; other things, another hand or task
          were heard; the point is not on the side that was said; a correction moved the point by
          more than 10 px and half of its length from where its words say.
vision    the box of a phrase overlaps the true one by less than half (intersection over union), a
          thing in sight was not found, or the point lies beside the thing that it shall be on.
geometry  perception's point is more than 15 mm from what is truly behind the pixel, or there is
          none.

Where every turn was answered rightly and the operator gave up all the same, it is `operator`. A
target that was confirmed at the right place and was refused or not reached is `control`, unless a
wrong hand or task was heard. `scene`: the place was hidden. A process that failed is `system`, too.
"""

from math import hypot

from w2c_evaluation.scenarios.phrase_book import normal
from w2c_evaluation.scenarios.record import Cause, PromptRun, Understood
from w2c_evaluation.scenarios.scenario import Meaning, Prompt, Side

OVERLAP_LEAST = 0.5
LIFT_ERROR_MOST_M = 0.015
SLACK_PX = 10.0
SLACK_SHARE = 0.5

Edges = tuple[float, float, float, float]


def find_cause(prompt: Prompt, run: PromptRun, *, right_place: bool) -> Cause:
    """Return why a prompt failed.

    Args:
        prompt: What was said.
        run: What came of it.
        right_place: Whether the confirmed target is where it was wanted.
    """
    if run.wanted is None:
        return "scene"
    if right_place:
        meant = (prompt.meaning.effector, prompt.meaning.task)
        moved = run.motion
        as_meant = moved is None or (moved.effector, moved.task) == meant
        return "control" if as_meant else "words"
    found = (cause_of_turn(turn, prompt.meaning) for turn in run.turns)
    return next((cause for cause in found if cause is not None), "operator")


def cause_of_turn(turn: Understood, meaning: Meaning) -> Cause | None:
    """Return what of a turn was answered wrongly, whether it mattered or not; None = nothing.

    A question that could be answered is no wrong answer; what comes of it is judged.
    """
    if turn.asks == "answered":
        return None
    if turn.kind in ("prompt", "correction") and not turn.ok and not turn.asked:
        return "system"
    if words_are_wrong(turn, meaning):
        return "words"
    if vision_is_wrong(turn, meaning):
        return "vision"
    return "geometry" if geometry_is_wrong(turn) else None


def words_are_wrong(turn: Understood, meaning: Meaning) -> bool:
    """Tell whether the language model mistook a turn. A refused one is judged by its module."""
    if turn.kind == "button":
        return False
    if turn.kind == "yes":
        return turn.module not in ("confirmation", "none") or "Did you mean yes" in turn.reply
    if turn.kind == "correction":
        return turn.module != "correction" or _moved_wrongly(turn)
    return _misheard(turn, meaning)


def vision_is_wrong(turn: Understood, meaning: Meaning) -> bool:
    """Tell whether the things of a prompt were not found, or not where they are."""
    if turn.kind != "prompt":
        return False
    if not turn.phrases:
        return not turn.ok
    pairs = zip(turn.boxes, turn.true_boxes, strict=False)
    if any(true is None or overlap(seen, true) < OVERLAP_LEAST for seen, true in pairs):
        return True
    return meaning.position == "absolute" and turn.true_owner not in meaning.things.values()


def geometry_is_wrong(turn: Understood) -> bool:
    """Tell whether perception gave no point, or another than the true one."""
    if turn.pixel is None or turn.true_point is None:
        return False
    if turn.point is None:
        return True
    difference = [a - b for a, b in zip(turn.point, turn.true_point, strict=True)]
    return hypot(*difference) > LIFT_ERROR_MOST_M


def overlap(one: Edges, other: Edges) -> float:
    """Return intersection over union of two boxes."""
    across = max(0.0, min(one[2], other[2]) - max(one[0], other[0]))
    along = max(0.0, min(one[3], other[3]) - max(one[1], other[1]))
    common = across * along
    areas = [(box[2] - box[0]) * (box[3] - box[1]) for box in (one, other)]
    union = sum(areas) - common
    return common / union if union > 0.0 else 0.0


def _lower(meaning: Meaning) -> list[str]:
    return [words.lower() for words in meaning.things]


def _misheard(turn: Understood, meaning: Meaning) -> bool:
    if not turn.phrases:
        # Nothing was shown: the reply names what was looked for, if anything was heard.
        return not any(f"'{words}'" in turn.reply.lower() for words in _lower(meaning))
    if turn.module != f"prediction.{meaning.position}":
        return True
    if [normal(phrase) for phrase in turn.phrases] != [normal(w) for w in meaning.things]:
        return True
    return meaning.side is not None and not _on_side(turn, meaning.side)


def _moved_wrongly(turn: Understood) -> bool:
    if turn.pixel is None or turn.before is None or turn.meant is None:
        return not turn.ok
    off = hypot(
        turn.pixel[0] - turn.before[0] - turn.meant[0],
        turn.pixel[1] - turn.before[1] - turn.meant[1],
    )
    return off > max(SLACK_PX, SLACK_SHARE * hypot(*turn.meant))


def _on_side(turn: Understood, side: Side) -> bool:
    """Tell whether the point is beyond the box on this side, as the picture shows it."""
    if not turn.boxes or turn.pixel is None:
        return False
    left, top, right, bottom = turn.boxes[0]
    u, v = turn.pixel
    return {"left": u <= left, "right": u >= right, "behind": v <= top, "front": v >= bottom}[side]
