"""Corrections: how people push a point about, and the expressions of where it goes.

A bit is 20 px, a step without size 40 px, a lot 100 px. Behind and farther are up in the picture,
nearer and in front are down (`u` grows to the right, `v` grows downwards).
"""

from dataclasses import dataclass

from w2c_dialogue.corpus import locations
from w2c_dialogue.corpus.draft import Draft
from w2c_dialogue.corpus.draw import Draw
from w2c_dialogue.corpus.phrases import article, phrase
from w2c_dialogue.corpus.things import names

TINY = (
    "a tiny bit",
    "a hair",
    "a touch",
    "a smidge",
    "just a tad",
    "a tad",
    "very slightly",
    "a teeny bit",
    "ever so slightly",
)
SMALL = (
    "a bit", "a bit", "a bit", "a little", "a little bit", "slightly", "somewhat", "just a bit", "just a little", "a bit more",
    "a little more", "a small step", "a small amount", "a little bit more",
)  # fmt: skip
PLAIN = ("", "", "", "", "more", "further", "some more", "a step", "again", "one step", "farther")
LARGE = (
    "a lot", "a lot more", "much", "much more", "way", "far", "a great deal", "much further", "way more", "considerably", "a big step",
    "a good deal", "significantly", "way further", "quite a lot", "a whole lot",
)  # fmt: skip
STEPS = (("10", TINY, 0.08), ("20", SMALL, 0.32), ("40", PLAIN, 0.45), ("100", LARGE, 0.15))
TO = {
    "left": ("left", "to the left", "to the left", "leftwards", "leftward", "to your left", "towards the left", "on the left", "to left", "left side", "toward the left", "to the left side"),
    "right": ("right", "to the right", "to the right", "rightwards", "rightward", "to your right", "towards the right", "on the right", "to right", "right side", "toward the right", "to the right side"),
    "up": ("up", "upwards", "higher", "up", "to the top", "towards the top", "further away", "away from you", "farther away", "upward", "further back", "higher up", "deeper", "to the back", "forward", "forwards", "ahead", "towards the back"),
    "down": ("down", "downwards", "lower", "down", "to the bottom", "towards the bottom", "closer to you", "nearer", "towards you", "downward", "closer to yourself", "lower down", "towards the robot", "to the front", "backwards", "backward", "towards the front", "closer to the robot"),
}  # fmt: skip
WAYS = {"left": (-1, 0), "right": (1, 0), "up": (0, -1), "down": (0, 1)}
MOVE = names("""
move, go, shift, slide, move it, shift it, slide it, move the target, move the point, move your
hand, push it, nudge it, bring it, put it, go, move the contact, move the dot, adjust it, place
it, take it, drag it, shift the point, move the marker, shift the target, move that, nudge, drag,
scoot, scooch it, displace it, relocate it, translate, correct it, move the goal, it should be, it
needs to be, should be, needs to go, I want it, make it, set it, the point should go, move the
hand, move your right hand, move your left hand, move the position
""")
MOVE_POINT = tuple(
    f"{verb} {what}"
    for verb in ("move", "shift", "slide", "drag", "nudge", "bring", "relocate", "push")
    for what in (
        "it",
        "it",
        "the target",
        "the point",
        "the dot",
        "the contact",
        "the marker",
        "that",
        "the contact point",
    )
)
"""Verbs that speak of the point on the screen: "put it on the cup" would be a new instruction."""
LEADS = names("""
no, no no, please, can you, could you, now, ok now, but, almost, not quite, nearly there, good
but, not there, hmm, wait, ok but, yes but, close but, almost there, a correction:, I'd say, now
please, and, then, still, no please, that's good but, just, almost perfect, good direction, so
close
""")
TAILS = names("""
please, now, thanks, again, ok, from there, from here, in the picture, in the image, on the image,
if possible, from where it is, instead, of where it is now, than that, carefully, robot, from this
point, would be better, thank you, would be perfect
""")


@dataclass(frozen=True)
class Correction:
    """A correction and the expressions of the new target."""

    draft: Draft
    x: str
    y: str
    needs_past: int = 0
    """How many earlier corrections it speaks of"""


def _term(symbol: str, sign: int, size: str) -> str:
    """Return `target.u+40`, or the symbol alone where the sign is 0."""
    return symbol + {0: "", 1: "+", -1: "-"}[sign] + (size if sign else "")


def _step(draw: Draw) -> tuple[str, str]:
    """Return words of a size and its pixels."""
    roll = draw.uniform()
    for size, words, share in STEPS:
        if roll < share:
            return draw.pick(words), size
        roll -= share
    return "", "40"


