"""A yes that asks for something besides: "yes, but a bit lower" sets nothing in motion.

A model that hears the yes and not the rest would move the robot to a place that was not accepted.
These words are looked for without any model; who only meant yes is asked, and says it again.
"""

from w2c_dialogue.utterance import Utterance

CONTRASTS = frozenset(
    {"although", "but", "except", "however", "if", "instead", "only", "though", "unless", "until"}
)
CHANGES = frozenset(
    {
        "closer", "farther", "further", "higher", "lower", "nearer",
        "backwards", "downwards", "forwards", "leftwards", "rightwards", "upwards",
        "centimeter", "centimeters", "centimetre", "centimetres", "cm", "inch", "inches",
        "millimeter", "millimeters", "millimetre", "millimetres", "mm", "pixel", "pixels", "px",
    }
)  # fmt: skip
"""Of words for a change those that mean nothing else: "all right" is a yes."""


def asks_for_more(utterance: Utterance) -> bool:
    """Say whether words that were taken for a yes say something besides."""
    return any(word.strip(",") in CONTRASTS | CHANGES for word in utterance.folded)
