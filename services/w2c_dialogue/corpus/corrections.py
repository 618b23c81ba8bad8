"""Corrections: how people push a point about, and the expressions of where it goes.

A bit is 20 px, a step without size 40 px, a lot 100 px. Behind and farther are up in the picture,
nearer and in front are down (`u` grows to the right, `v` grows downwards).
"""

from dataclasses import dataclass

from w2c_dialogue.corpus import correction_words as words
from w2c_dialogue.corpus import locations
from w2c_dialogue.corpus.asides import with_aside
from w2c_dialogue.corpus.draft import Draft
from w2c_dialogue.corpus.draw import Draw
from w2c_dialogue.corpus.measures import body_length
from w2c_dialogue.corpus.phrases import article, phrase

WAYS = {"left": (-1, 0), "right": (1, 0), "up": (0, -1), "down": (0, 1)}


@dataclass(frozen=True)
class Correction:
    """A correction and the expressions of the new target."""

    draft: Draft
    x: str
    y: str
    needs_past: int = 0
    """How many earlier corrections it speaks of"""
    scene: str = ""
    """Facts about the boxes under which it is right; empty: any"""


def correction(draw: Draw) -> Correction:
    """Return one correction."""
    roll = draw.uniform()
    for share, make in _KINDS:
        if roll < share:
            return make(draw)
        roll -= share
    draft = Draft()
    draft.add(draw.pick(words.STAY))
    return Correction(draft, "target.u", "target.v")


def term(symbol: str, sign: int, size: str) -> str:
    """Return `target.u+40`, or the symbol alone where the sign is 0."""
    return symbol + {0: "", 1: "+", -1: "-"}[sign] + (size if sign else "")


def _step(draw: Draw) -> tuple[str, str]:
    """Return words of a size and its pixels."""
    roll = draw.uniform()
    for size, listed, share in words.STEPS:
        if roll < share:
            return draw.pick(listed), size
        roll -= share
    return "", "40"


def _sized_direction(draw: Draw, way: str) -> tuple[str, str]:
    """Return words such as `a bit to the left` and the size in pixels."""
    to = draw.pick(words.TO[way])
    if draw.chance(0.25):
        said, size = locations.distance(draw)
        return draw.pick(
            (f"{said} {to}", f"{to} {said}", f"{to} by {said}", f"by {said} {to}")
        ), size
    if draw.chance(0.05):
        number = 2 + draw.below(4)
        word = draw.pick((str(number), ("two", "three", "four", "five")[number - 2]))
        return f"{word} steps {to}", f"{number}*40"
    said, size = _step(draw)
    return (f"{to} {said}" if draw.chance(0.25) else f"{said} {to}").strip(), size


def _finish(
    draw: Draw,
    template: str,
    phrases: dict[str, str],
    *,
    bare: float = 0.35,
    verbs: tuple[str, ...] = words.MOVE,
) -> Draft:
    """Put a verb in front, and what people say around it."""
    draft = Draft()
    if draw.chance(0.22):
        draft.add(draw.pick(words.LEADS))
        if draw.chance(0.5):
            draft.words[-1] = draft.words[-1].rstrip(",:") + ","
    if not draw.chance(bare):
        draft.add(draw.pick(verbs))
    draft.fill(with_aside(template, draw), phrases)
    if draw.chance(0.1):
        draft.add(draw.pick(words.TAILS))
    return draft


def _direction(draw: Draw) -> Correction:
    way = draw.pick(tuple(WAYS))
    said, size = _sized_direction(draw, way)
    du, dv = WAYS[way]
    x, y = term("target.u", du, size), term("target.v", dv, size)
    return Correction(_finish(draw, said, {}), x, y)


def _by_body(draw: Draw) -> Correction:
    """Go by a length of the body: `two fingers up`."""
    way = draw.pick(tuple(WAYS))
    (said, size), to, (du, dv) = body_length(draw), draw.pick(words.TO[way]), WAYS[way]
    text = draw.pick((f"{said} {to}", f"{said} {to}", f"{to} {said}", f"{to} by {said}"))
    x, y = term("target.u", du, size), term("target.v", dv, size)
    return Correction(_finish(draw, text, {}), x, y)


def _diagonal(draw: Draw) -> Correction:
    across, along = draw.pick(("left", "right")), draw.pick(("up", "down"))
    first, second = (across, along) if draw.chance(0.5) else (along, across)
    if draw.chance(0.4):
        said, size = _step(draw)
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
        one, size_one = _sized_direction(draw, first)
        other, size_other = _sized_direction(draw, second)
        link = draw.pick((" and ", ", ", " and then ", ", then ", " and also ", " then "))
        text, sizes = f"{one}{link}{other}", {first: size_one, second: size_other}
    x = term("target.u", WAYS[across][0], sizes[across])
    y = term("target.v", WAYS[along][1], sizes[along])
    return Correction(_finish(draw, text, {}), x, y)


def _two_amounts(draw: Draw) -> Correction:
    """Go two ways, by two amounts that differ: `a lot left and a smidge up`."""
    ways = draw.pick(("left", "right")), draw.pick(("up", "down"))
    steps = {size: listed if size != "40" else ("",) for size, listed, _ in words.STEPS}
    sizes: dict[str, str] = {}
    said = []
    for way in ways if draw.chance(0.5) else ways[::-1]:
        if draw.chance(0.2):
            amount, size = locations.distance(draw)
        else:
            size = draw.pick([size for size in steps if size not in sizes.values()])
            amount = draw.pick(steps[size])
        to, sizes[way] = draw.pick(words.TO[way]), size
        said.append((f"{to} {amount}" if draw.chance(0.4) else f"{amount} {to}").strip())
    draft = _finish(draw, draw.pick(words.TWO_LINKS).join(said), {})
    x, y = ("target.u", "target.v")
    for way in ways:
        du, dv = WAYS[way]
        x, y = (term(x, du, sizes[way]), y) if du else (x, term(y, dv, sizes[way]))
    return Correction(draft, x, y)


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
        return Correction(_finish(draw, said, {}), x, y, 1)
    if roll < 0.92:
        draft = _finish(draw, draw.pick(words.START), {}, bare=1.0)
        return Correction(draft, "start.u", "start.v", 1)
    draft = _finish(draw, draw.pick(words.UNDO_TWO), {}, bare=1.0)
    x, y = "target.u-last.du-moves[-2].du", "target.v-last.dv-moves[-2].dv"
    return Correction(draft, x, y, 2)


