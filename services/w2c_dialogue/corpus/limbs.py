"""Which hand or foot: with its side, in short, corrected while it is said, or by the other one."""

from w2c_dialogue.corpus.draw import Draw
from w2c_dialogue.corpus.things import names

ANY_HAND = names("""
your hand, a hand, the hand, one hand, hand, one of your hands, a palm, your palm, an arm, your
arm, either hand, any hand, some hand, your fist
""")
HANDS = (
    "hand",
    "hand",
    "hand",
    "hand",
    "hand",
    "palm",
    "arm",
    "fist",
    "wrist",
    "fingers",
    "gripper",
    "limb",
)
FEET = ("foot", "foot", "foot", "sole", "leg", "shoe", "heel", "boot", "toes")
WITH = ("with", "with", "using", "with", "by using", "use", "via", "w", "w/")
SHORT_LIMBS = names("""
{s} {part}, {s} {part}, ur {s} {part}, {s}{p}, {s}{p}, {s}. {part}, {s}-{part}, your {s} {part}, the
{s} {part}
""")
REPAIRED_LIMBS = names(
    """
{other} no {side} {part} | your {other}, no, your {side} {part} | {other} no sorry {side} {part} |
{other} {part}, sorry, {side} {part} | the {other}, I mean the {side} {part} | not the {other}, the
{side} {part} | {other} wait {side} {part} | not the {other} {part} the {side} one | not the
{other}, the other {part} | not your {other} {part}, the other one | your {other} or rather {side}
{part} | {other} er {side} {part} | {side} {wrong}, no, {side} {part} | {side} {wrong} sorry {part}
""",
    "|",
)
"""`side` and `part` are meant, `other` and `wrong` are not"""
OTHER_LIMBS = names(
    """
{told}, not with your {other} {part} but the other one | don't use your {other} {part}, {told} with
the other | your {other} {part} is busy so {told} with the other one | keep your {other} {part} free
and {told} with the other {part} | not the {other} {part}, the {side} one: {told} | {told} with the
other {part}, not the {other} one | the {other} {part} is taken, {told} with the other | {told} but
leave the {other} {part} where it is, take the other | {told}, any {part} but the {other} one | not
your {other}, your other {part}: {told} | {told} with your {side} {part}, the {other} one stays |
{other} {part} hurts, so {told} with the other | {told}, and not with the {other} {part}, use the
{side}
""",
    "|",
)
"""`told` is an instruction that names no limb; `side` is meant, `other` is not"""


def _short_limb(draw: Draw, *, feet: bool) -> tuple[str, str]:
    """Return an end effector as thumbs type it, or corrected while it is said, and its name."""
    side, other = ("left", "right") if draw.chance(0.5) else ("right", "left")
    part, wrong = ("foot", "hand") if feet and draw.chance(0.25) else ("hand", "foot")
    template = draw.pick(draw.pick((SHORT_LIMBS, REPAIRED_LIMBS)))
    said = template.format(s=side[0], p=part[0], side=side, other=other, part=part, wrong=wrong)
    return said, f"{side}_{part}"


def limb_phrase(draw: Draw, *, feet: bool = True) -> tuple[str, str]:
    """Return the words for an end effector and its name."""
    roll = draw.uniform()
    if roll < 0.12:
        return draw.pick(ANY_HAND), "unspecified"
    if draw.chance(0.08):
        return _short_limb(draw, feet=feet)
    side = draw.pick(("left", "right"))
    if roll < 0.82:
        part, name = draw.pick(HANDS), "hand"
    elif roll < 0.86 or not feet:
        return draw.pick((f"your {side}", f"the {side} one", f"{side}")), f"{side}_hand"
    else:
        part, name = draw.pick(FEET), "foot"
    owner = draw.pick(("your", "your", "your", "the", "", "its", "ur"))
    if draw.chance(0.03):
        return f"the {part} on the {side}", f"{side}_{name}"
    return f"{owner} {side} {part}".strip(), f"{side}_{name}"


def by_the_other(draw: Draw, told: str, *, feet: bool) -> tuple[str, str]:
    """Return an instruction that tells the limb by the other one, and the limb's name."""
    side, other = ("left", "right") if draw.chance(0.5) else ("right", "left")
    part = "foot" if feet and draw.chance(0.2) else "hand"
    said = draw.pick(OTHER_LIMBS).format(told=told, side=side, other=other, part=part)
    return said, f"{side}_{part}"
