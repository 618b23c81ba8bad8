"""Conversations as data: the lines that `w2c train language --with` reads, and all that is known.

The training lines hold what a person agreed to and nothing else: only of a conversation that ended
with a yes is it known that the words were understood.
"""

import json
from collections.abc import Callable, Iterator, Mapping
from dataclasses import dataclass
from typing import Any

from w2c import messages as m
from w2c_recorder.conversations import CONFIRMATION, CORRECTION, PREDICTION, Conversation
from w2c_recorder.history import History, Timed

MOST_OBJECTS = 3
"""Of a line for training"""
LONGEST_EXPRESSION = 60

Values = dict[str, Any]
Refuses = Callable[[Values], str]
"""Why the reader of training lines refuses one; empty where it does not"""


@dataclass(frozen=True)
class Camera:
    """What a line says of the picture that its pixels are meant in."""

    width: int
    height: int
    view: m.CameraView | None = None

    def pixels_per_cm(self, target: m.Target) -> float | None:
        """Return the scale at a target; None where its distance is not known."""
        if self.view is None or target.point is None:
            return None
        camera_in_world = self.view.world_from_camera
        depth = float(camera_in_world[:3, 2] @ (target.point - camera_in_world[:3, 3]))
        return 0.01 * self.view.intrinsics[0] / depth if depth > 0.0 else None


Cameras = Mapping[int, Camera]
"""Stamp of a picture -> its size and pose"""


def training_lines(
    history: History, conversation: Conversation, name: str, cameras: Cameras, refuses: Refuses
) -> Iterator[Values]:
    """Yield the turns of a conversation as lines for training; none of one without a yes.

    Args:
        history: of a recording.
        conversation: one of it.
        name: of the recording; the lines get ids from it.
        cameras: of the pictures that the targets were chosen in.
        refuses: checks a line. What is refused is written with fewer fields, or not at all.
    """
    if conversation.confirmation is None:
        return
    moves: list[tuple[float, float]] = []
    shown: m.Target | None = None
    limb = limb_of(history, conversation)
    last = len(conversation.turns) - 1
    for number, turn in enumerate([*conversation.turns, conversation.confirmation]):
        words = conversation.words(turn)
        line = _line(turn.message, words, shown, moves, cameras, limb, corrected=number < last)
        if line is not None:
            kept = _kept({"id": f"{name}#{turn.source.sequence}", **line}, refuses)
            if kept is not None:
                yield kept
        if turn.message.module == CORRECTION and turn.message.target is not None:
            u, v = _corrected_from(turn.message, shown)
            moves.append((turn.message.target.u - u, turn.message.target.v - v))
        shown = turn.message.target


def _line(
    turn: m.Turn,
    words: str,
    shown: m.Target | None,
    moves: list[tuple[float, float]],
    cameras: Cameras,
    limb: Values,
    *,
    corrected: bool,
) -> Values | None:
    """Return a turn for training; None for one without words, or whose words are not its own.

    Of a turn that was corrected afterwards the point was not what was meant, and why is not known:
    its objects and its point are left out. The limb is asked for when the person says yes.
    """
    target = turn.target
    if not words or target is None:
        return None
    if turn.module == CONFIRMATION:
        return {"utterance": turn.text, "module": CONFIRMATION}
    camera = cameras.get(target.frame_stamp_ns)
    line: Values = {"utterance": words}
    if turn.module.startswith(PREDICTION):
        if target.instruction != words:  # an answer whose question was not recorded
            return None
        line["module"] = "prediction"
        if {"effector", "task"} <= limb.keys():
            line |= {"end_effector": limb["effector"], "task_type": limb["task"]}
        if not corrected:
            line["position"] = turn.module.removeprefix(PREDICTION)
    elif turn.module == CORRECTION:
        line["module"] = CORRECTION
        line["target"] = list(_corrected_from(turn, shown))
        line["previous_moves"] = [list(move) for move in moves]
    else:
        return None
    if corrected:
        return line
    return line | _place(turn, target, shown, camera)


def _place(turn: m.Turn, target: m.Target, shown: m.Target | None, camera: Camera | None) -> Values:
    """Return the point of a turn with what explains it."""
    found: Values = {"point": [target.u, target.v], "objects": _objects(target)}
    if camera is not None:
        found["image"] = [camera.width, camera.height]
        # The centimetres of a correction are those at the target that the person saw.
        seen = shown if turn.module == CORRECTION and shown is not None else target
        scale = camera.pixels_per_cm(seen)
        if scale is not None:
            found["px_per_cm"] = round(scale, 3)
    answer = _answer(turn, "correct" if turn.module == CORRECTION else "relative")
    x, y = answer.get("x"), answer.get("y")
    if isinstance(x, str) and isinstance(y, str) and max(len(x), len(y)) <= LONGEST_EXPRESSION:
        found |= {"x": x, "y": y}
    return found


