"""The hand or foot that an instruction names in so many words: "with your right palm".

A small model hears a limb wrongly now and then, of rare words above all. Where one side stands
before one limb, once, and nothing takes it back, there is nothing to guess: of the 4,455 written
instructions of the corpus that are so, 4,454 mean that limb.
"""

from w2c.messages import EndEffector
from w2c_dialogue.utterance import Utterance

_HANDS = frozenset(
    {"arm", "elbow", "fingers", "fingertips", "fist", "forearm", "hand", "palm", "paw", "wrist"}
)
_FEET = frozenset({"boot", "foot", "heel", "hoof", "leg", "sole", "toes"})
_LIMBS: dict[tuple[str, bool], EndEffector] = {
    ("left", True): "left_hand",
    ("right", True): "right_hand",
    ("left", False): "left_foot",
    ("right", False): "right_foot",
}
_OF_OTHERS = frozenset({"her", "his", "its", "my", "our", "their"})
_NO_LIMB = frozenset({"border", "corner", "edge", "end", "half", "of", "part", "rail", "side"})
"""After it: `the right hand side`, `the left arm of the chair`"""
_TAKE_BACK = frozenset(
    {
        "any", "asleep", "busy", "cancel", "can't", "don't", "dont", "either", "free", "holding",
        "hurts", "instead", "isn't", "keep", "mean", "meant", "never", "no", "not", "one", "one's",
        "opposite", "other", "sorry", "stays", "taken", "tired", "wait", "without", "won't",
    }
)  # fmt: skip


def named_limb(utterance: Utterance) -> EndEffector | None:
    """Return the only limb that is named with its side; None where a model must tell."""
    words = [word.rstrip(",") for word in utterance.folded]
    if not _TAKE_BACK.isdisjoint(words):
        return None
    named: set[EndEffector] = set()
    for at, word in enumerate(words):
        if word not in _HANDS | _FEET:
            continue
        side = _side(utterance.folded, at)
        if side is None:
            continue
        if not _OF_OTHERS.isdisjoint(words[max(at - 2, 0) : at]):
            return None
        if not _NO_LIMB.isdisjoint(words[at + 1 : at + 2]):
            return None
        named.add(_LIMBS[side, word in _HANDS])
    return named.pop() if len(named) == 1 else None


def _side(folded: tuple[str, ...], at: int) -> str | None:
    """Return the side of a limb: `left` in `left palm` and in `palm, left, on the book`."""
    if at and folded[at - 1] in ("left", "right"):
        return folded[at - 1]
    behind = folded[at + 1 : at + 2]
    if folded[at].endswith(",") and behind in [("left,",), ("right,",)]:
        return behind[0].rstrip(",")
    return None
