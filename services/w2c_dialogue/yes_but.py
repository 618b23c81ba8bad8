"""A yes that asks for something besides, or is none: "yes, but a bit lower" moves nothing.

A model that hears the yes and not the rest would move the robot to a place that was not accepted.
These words are looked for without any model; who only meant yes is asked, and says it again.
"""

from w2c_dialogue.utterance import Utterance

CONTRASTS = frozenset(
    {"although", "but", "except", "however", "if", "instead", "only", "though", "unless", "until"}
)
CHANGES = frozenset(
    {
        "bit", "closer", "farther", "further", "higher", "left", "lower", "nearer", "slightly",
        "backwards", "downwards", "forwards", "leftwards", "rightwards", "upwards",
        "centimeter", "centimeters", "centimetre", "centimetres", "cm", "inch", "inches",
        "millimeter", "millimeters", "millimetre", "millimetres", "mm", "pixel", "pixels", "px",
    }
)  # fmt: skip
"""Of words for a change those that mean little else: "all right" is a yes."""
DENIALS = frozenset(
    {
        "abort", "cancel", "don't", "dont", "isn't", "nah", "negative", "never", "no", "nope",
        "not", "stop", "wait", "wrong",
    }
)  # fmt: skip
"""Who says one may still agree; a robot that moves against a no is worse than a question"""


def asks_for_more(utterance: Utterance) -> bool:
    """Say whether words that were taken for a yes say something besides, or a no."""
    return any(word.strip(",") in CONTRASTS | CHANGES | DENIALS for word in utterance.folded)