def limb_of(history: History, conversation: Conversation) -> Values:
    """Return what the language model said of the limb that an instruction names.

    It may have been asked for the advice already, before the person said yes: then the answer is
    in a call, and not with the turn.
    """
    confirmation = conversation.confirmation
    if confirmation is None:
        return {}
    answer = _answer(confirmation.message, "effector")
    words = _letters(conversation.words(conversation.turns[0]))
    for call in reversed(history.calls):
        if answer or not words:
            break
        if not isinstance(call.request, m.CompleteRequest) or call.end_ns > confirmation.at_ns:
            continue
        value = call.reply.value if isinstance(call.reply, m.CompleteReply) else None
        about = _letters(call.request.messages[-1].content)
        if isinstance(value, dict) and {"effector", "task"} <= value.keys() and words in about:
            answer = value
    return answer


def _letters(text: str) -> str:
    return "".join(letter for letter in text.casefold() if letter.isalnum())


def _objects(target: m.Target) -> list[Values]:
    pairs = list(zip(target.phrases, target.boxes, strict=False))[:MOST_OBJECTS]
    return [
        {
            "phrase": phrase,
            "cx": (box.left + box.right) / 2,
            "cy": (box.top + box.bottom) / 2,
            "w": box.right - box.left,
            "h": box.bottom - box.top,
        }
        for phrase, box in pairs
    ]


def _answer(turn: m.Turn, task: str) -> Values:
    """Return what the language model answered to a question of a turn; nothing if none was kept."""
    for answer in reversed(turn.evidence.answers if turn.evidence else []):
        if answer.task == task:
            try:
                values = json.loads(answer.answer)
            except ValueError:  # cut off: the whole answer was too long to be kept
                return {}
            return values if isinstance(values, dict) else {}
    return {}


def _corrected_from(turn: m.Turn, shown: m.Target | None) -> tuple[float, float]:
    """Return where the target was before a correction, in the picture of the turn [px]."""
    if turn.evidence is not None and turn.evidence.corrected_from is not None:
        return turn.evidence.corrected_from
    if shown is not None:
        return shown.u, shown.v
    return (0.0, 0.0) if turn.target is None else (turn.target.u, turn.target.v)


def _kept(line: Values, refuses: Refuses) -> Values | None:
    """Return as much of a line as its reader takes; None where it takes nothing."""
    steps: tuple[tuple[str, ...], ...] = (
        (),
        ("x", "y"),  # a point that was clipped, or masked: they do not give it
        ("px_per_cm", "image"),
        ("objects", "position", "point", "target", "previous_moves"),
    )
    kept = dict(line)
    for names in steps:
        kept = {name: value for name, value in kept.items() if name not in names}
        if not refuses(kept):
            return kept
    return None


def conversation_values(
    history: History, conversation: Conversation, pictures: Mapping[int, str]
) -> Values:
    """Return all that is known of a conversation, for studies and for other models.

    Args:
        history: of the recording.
        conversation: one of it.
        pictures: stamp of a picture -> name of its file.
    """
    confirmed = conversation.confirmed
    goal = "" if conversation.confirmation is None else conversation.confirmation.message.goal_id
    return {
        "seconds": history.seconds(conversation.turns[0].at_ns),
        "turns": [_turn_values(history, turn, pictures) for turn in conversation.turns],
        "failed": [turn.message.text for turn in conversation.failed],
        "corrections": sum(turn.message.module == CORRECTION for turn in conversation.turns),
        "confirmed": None if confirmed is None else _target_values(confirmed, pictures),
        "goal_id": goal,
        "outcome": conversation.outcome,
        "reason": conversation.reason,
        "distance_m": conversation.events[-1].message.distance if conversation.events else None,
    }


def _turn_values(history: History, turn: Timed[m.Turn], pictures: Mapping[int, str]) -> Values:
    message = turn.message
    target = message.target
    return {
        "seconds": history.seconds(turn.at_ns),
        "utterance": message.text,
        "module": message.module,
        "reply": message.reply,
        "took_s": message.seconds,
        "target": None if target is None else _target_values(target, pictures),
        "objects": [] if target is None else _objects(target),
        "answers": {
            answer.task: answer.answer
            for answer in (message.evidence.answers if message.evidence else [])
        },
    }


def _target_values(target: m.Target, pictures: Mapping[int, str]) -> Values:
    return {
        "id": target.target_id,
        "pixel": [target.u, target.v],
        "point": None if target.point is None else target.point.tolist(),
        "normal": None if target.normal is None else target.normal.tolist(),
        "picture": pictures.get(target.frame_stamp_ns, ""),
    }
