"""Orders to hold. They are recognised without any model, because all models may be dead."""

from w2c.errors import RefusedError
from w2c_dialogue.utterance import parse

STOP_WORDS = frozenset({"stop", "halt", "freeze"})
STOP_LENGTH = 3
"""`stop`, `robot stop now`: longer sentences that say something else, too, are for the model."""
AROUND = frozenset(
    {
        "all", "and", "at", "everything", "hey", "immediately", "it", "just", "motion", "moving",
        "no", "now", "oh", "ok", "okay", "once", "please", "right", "robot", "that", "there",
        "this", "wait", "you",
    }
)  # fmt: skip
"""What people say with it, as often as they like"""


def is_stop(text: str) -> bool:
    """Say whether an utterance is an order to hold. No model is asked: all may be dead."""
    words = _words(text)
    if STOP_WORDS.isdisjoint(words):
        return False
    short = len(words) <= STOP_LENGTH and bool(STOP_WORDS & {words[0], words[-1]})
    return short or set(words) <= STOP_WORDS | AROUND


def begins_with_stop(text: str) -> bool:
    """Say whether an utterance begins with such an order: enough where the robot moves."""
    first = next((word for word in _words(text) if word not in AROUND), "")
    return first in STOP_WORDS


def _words(text: str) -> list[str]:
    try:
        return [word.rstrip(",") for word in parse(text).folded]
    except RefusedError:
        return []
