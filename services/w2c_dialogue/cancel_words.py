"""Words that take the newest thing back: the target on the screen, else the motion.

Like stop words they are recognised without any model, and only as a whole utterance: "never mind
the cup, take the plate" is an instruction, and "cancel that" takes back a correction.
"""

from w2c.errors import RefusedError
from w2c_dialogue.utterance import parse

CANCEL_PHRASES = frozenset(
    {
        "never mind",
        "nevermind",
        "never mind that",
        "never mind it",
        "forget it",
        "forget that",
        "forget about it",
        "forget about that",
        "forget the target",
        "drop the target",
        "cancel",
        "cancel it",
        "cancel the target",
        "cancel everything",
        "discard it",
        "discard the target",
        "call it off",
        "abort",
    }
)
AROUND = frozenset(
    {
        "actually", "ah", "hm", "hmm", "just", "no", "now", "oh", "ok", "okay", "please", "robot",
        "so", "sorry", "thanks", "then", "uh", "um", "wait", "well",
    }
)  # fmt: skip
"""What people say before and after"""


def is_cancel(text: str) -> bool:
    """Say whether an utterance takes back what is shown, or the motion, and says nothing else."""
    try:
        words = [word.rstrip(",") for word in parse(text).folded]
    except RefusedError:
        return False
    while words and words[0] in AROUND:
        del words[0]
    while words and words[-1] in AROUND:
        del words[-1]
    return " ".join(words) in CANCEL_PHRASES