def _sized_direction(draw: Draw, way: str) -> tuple[str, str]:
    """Return words such as `a bit to the left` and the size in pixels."""
    to = draw.pick(TO[way])
    if draw.chance(0.25):
        words, size = locations.distance(draw)
        return draw.pick(
            (f"{words} {to}", f"{to} {words}", f"{to} by {words}", f"by {words} {to}")
        ), size
    if draw.chance(0.05):
        number = 2 + draw.below(4)
        word = draw.pick((str(number), ("two", "three", "four", "five")[number - 2]))
        return f"{word} steps {to}", f"{number}*40"
    words, size = _step(draw)
    order = (f"{words} {to}", f"{words} {to}", f"{to} {words}", f"{words} {to}")
    return draw.pick(order).strip(), size


def _finish(
    draw: Draw,
    template: str,
    phrases: dict[str, str],
    *,
    bare: float = 0.35,
    verbs: tuple[str, ...] = MOVE,
) -> Draft:
    """Put a verb in front, and what people say around it."""
    draft = Draft()
    if draw.chance(0.22):
        draft.add(draw.pick(LEADS))
        if draw.chance(0.5):
            draft.words[-1] = draft.words[-1].rstrip(",:") + ","
    if not draw.chance(bare):
        draft.add(draw.pick(verbs))
    draft.fill(template, phrases)
    if draw.chance(0.1):
        draft.add(draw.pick(TAILS))
    return draft


def _direction(draw: Draw) -> Correction:
    way = draw.pick(tuple(WAYS))
    words, size = _sized_direction(draw, way)
    du, dv = WAYS[way]
    return Correction(
        _finish(draw, words, {}), _term("target.u", du, size), _term("target.v", dv, size)
    )


def _diagonal(draw: Draw) -> Correction:
    across, along = draw.pick(("left", "right")), draw.pick(("up", "down"))
    first, second = (across, along) if draw.chance(0.5) else (along, across)
    if draw.chance(0.4):
        words, size = _step(draw)
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
        text, sizes = f"{words} {joined}".strip(), {first: size, second: size}
    else:
        text_first, size_first = _sized_direction(draw, first)
        text_second, size_second = _sized_direction(draw, second)
        link = draw.pick((" and ", ", ", " and then ", ", then ", " and also ", " then "))
        text, sizes = f"{text_first}{link}{text_second}", {first: size_first, second: size_second}
    return Correction(
        _finish(draw, text, {}),
        _term("target.u", WAYS[across][0], sizes[across]),
        _term("target.v", WAYS[along][1], sizes[along]),
    )


AGAIN_AS = {
    "1": names("""
again, more, same again, once more, the same again, one more time, do that again, keep going, continue, further, some more, repeat that, another step, and again, go on, keep moving, do it again, the same amount again, a step further, same thing again, further still, still more, not enough, that's not enough, more please, one more, carry on, repeat, same direction, continue that way
"""),
    "2": names("""
twice as much, twice as much as before, move twice as much, now move twice as much as before, double that, twice that, two times that, do twice that, the same but double, twice the distance, double the distance, now twice as far, twice as far, go twice as far as before, and now double it, 2 times more, move two times as much, twice as much again, twice that distance, do that twice, double the last move, twice the last move
"""),
    "3": names("three times as much, three times that, triple that, three times as far, 3 times as much as before, thrice that, move three times the distance"),
    "0.5": names("""
half of that, half as much, half that, half as much as before, move half as much, only half of that, half the distance, now half of it, a bit more of the same, half that again, half as far, half of the last move, a bit more, a little more, a little further, slightly further, a bit further, just a little more, a little bit further, a little bit more, half a step more
"""),
    "-0.5": names("""
too far, too much, that's too much, that was too far, you went too far, a bit less, less, a little less, back by half, half way back, go back half, undo half of it, not so far, not that far, not that much, that's a bit too much, a little back, go back a bit, go back a little, back a bit, slightly too far, overshot, you overshot, it's too far, way too much, half back, not so much
"""),
    "-1": names("""
back, go back, undo, undo that, go back to where it was, undo the last move, cancel that, take that back, back to the previous position, revert, revert that, previous position, move back, put it back, back to where it was before, no go back, undo it, as before, like before, where it was before, return to the previous point, the last one was better, it was better before, before was better, back where you were, undo the last correction, opposite direction, move in the opposite direction, the other direction, in the other direction, step back, return
"""),
    "-2": (
        "no, the other way", "other way", "wrong direction", "wrong way", "no, the opposite direction", "the opposite",
        "that's the wrong direction", "no the other direction", "I meant the other way", "the other way please",
        "not that way, the other way", "the other way around", "opposite, not that way", "you moved the wrong way",
        "you went the wrong way", "no, other side", "wrong side", "it went the wrong way", "no, the other side",
        "no, in the opposite direction", "no, wrong direction", "the other way", "not this way, the other", "the reverse",
    ),
}  # fmt: skip


