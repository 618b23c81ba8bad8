"""Orders to hold. They are recognised without any model, because all models may be dead."""

from w2c.errors import RefusedError
from w2c_dialogue.utterance import parse

STOP_WORDS = frozenset({"stop", "halt", "freeze"})
STOP_LENGTH = 3
"""`stop`, `robot stop now`: longer sentences with the word are for the model."""


def is_stop(text: str) -> bool:
    """Say whether an utterance is an order to hold. No model is asked: all may be dead."""
    try:
        words = [word.rstrip(",") for word in parse(text).folded]
    except RefusedError:
        return False
    return len(words) <= STOP_LENGTH and bool(STOP_WORDS & {words[0], words[-1]})
