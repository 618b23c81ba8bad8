"""Corrections: how people push a point about, and the expressions of where it goes.

A bit is 20 px, a step without size 40 px, a lot 100 px. Behind and farther are up in the picture,
nearer and in front are down (`u` grows to the right, `v` grows downwards).
"""

from w2c_dialogue.corpus import correction_words as words
from w2c_dialogue.corpus import locations
from w2c_dialogue.corpus.draft import Draft
from w2c_dialogue.corpus.draw import Draw
from w2c_dialogue.corpus.exact_moves import (
    along_axis,
    along_last,
    earlier_move,
    towards,
    two_amounts,
    two_lengths,
    two_ways,
)
from w2c_dialogue.corpus.measures import body_length, distance
from w2c_dialogue.corpus.moves import read_move
from w2c_dialogue.corpus.phrases import article, phrase
from w2c_dialogue.corpus.steering import WAYS, Correction, finish, sized_direction, step, term


def correction(draw: Draw) -> Correction:
    """Return one correction."""
    return draw.by_share(_KINDS, _stay)(draw)


def _stay(draw: Draw) -> Correction:
    """Say that it is wrong, or stop, and no direction."""
    draft = Draft()
    draft.add(draw.pick(words.STAY))
    return Correction(draft, "target.u", "target.v")


def _direction(draw: Draw) -> Correction:
    way = draw.pick(tuple(WAYS))
    said, size = sized_direction(draw, way)
    du, dv = WAYS[way]
    x, y = term("target.u", du, size), term("target.v", dv, size)
    return Correction(finish(draw, said, {}), x, y)


def _by_body(draw: Draw) -> Correction:
    """Go by a length of the body: `two fingers up`."""
    way = draw.pick(tuple(WAYS))
    (said, size), to, (du, dv) = body_length(draw), draw.pick(words.TO[way]), WAYS[way]
    text = draw.pick((f"{said} {to}", f"{said} {to}", f"{to} {said}", f"{to} by {said}"))
    x, y = term("target.u", du, size), term("target.v", dv, size)
    return Correction(finish(draw, text, {}), x, y)


def _diagonal(draw: Draw) -> Correction:
    first, second = two_ways(draw)
    across, along = (first, second) if first in ("left", "right") else (second, first)
    if draw.chance(0.4):
        said, size = step(draw)
        joined = draw.pick(
            (
                f"{first} and {second}",
                f"diagonally {first} {second}",
                f"{along} {across}",
                f"{along} and to the {across}",
                f"{along}-{across}",
                f"{first} and also {second}",
            )
        )
        text, sizes = f"{said} {joined}".strip(), {first: size, second: size}
    else:
        one, size_one = sized_direction(draw, first)
        other, size_other = sized_direction(draw, second)
        link = draw.pick((" and ", ", ", " and then ", ", then ", " and also ", " then "))
        text, sizes = f"{one}{link}{other}", {first: size_one, second: size_other}
    x = term("target.u", WAYS[across][0], sizes[across])
    y = term("target.v", WAYS[along][1], sizes[along])
    return Correction(finish(draw, text, {}), x, y)


def _history(draw: Draw) -> Correction:
    """Refer to earlier corrections."""
    roll = draw.uniform()
    if roll < 0.72:
        return _again(draw)
    if roll < 0.84:
        text, factor = draw.pick(words.RESIZED)
        way = draw.pick(tuple(WAYS))
        du, dv = WAYS[way]
        said = text.format(draw.pick(words.TO[way]))
        said += draw.pick(("", " as before", "", " as last time"))
        size = "last.size" if factor == "1" else f"{factor}*last.size"
        x, y = term("target.u", du, size), term("target.v", dv, size)
        return Correction(finish(draw, said, {}), x, y, 1)
    if roll < 0.92:
        draft = finish(draw, draw.pick(words.START), {}, bare=1.0)
        return Correction(draft, "start.u", "start.v", 1)
    draft = finish(draw, draw.pick(words.UNDO_TWO), {}, bare=1.0)
    x, y = "target.u-last.du-moves[-2].du", "target.v-last.dv-moves[-2].dv"
    return Correction(draft, x, y, 2)


def _again(draw: Draw) -> Correction:
    """Repeat the last move, or a part of it, or take it back."""
    factor = draw.pick(tuple(words.AGAIN_AS))
    draft = finish(draw, draw.pick(words.AGAIN_AS[factor]), {}, bare=1.0)
    sign = "" if factor.startswith("-") else "+"
    part = {"1": "+", "-1": "-"}.get(factor, f"{sign}{factor}*")
    return Correction(draft, f"target.u{part}last.du", f"target.v{part}last.dv", 1)


def _object(draw: Draw) -> Correction:
    """Refer to an object."""
    things = {"A": phrase(draw, surface=draw.chance(0.5))}
    a = f"{article(draw)} {{A}}".strip()
    roll = draw.below(17)
    for below, make in _OBJECT_KINDS:
        if roll < below:
            return make(draw, a, things)
    return _between(draw)