def _history(draw: Draw) -> Correction:
    roll = draw.uniform()
    if roll < 0.72:
        factor = draw.pick(tuple(AGAIN_AS))
        text = draw.pick(AGAIN_AS[factor])
        terms = {"1": "+last.{}", "-1": "-last.{}"}.get(
            factor, ("" if factor[0] == "-" else "+") + factor + "*last.{}"
        )
        return Correction(
            _finish(draw, text, {}, bare=1.0),
            "target.u" + terms.format("du"),
            "target.v" + terms.format("dv"),
            1,
        )
    if roll < 0.84:
        way = draw.pick(tuple(WAYS))
        factor, text = draw.pick((
            ("2", "twice as much {}"), ("2", "{} twice as much"), ("2", "double that {}"), ("0.5", "half of that {}"), ("0.5", "{} half as much"), ("1", "the same amount {}"),
            ("1", "as much {}"), ("1", "{} by the same amount"), ("3", "three times as much {}"), ("2", "twice as far {}"), ("0.5", "half as far {}"),
        ))  # fmt: skip
        size = "last.size" if factor == "1" else f"{factor}*last.size"
        words = text.format(draw.pick(TO[way])) + draw.pick(("", " as before", "", " as last time"))
        du, dv = WAYS[way]
        return Correction(
            _finish(draw, words, {}), _term("target.u", du, size), _term("target.v", dv, size), 1
        )
    if roll < 0.92:
        text = draw.pick(START)
        return Correction(_finish(draw, text, {}, bare=1.0), "start.u", "start.v", 1)
    text = draw.pick(UNDO_TWO)
    return Correction(
        _finish(draw, text, {}, bare=1.0),
        "target.u-last.du-moves[-2].du",
        "target.v-last.dv-moves[-2].dv",
        2,
    )


START = names("""
back to the start, go back to the beginning, the first position, back to the first point, undo
everything, undo all, reset, start over, back to the original position, the original point, where
it was at first, the very first one, go back to the initial position, return to the start, reset
the target, initial point, put it back where it was at the beginning, undo all corrections, forget
all corrections, the first one was better, back to square one, to where we started
""")
UNDO_TWO = names("""
undo the last two, undo twice, undo the last two moves, go back two steps, take back the last two,
two steps back, undo both, revert the last two corrections, back two moves, go back twice
""")
STAY = names("""
no, stop, wait, hold on, not yet, nope, cancel, no way, don't, don't move, no don't, that's wrong,
wrong, this is not right, not good, not there, not ok, no that's not it, I don't like it, bad, hmm
no, not like this, not correct, incorrect, nah, no good, don't do it, that is not what I want, not
sure, let me think, one moment, wait a second, abort, stop it, do nothing, no thanks, not really,
that's not right, it's not good yet, not perfect, not quite, that won't work, it isn't right,
absolutely not, never
""")


def _object(draw: Draw) -> Correction:
    things = {"A": phrase(draw, surface=draw.chance(0.5))}
    a = f"{article(draw)} {{A}}".strip()
    kind = draw.below(12)
    if kind < 3:
        words, share = draw.pick((
            ("closer to", "0.5"), ("nearer to", "0.5"), ("towards", "0.5"), ("toward", "0.5"), ("a bit closer to", "0.25"), ("a little closer to", "0.25"), ("a bit towards", "0.25"), ("slightly closer to", "0.25"),
            ("much closer to", "0.75"), ("a lot closer to", "0.75"), ("more towards", "0.5"), ("nearer", "0.5"), ("a bit nearer to", "0.25"), ("in the direction of", "0.5"), ("halfway to", "0.5"),
        ))  # fmt: skip
        return Correction(
            _finish(draw, f"{words} {a}", things),
            f"target.u+{share}*(a.u-target.u)",
            f"target.v+{share}*(a.v-target.v)",
        )
    if kind == 3:
        words, share = draw.pick((
            ("away from", "0.5"), ("further away from", "0.5"), ("farther from", "0.5"), ("further from", "0.5"), ("a bit away from", "0.25"), ("a bit further from", "0.25"), ("a little away from", "0.25"), ("far away from", "1"), ("much further from", "1"), ("less close to", "0.25"),
        ))  # fmt: skip
        return Correction(
            _finish(draw, f"{words} {a}", things),
            f"target.u-{share}*(a.u-target.u)",
            f"target.v-{share}*(a.v-target.v)",
        )
    if kind < 6:
        return _edge(draw, a, things)
    if kind == 6:
        words = draw.pick(
            (
                "onto",
                "on",
                "on top of",
                "to the center of",
                "to the middle of",
                "to",
                "in the middle of",
                "to the centre of",
                "all the way to",
                "right on",
                "exactly on",
                "over",
                "up to",
            )
        )
        return Correction(
            _finish(draw, f"{words} {a}", things, bare=0.0, verbs=MOVE_POINT), "a.u", "a.v"
        )
    if kind < 9:
        return _beside(draw, a, things)
    if kind == 9:
        return _align(draw, a, things)
    if kind == 10:
        return _object_sized(draw, a, things)
    return _between(draw)


