"""Where, relative to several things, or by several facts about one; and any place at all."""

from collections.abc import Callable

from w2c_dialogue.corpus.draw import Draw
from w2c_dialogue.corpus.locations import (
    BESIDE,
    BOXES_OF_BETWEEN,
    SIDES,
    USUAL,
    WAY_TO_B,
    Location,
    beside,
    inside,
    of_one,
)
from w2c_dialogue.corpus.measures import distance
from w2c_dialogue.corpus.things import meanings, names

BETWEEN = names("""
between {A} and {B}, in between {A} and {B}, in the middle of {A} and {B}, halfway between {A} and
{B}, midway between {A} and {B}, in the space between {A} and {B}, somewhere between {A} and {B}, in
the gap between {A} and {B}, right between {A} and {B}, where {A} and {B} meet, half way from {A} to
{B}, where {A} meets {B}
""")
NEARER = names("""
closer to, nearer to, nearer, more towards, a bit closer to, closer in to, more to the side of,
rather near
""")
BUT = (", ", ", ", " but ", ", but ", ", though ", " only ")
OFF_THEM = meanings("""
behind: a bit behind them, behind them, slightly behind both, a little further back, further back,
a bit farther away, slightly above them, behind the two, a little behind them, somewhat behind |
front: a bit in front of them, in front of them, slightly in front of both, a little nearer to you,
closer to you, a bit nearer, slightly below them, in front of the two, a little in front,
nearer to you
""")
TOWARDS = names(
    """
on the side of {B} | on the side where {B} is | on the side towards {B} | on the side facing {B} |
on the side nearest {B} | on the side nearer to {B} | towards {B} | on {B} side | on the side next
to {B} | toward {B}
""",
    "|",
)
AWAY = names(
    """
on the side away from {B} | away from {B} | on the side opposite {B} | on the side where {B} is not
| on the side facing away from {B} | not on the side of {B} | on the side farther from {B} | on the
side furthest from {B}
""",
    "|",
)
OTHER_SIDE = names(
    """
on the other side of {A} from {B} | the other side of {A} from {B} | on the far side of {A} from {B}
| on the side of {A} away from {B} | past {A} coming from {B} | across {A} from {B}
""",
    "|",
)
ENDS = names("end, end, edge, side, part, half, border")
NEAREST = names("""
nearest, nearest to, closest to, nearer to, facing, next to, that faces, closer to, that is nearest
""")
FURTHEST = names("""
furthest from, farthest from, away from, opposite, facing away from, that is away from, farther from
""")
PARTS_OF_THE_WAY = meanings("""
0.33: one third, a third | 0.25: a quarter | 0.67: two thirds | 0.75: three quarters
""")


def relative(draw: Draw) -> Location:
    """Return a place that is described relative to things."""
    return draw.by_share(_KINDS, of_one)(draw)


def _between(draw: Draw) -> Location:
    text = draw.pick(BETWEEN)
    scene = draw.pick(tuple(BOXES_OF_BETWEEN))
    roll = draw.uniform()
    if roll < 0.35:
        letter, share = draw.pick((("A", "0.25"), ("B", "0.75")))
        text = f"{text}{draw.pick(BUT)}{draw.pick(NEARER)} {{{letter}}}"
        return Location(text, f"a.u+{share}*(b.u-a.u)", f"a.v+{share}*(b.v-a.v)")
    if roll < 0.5:
        return _between_and_off(draw, text)
    return Location(text, *BOXES_OF_BETWEEN[scene], scene)


def _between_and_off(draw: Draw, between: str) -> Location:
    """Go between two things that stand side by side, and from there to the back or to the front."""
    said, way = draw.pick(OFF_THEM)
    scene = draw.pick(("A left of B", "A right of B"))
    if draw.chance(0.25):
        text = f"{draw.pick(SIDES[way][0])} {{A}} and {{B}}{draw.pick(BUT)}in the middle"
    else:
        text = f"{between}{draw.pick(BUT)}{said}"
    y = beside("a", *SIDES[way][1:], USUAL)[1]
    return Location(text, BOXES_OF_BETWEEN[scene][0], y, scene)