def _closer(draw: Draw, a: str, things: dict[str, str]) -> Correction:
    return _along_the_way(draw, a, things, draw.pick(words.CLOSER))


def _away(draw: Draw, a: str, things: dict[str, str]) -> Correction:
    return _along_the_way(draw, a, things, draw.pick(words.AWAY))


def _along_the_way(
    draw: Draw, a: str, things: dict[str, str], meant: tuple[str, str]
) -> Correction:
    """Go along the line to an object, as a note says."""
    said, note = meant
    place, _ = read_move(note)
    return Correction(finish(draw, f"{said} {a}", things), place.x, place.y)


def _onto(draw: Draw, a: str, things: dict[str, str]) -> Correction:
    said = f"{draw.pick(words.ONTO)} {a}"
    return Correction(finish(draw, said, things, bare=0.0, verbs=words.MOVE_POINT), "a.u", "a.v")


def _edge(draw: Draw, a: str, things: dict[str, str]) -> Correction:
    if draw.chance(0.65):
        listed, (du, dv) = draw.pick(locations.EDGES)
        name, what = draw.pick(listed), draw.pick(locations.EDGE_WORDS)
    else:
        name = draw.pick(tuple(locations.CORNERS))
        du, dv = locations.CORNERS[name]
        what = "corner"
    said = f"{draw.pick(words.EDGE_LEADS)} {name} {what} of {a}"
    x, y = locations.inside("a", du, dv)
    return Correction(finish(draw, said, things, bare=0.2, verbs=words.MOVE_POINT), x, y)


def _beside(draw: Draw, a: str, things: dict[str, str]) -> Correction:
    phrases, du, dv = locations.SIDES[draw.pick(tuple(locations.SIDES))]
    said = draw.pick(phrases)
    size = locations.USUAL
    if draw.chance(0.2):
        length, size = distance(draw)
        said = f"{length} {said}"
    x, y = locations.beside("a", du, dv, size)
    draft = finish(draw, f"{said} {a}", things, bare=0.0, verbs=words.MOVE_POINT)
    return Correction(draft, x, y)


def _align(draw: Draw, a: str, things: dict[str, str]) -> Correction:
    level = draw.chance(0.6)
    if draw.chance(0.4):
        part, symbol = draw.pick(words.LEVEL_PARTS if level else words.COLUMN_PARTS)
        lead = draw.pick((words.LEVEL if level else words.STRAIGHT, words.IN_LINE))
        said = f"{draw.pick(lead)} the {part} of {a}"
        x, y = ("target.u", symbol) if level else (symbol, "target.v")
        return Correction(finish(draw, said, things), x, y)
    if level:
        return Correction(finish(draw, f"{draw.pick(words.LEVEL)} {a}", things), "target.u", "a.v")
    return Correction(finish(draw, f"{draw.pick(words.STRAIGHT)} {a}", things), "a.u", "target.v")


def _object_sized(draw: Draw, a: str, things: dict[str, str]) -> Correction:
    way = draw.pick(tuple(WAYS))
    du, dv = WAYS[way]
    measure = "width" if du else "height"
    said, share = draw.pick(words.MEASURES)
    length, to = f"{said} {measure} of {a}", draw.pick(words.TO[way])
    text = draw.pick((f"by {length} {to}", f"{length} {to}", f"{to} by {length}"))
    size = f"{share}a.{measure}"
    x, y = term("target.u", du, size), term("target.v", dv, size)
    return Correction(finish(draw, text, things, bare=0.2), x, y)


def _between(draw: Draw) -> Correction:
    things = {"A": phrase(draw), "B": phrase(draw)}
    said = f"{draw.pick(words.BETWEEN)} {article(draw)} {{A}} and {article(draw)} {{B}}"
    draft = finish(draw, said, things, bare=0.0, verbs=words.MOVE_POINT)
    scene = draw.pick(tuple(locations.BOXES_OF_BETWEEN))
    return Correction(draft, *locations.BOXES_OF_BETWEEN[scene], scene=scene)


def _pixels(draw: Draw) -> Correction:
    u, v = draw.below(1280), draw.below(720)
    said = draw.pick(words.PIXELS).format(u, v)
    return Correction(finish(draw, said, {}, bare=0.1), str(u), str(v))


_KINDS = (
    (0.22, _direction),
    (0.03, _by_body),
    (0.04, _diagonal),
    (0.06, two_amounts),
    (0.08, two_lengths),
    (0.13, _history),
    (0.06, along_last),
    (0.03, earlier_move),
    (0.04, along_axis),
    (0.25, _object),
    (0.02, _pixels),
)
"""How often, and what"""
_OBJECT_KINDS = (
    (4, _closer),
    (5, _away),
    (8, _edge),
    (9, _onto),
    (11, _beside),
    (13, _align),
    (14, _object_sized),
    (16, towards),
)
