"""Lengths that people say by their body, and numbers that they take back while they say them.

A body is not measured: each measure has one length, told in docs/explanation/conversation.md.
"""

from w2c_dialogue.corpus.draw import Draw
from w2c_dialogue.corpus.things import meanings, names

BODY = {
    "finger": "2*{}*cm",
    "thumb": "2.5*{}*cm",
    "hand": "9*{}*cm",
    "foot": "30*{}*cm",
    "arm": "60*{}*cm",
}
"""Expressions of so many widths of a finger, a thumb, a hand, and lengths of a foot, an arm"""
_ONE = meanings("""
finger: a finger, a finger's width, one finger, a finger's breadth, a finger width, the width of a
finger, the thickness of a finger | thumb: a thumb, a thumb's width, one thumb, a thumb's breadth, a
thumb width, the width of a thumb, the width of your thumb | hand: a hand's width, a hand's breadth,
a hand width, a palm's width, the width of a hand, the width of your hand, a handbreadth, the width
of a palm, one hand's width | foot: a foot, one foot, about a foot | arm: an
arm's length, one arm's length, the length of an arm, an arm length
""")
"""Not `a palm` or `one hand` alone: of "put a palm left of the cup" it is the palm that goes"""
_MANY = meanings("""
finger: fingers, fingers, finger widths, fingers' widths, finger's widths | thumb: thumbs, thumb
widths, thumb's widths | hand: hands, hand's widths, hand widths, palms, hands' breadths, palm
widths | foot: feet | arm: arm's lengths, arm lengths
""")
_HALVES = meanings("""
finger: half a finger, half a finger's width | thumb: half a thumb, half a thumb's width | hand:
half a hand, half a hand's width, half a palm | foot: half a foot | arm: half an arm's length, half
an arm
""")
_COUNTS = meanings(
    "2: two, two, 2, a couple of | 3: three, three, 3 | 4: four, 4 | 5: five | 1.5: one and a half"
)
_REPAIRS = names(
    """
no | , no, | no sorry | sorry | , sorry, | wait no | no wait | or rather | , I mean | I mean | no
make that | , make that | , er no, | er | , correction, | or no
""",
    "|",
)


def body_length(draw: Draw) -> tuple[str, str]:
    """Return the words of a length by the body, and its expression."""
    roll = draw.uniform()
    if roll < 0.45:
        said, part = draw.pick(_ONE)
        return said, BODY[part].format("1")
    if roll < 0.55:
        said, part = draw.pick(_HALVES)
        return said, BODY[part].format("0.5")
    (count, number), (said, part) = draw.pick(_COUNTS), draw.pick(_MANY)
    return f"{count} {said}", BODY[part].format(number)


def repaired(wrong: str, right: str, draw: Draw) -> str:
    """Return two words of which the second is meant: `three no four`."""
    return f"{wrong} {draw.pick(_REPAIRS)} {right}".replace(" ,", ",")