def _side_by_another(draw: Draw) -> Location:
    """Go beside a thing, on the side where another is, or on the other: `next to A, towards B`."""
    scene = draw.pick(tuple(WAY_TO_B))
    du, dv = WAY_TO_B[scene]
    if draw.chance(0.5):
        text = f"{draw.pick(BESIDE)} {{A}}{draw.pick((', ', ', ', ' ', ' but '))}"
        text += draw.pick(TOWARDS)
        return Location(text, *beside("a", du, dv, USUAL), scene)
    text = draw.pick(OTHER_SIDE)
    if draw.chance(0.5):
        text = f"{draw.pick(BESIDE)} {{A}}{draw.pick((', ', ' ', ' but '))}{draw.pick(AWAY)}"
    return Location(text, *beside("a", -du, -dv, USUAL), scene)


def _end_by_another(draw: Draw) -> Location:
    """Go to the end of a thing that another is near to: `the end of A nearest B`."""
    scene = draw.pick(tuple(WAY_TO_B))
    du, dv = WAY_TO_B[scene]
    words, sign = draw.pick(((NEAREST, 1), (FURTHEST, -1)))
    end, which = draw.pick(ENDS), f"{draw.pick(words)} {{B}}"
    lead = draw.pick(("on", "on", "at", "to"))
    text = draw.pick(
        (
            f"{lead} the {end} of {{A}} {which}",
            f"on {{A}}, at the {end} {which}",
            f"on {{A}}, the {end} {which}",
            f"{{A}}, on the {end} {which}",
        )
    )
    return Location(text, *inside("a", sign * du, sign * dv), scene)


def _two_lengths(draw: Draw) -> Location:
    """Go two ways from a thing, by a length each: `5 cm left of A and 2 cm in front of it`."""
    across, along = draw.pick(("left", "right")), draw.pick(("behind", "front"))
    said_across, size_across = distance(draw)
    said_along, size_along = distance(draw)
    pairs = [(said_across, across), (said_along, along)]
    if draw.chance(0.5):
        pairs.reverse()
    (one, first), (other, second) = pairs
    link = draw.pick((" and ", ", ", ", and ", " plus "))
    text = f"{one} {draw.pick(SIDES[first][0])} {{A}}{link}{other} {draw.pick(SIDES[second][0])} it"
    x = beside("a", SIDES[across][1], 0, size_across)[0]
    y = beside("a", 0, SIDES[along][2], size_along)[1]
    return Location(text, x, y)


def _two_sides(draw: Draw) -> Location:
    across, along = draw.pick(("left", "right")), draw.pick(("behind", "front"))
    x = beside("a", SIDES[across][1], 0, USUAL)[0]
    if draw.chance(0.3):
        level = draw.pick(("at the height of", "level with", "in line with"))
        return Location(f"{draw.pick(SIDES[across][0])} {{A}}, {level} {{B}}", x, "b.v")
    y = beside("b", 0, SIDES[along][2], USUAL)[1]
    text = f"{draw.pick(SIDES[across][0])} {{A}} and {draw.pick(SIDES[along][0])} {{B}}"
    return Location(text, x, y)


def _three(draw: Draw) -> Location:
    lead = draw.pick(("between", "in the middle of", "in between", "in the center of", "among"))
    text = f"{lead} {{A}}, {{B}} and {{C}}"
    return Location(text, "(a.u+b.u+c.u)/3", "(a.v+b.v+c.v)/3")


def _along(draw: Draw) -> Location:
    words, share = draw.pick(PARTS_OF_THE_WAY)
    text = draw.pick(("from {A} to {B}", "between {A} and {B}"))
    return Location(
        f"{words} of the way {text}", f"a.u+{share}*(b.u-a.u)", f"a.v+{share}*(b.v-a.v)"
    )


_KINDS: tuple[tuple[float, Callable[[Draw], Location]], ...] = (
    (0.40, of_one),
    (0.24, _between),
    (0.12, _side_by_another),
    (0.08, _end_by_another),
    (0.07, _two_lengths),
    (0.04, _two_sides),
    (0.03, _three),
    (0.02, _along),
)
"""How often, and what."""
