"""Lengths as people say them: in centimetres, by their body, and with a number taken back.

A body is not measured: each measure has one length, told in docs/explanation/conversation.md.
"""

from w2c_dialogue.corpus.draw import Draw
from w2c_dialogue.corpus.things import meanings, names
from w2c_dialogue.prompts.numerals import VALUES

NUMBER_WORDS = {word: str(value) for word, value in VALUES.items() if value} | {
    "a couple of": "2",
    "a few": "3",
    "a hundred": "100",
    "one hundred": "100",
    "half a": "0.5",
}
SINGLE = meanings("""
1*cm: a centimeter, a centimetre, one cm, a cm | 2.54*1*cm: an inch, one inch, a inch | 1: a pixel,
one pixel | 0.1*1*cm: a millimeter, one millimetre | 2.54*0.5*cm: half an inch | 0.5*cm: half a
centimeter, half a cm | 100*0.5*cm: half a meter, half a metre
""")
"""Lengths without a number, with their expressions."""
REPAIRED_SHARE = 0.12
"""How often a number is taken back for another while it is said"""
UNITS = (
    (0.48, (("cm", "cm", "centimeters", "centimetres", "centimeter", "cms"), "{}*cm")),
    (0.095, (("mm", "millimeters", "millimetres"), "0.1*{}*cm")),
    (0.095, (("inches", "inch"), "2.54*{}*cm")),
    (0.045, (("meters", "metres", "meter", "metre", "m"), "100*{}*cm")),
)
"""How often, words, and the expression of so many; `cm` is the scale of the scene"""
PIXELS = (("pixels", "px", "pixel", "pixels"), "{}")
"""The same of the rest"""
_FRACTIONS = ("0.25", "0.75", "0.5", "1.5", "2.5")
"""What a quarter of a unit or one and a half of them are, once they are digits"""
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


def distance(draw: Draw) -> tuple[str, str]:
    """Return the words of a length and its expression in pixels."""
    if draw.chance(0.08):
        return draw.pick(SINGLE)
    if draw.chance(0.1):
        return body_length(draw)
    word, size = number(draw)
    if draw.chance(REPAIRED_SHARE):
        wrong = draw.pick(tuple(NUMBER_WORDS)) if word[0].isalpha() else str(1 + draw.below(30))
        word = repaired(wrong, word, draw)
    names_of_unit, expression = unit(draw)
    return with_unit(draw, word, names_of_unit), expression.format(size)


def number(draw: Draw) -> tuple[str, str]:
    """Return the words of a number, and its digits."""
    if draw.chance(0.35):
        word = draw.pick(tuple(NUMBER_WORDS))
        return word, NUMBER_WORDS[word]
    if draw.chance(0.15):
        digits = (
            draw.pick(_FRACTIONS) if draw.chance(0.4) else f"{draw.below(20)}.{1 + draw.below(9)}"
        )
        return digits.replace(".", draw.pick((".", ".", ".", ","))), digits
    digits = str(1 + draw.below(30) if draw.chance(0.7) else 5 * (1 + draw.below(60)))
    return digits, digits


def unit(draw: Draw) -> tuple[tuple[str, ...], str]:
    """Return the names of a unit, and the expression of so many."""
    return draw.by_share(UNITS, PIXELS)


def with_unit(draw: Draw, word: str, names_of_unit: tuple[str, ...]) -> str:
    """Return a number with its unit; digits of centimetres are written without a space, too."""
    name = draw.pick(names_of_unit)
    glued = name == "cm" and word[0].isdigit() and draw.chance(0.5)
    return f"{word}{name}" if glued else f"{word} {name}"