def _edge(draw: Draw, a: str, things: dict[str, str]) -> Correction:
    if draw.chance(0.65):
        name = draw.pick(tuple(locations.EDGES))
        du, dv = locations.EDGES[name]
        what = draw.pick(("edge", "edge", "side", "end", "border"))
    else:
        name = draw.pick(tuple(locations.CORNERS))
        du, dv = locations.CORNERS[name]
        what = "corner"
    lead = draw.pick(
        (
            "to the",
            "to the",
            "on the",
            "at the",
            "onto the",
            "towards the",
            "closer to the",
            "up to the",
        )
    )
    form = f"{lead} {name} {what} of {a}"
    x, y = locations.inside("a", du, dv)
    return Correction(_finish(draw, form, things, bare=0.2, verbs=MOVE_POINT), x, y)


def _beside(draw: Draw, a: str, things: dict[str, str]) -> Correction:
    phrases, du, dv = locations.SIDES[draw.pick(tuple(locations.SIDES))]
    text = draw.pick(phrases)
    size = "0.5*{}"
    if draw.chance(0.2):
        words, size = locations.distance(draw)
        text = f"{words} {text}"
    x, y = locations.beside("a", du, dv, size)
    return Correction(_finish(draw, f"{text} {a}", things, bare=0.0, verbs=MOVE_POINT), x, y)


def _align(draw: Draw, a: str, things: dict[str, str]) -> Correction:
    across = draw.pick(
        (
            "at the same height as",
            "level with",
            "to the height of",
            "to the same level as",
            "in line horizontally with",
            "align horizontally with",
            "as high as",
        )
    )
    along = draw.pick(
        (
            "straight below",
            "directly under",
            "in line vertically with",
            "align vertically with",
            "straight above",
            "straight in front of",
            "in the same column as",
        )
    )
    if draw.chance(0.5):
        return Correction(_finish(draw, f"{across} {a}", things), "target.u", "a.v")
    return Correction(_finish(draw, f"{along} {a}", things), "a.u", "target.v")


def _object_sized(draw: Draw, a: str, things: dict[str, str]) -> Correction:
    way = draw.pick(tuple(WAYS))
    du, dv = WAYS[way]
    measure = "width" if du else "height"
    words, share = draw.pick(
        (
            ("half the", "0.5*"),
            ("half a", "0.5*"),
            ("one", ""),
            ("the", ""),
            ("two", "2*"),
            ("twice the", "2*"),
            ("a", ""),
            ("a quarter of the", "0.25*"),
            ("one and a half", "1.5*"),
        )
    )
    text = draw.pick(
        (
            f"by {words} {measure} of {a} {{to}}",
            f"{words} {measure} of {a} {{to}}",
            f"{{to}} by {words} {measure} of {a}",
        )
    )
    text = text.replace("{to}", draw.pick(TO[way]))
    size = f"{share}a.{measure}"
    return Correction(
        _finish(draw, text, things, bare=0.2),
        _term("target.u", du, size),
        _term("target.v", dv, size),
    )


def _between(draw: Draw) -> Correction:
    things = {"A": phrase(draw), "B": phrase(draw)}
    link = draw.pick(
        ("between", "in between", "halfway between", "midway between", "in the middle of")
    )
    text = f"{link} {article(draw)} {{A}} and {article(draw)} {{B}}"
    return Correction(
        _finish(draw, " ".join(text.split()), things, bare=0.0, verbs=MOVE_POINT),
        "(a.u+b.u)/2",
        "(a.v+b.v)/2",
    )


def _pixels(draw: Draw) -> Correction:
    u, v = draw.below(1280), draw.below(720)
    text = draw.pick(
        (
            "to pixel {} {}",
            "to {}, {}",
            "to {} {}",
            "to x {} y {}",
            "to ({}, {})",
            "to pixel {}, {}",
            "to x={} y={}",
            "at {} {}",
            "to the pixel {} {}",
            "exactly at {}, {}",
            "to coordinates {} {}",
        )
    )
    return Correction(_finish(draw, text.format(u, v), {}, bare=0.1), str(u), str(v))


def correction(draw: Draw) -> Correction:
    """Return one correction."""
    roll = draw.uniform()
    for share, make in (
        (0.37, _direction),
        (0.12, _diagonal),
        (0.18, _history),
        (0.25, _object),
        (0.02, _pixels),
    ):
        if roll < share:
            return make(draw)
        roll -= share
    draft = Draft()
    draft.add(draw.pick(STAY))
    return Correction(draft, "target.u", "target.v")
