"""Corrections that must be followed to the letter: which amount goes which way.

A small model hears one amount well and mixes up two, unless it has heard thousands of pairs.
"""

from w2c_dialogue.corpus import correction_words as words
from w2c_dialogue.corpus import exact_words
from w2c_dialogue.corpus.draw import Draw
from w2c_dialogue.corpus.measures import distance, number, unit, with_unit
from w2c_dialogue.corpus.steering import WAYS, Correction, finish, term


def two_amounts(draw: Draw) -> Correction:
    """Go two ways, by two amounts that differ: `a lot left and a smidge up`."""
    ways = two_ways(draw)
    steps = {size: listed for _, (size, listed) in words.STEPS} | {words.STEP[0]: ("",)}
    sizes: dict[str, str] = {}
    said = []
    for way in ways:
        if draw.chance(0.35):
            amount, size = distance(draw)
        else:
            size = draw.pick([size for size in steps if size not in sizes.values()])
            amount = draw.pick(steps[size])
        said.append(_directed(draw, amount, way))
        sizes[way] = size
    return _to_both(draw, draw.pick(words.TWO_LINKS).join(said), sizes)


def two_lengths(draw: Draw) -> Correction:
    """Go two ways by lengths: `3 cm left, 2 cm up`, `three cm left and two up`, `2 cm each`."""
    ways = two_ways(draw)
    roll = draw.uniform()
    if roll < 0.5:
        lengths = [distance(draw) for _ in ways]
        said = [_directed(draw, text, way) for (text, _), way in zip(lengths, ways, strict=True)]
        sizes = {way: size for (_, size), way in zip(lengths, ways, strict=True)}
        return _to_both(draw, draw.pick(words.TWO_LINKS).join(said), sizes)
    listed, expression = unit(draw)
    (one, first), (other, second) = number(draw), number(draw)
    if roll < 0.85:
        text = draw.pick(words.TWO_LINKS).join(
            (
                _directed(draw, with_unit(draw, one, listed), ways[0]),
                _directed(draw, other, ways[1]),
            )
        )
        sizes = {ways[0]: expression.format(first), ways[1]: expression.format(second)}
        return _to_both(draw, text, sizes)
    both = " and ".join(draw.pick(words.TO[way]) for way in ways)
    text = draw.pick(exact_words.EACH).format(with_unit(draw, one, listed), both)
    return _to_both(draw, text, dict.fromkeys(ways, expression.format(first)))


def towards(draw: Draw, a: str, things: dict[str, str]) -> Correction:
    """Go a length along the line to a thing: `two cm closer to the cup`."""
    said, size = distance(draw)
    listed, sign = draw.pick(
        ((exact_words.TOWARDS, "+"), (exact_words.TOWARDS, "+"), (exact_words.OFF, "-"))
    )
    direction = draw.pick(listed)
    text = draw.pick(
        (
            f"{said} {direction} {a}",
            f"{said} {direction} {a}",
            f"{direction} {a} by {said}",
            f"{direction} {a}, {said}",
            f"{direction} {a}, about {said}",
        )
    )
    x, y = (f"target.{axis}{sign}{size}*a.way.{axis}" for axis in "uv")
    return Correction(finish(draw, text, things), x, y)


def along_last(draw: Draw) -> Correction:
    """Go a length on, or back, along the last move: `two cm more`, `come back 2 cm`."""
    said, size = distance(draw)
    text, sign = draw.pick(exact_words.BACK_OR_ON)
    x, y = (f"target.{axis}{sign}{size}*last.way.{axis}" for axis in "uv")
    draft = finish(draw, text.format(said), {}, bare=1.0)
    return Correction(draft, x, y, 1)


def earlier_move(draw: Draw) -> Correction:
    """Repeat or take back a move that is not the last: `the first move once more`."""
    text, meaning = draw.pick(exact_words.EARLIER)
    sign, move = meaning[0], meaning[1:]
    x, y = (f"target.{axis}{sign}{move}.d{axis}" for axis in "uv")
    return Correction(finish(draw, text, {}, bare=1.0), x, y, 2)


def along_axis(draw: Draw) -> Correction:
    """Go along an axis of the picture, as engineers say it: `u minus 20`, `+5 px in v`."""
    digits, size = number(draw)
    if draw.chance(0.3):
        listed, expression = unit(draw)
        digits, size = with_unit(draw, digits, listed), expression.format(size)
    axis = draw.pick(("u", "v"))
    name = draw.pick(exact_words.AXIS_NAMES[axis])
    template, sign = draw.pick(exact_words.SIGNED)
    moved = f"target.{axis}{sign}{size}"
    x, y = (moved, "target.v") if axis == "u" else ("target.u", moved)
    draft = finish(draw, template.format(digits, name), {}, bare=0.7, verbs=words.MOVE_POINT)
    return Correction(draft, x, y)


def two_ways(draw: Draw) -> tuple[str, str]:
    """Return a way across and one along the picture, in either order."""
    across, along = draw.pick(("left", "right")), draw.pick(("up", "down"))
    return (across, along) if draw.chance(0.5) else (along, across)


def _directed(draw: Draw, amount: str, way: str) -> str:
    to = draw.pick(words.TO[way])
    return (f"{to} {amount}" if draw.chance(0.4) else f"{amount} {to}").strip()


def _to_both(draw: Draw, text: str, sizes: dict[str, str]) -> Correction:
    """Return the correction that goes so far in each of two ways, one along each axis."""
    x, y = "target.u", "target.v"
    for way, size in sizes.items():
        du, dv = WAYS[way]
        x, y = term(x, du, size), term(y, dv, size)
    return Correction(finish(draw, text, {}), x, y)