def _again(draw: Draw) -> Correction:
    """Repeat the last move, or a part of it, or take it back."""
    factor = draw.pick(tuple(words.AGAIN_AS))
    draft = _finish(draw, draw.pick(words.AGAIN_AS[factor]), {}, bare=1.0)
    sign = "" if factor.startswith("-") else "+"
    part = {"1": "+", "-1": "-"}.get(factor, f"{sign}{factor}*")
    return Correction(draft, f"target.u{part}last.du", f"target.v{part}last.dv", 1)


def _object(draw: Draw) -> Correction:
    """Refer to an object."""
    things = {"A": phrase(draw, surface=draw.chance(0.5))}
    a = f"{article(draw)} {{A}}".strip()
    roll = draw.below(15)
    for below, make in _OBJECT_KINDS:
        if roll < below:
            return make(draw, a, things)
    return _between(draw)


def _closer(draw: Draw, a: str, things: dict[str, str]) -> Correction:
    said, share = draw.pick(words.CLOSER)
    x, y = f"target.u+{share}*(a.u-target.u)", f"target.v+{share}*(a.v-target.v)"
    return Correction(_finish(draw, f"{said} {a}", things), x, y)


def _away(draw: Draw, a: str, things: dict[str, str]) -> Correction:
    said, share = draw.pick(words.AWAY)
    x, y = f"target.u-{share}*(a.u-target.u)", f"target.v-{share}*(a.v-target.v)"
    return Correction(_finish(draw, f"{said} {a}", things), x, y)


def _onto(draw: Draw, a: str, things: dict[str, str]) -> Correction:
    said = f"{draw.pick(words.ONTO)} {a}"
    return Correction(_finish(draw, said, things, bare=0.0, verbs=words.MOVE_POINT), "a.u", "a.v")


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
    return Correction(_finish(draw, said, things, bare=0.2, verbs=words.MOVE_POINT), x, y)


def _beside(draw: Draw, a: str, things: dict[str, str]) -> Correction:
    phrases, du, dv = locations.SIDES[draw.pick(tuple(locations.SIDES))]
    said = draw.pick(phrases)
    size = locations.USUAL
    if draw.chance(0.2):
        length, size = locations.distance(draw)
        said = f"{length} {said}"
    x, y = locations.beside("a", du, dv, size)
    draft = _finish(draw, f"{said} {a}", things, bare=0.0, verbs=words.MOVE_POINT)
    return Correction(draft, x, y)


def _align(draw: Draw, a: str, things: dict[str, str]) -> Correction:
    level = draw.chance(0.6)
    if draw.chance(0.4):
        part, symbol = draw.pick(words.LEVEL_PARTS if level else words.COLUMN_PARTS)
        said = f"{draw.pick(words.LEVEL if level else words.STRAIGHT)} the {part} of {a}"
        x, y = ("target.u", symbol) if level else (symbol, "target.v")
        return Correction(_finish(draw, said, things), x, y)
    if level:
        return Correction(_finish(draw, f"{draw.pick(words.LEVEL)} {a}", things), "target.u", "a.v")
    return Correction(_finish(draw, f"{draw.pick(words.STRAIGHT)} {a}", things), "a.u", "target.v")


def _object_sized(draw: Draw, a: str, things: dict[str, str]) -> Correction:
    way = draw.pick(tuple(WAYS))
    du, dv = WAYS[way]
    measure = "width" if du else "height"
    said, share = draw.pick(words.MEASURES)
    length, to = f"{said} {measure} of {a}", draw.pick(words.TO[way])
    text = draw.pick((f"by {length} {to}", f"{length} {to}", f"{to} by {length}"))
    size = f"{share}a.{measure}"
    x, y = term("target.u", du, size), term("target.v", dv, size)
    return Correction(_finish(draw, text, things, bare=0.2), x, y)


def _between(draw: Draw) -> Correction:
    things = {"A": phrase(draw), "B": phrase(draw)}
    said = f"{draw.pick(words.BETWEEN)} {article(draw)} {{A}} and {article(draw)} {{B}}"
    draft = _finish(draw, said, things, bare=0.0, verbs=words.MOVE_POINT)
    scene = draw.pick(tuple(locations.BOXES_OF_BETWEEN))
    return Correction(draft, *locations.BOXES_OF_BETWEEN[scene], scene=scene)


def _pixels(draw: Draw) -> Correction:
    u, v = draw.below(1280), draw.below(720)
    said = draw.pick(words.PIXELS).format(u, v)
    return Correction(_finish(draw, said, {}, bare=0.1), str(u), str(v))


_KINDS = (
    (0.31, _direction),
    (0.03, _by_body),
    (0.1, _diagonal),
    (0.06, _two_amounts),
    (0.17, _history),
    (0.25, _object),
    (0.02, _pixels),
)
_OBJECT_KINDS = (
    (4, _closer),
    (5, _away),
    (8, _edge),
    (9, _onto),
    (11, _beside),
    (13, _align),
    (14, _object_sized),
)
