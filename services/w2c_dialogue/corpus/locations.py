"""Where: on a thing, or somewhere relative to things, with the expressions of the point that is meant.

Directions are those of the picture: left is a smaller u, above and behind a smaller v. Distances
without a number are parts of the size of the object. `{A}`, `{B}`, `{C}` are objects in order of
mention.
"""

from collections.abc import Callable
from dataclasses import dataclass

from w2c_dialogue.corpus.draw import Draw


@dataclass(frozen=True)
class Location:
    """A phrase of place. `x` and `y` are empty where a thing itself is meant (absolute)."""

    text: str
    x: str = ""
    y: str = ""
    scene: str = ""
    """The facts about the boxes under which this is right; empty: any."""


LEFT = (
    "left of", "to the left of", "on the left of", "left from", "to the left from", "at the left of", "to the left side of",
    "left to", "on the left hand side of", "to the left-hand side of",
)  # fmt: skip
RIGHT = tuple(text.replace("left", "right") for text in LEFT)
BEHIND = (
    "behind", "in back of", "above", "beyond", "farther away than", "further back than", "past", "just past", "at the rear of",
    "higher than", "up from", "further than",
)  # fmt: skip
FRONT = (
    "in front of", "below", "under", "underneath", "beneath", "nearer than", "lower than", "on this side of", "before",
    "closer to you than", "in the front of", "down from",
)  # fmt: skip
BESIDE = (
    "next to", "beside", "near", "by", "close to", "alongside", "adjacent to", "right next to", "near to", "at the side of",
    "in the vicinity of", "right beside", "just next to", "somewhere near", "around",
)  # fmt: skip
ON = (
    "on", "on", "on", "on top of", "on top of", "onto", "against", "at", "over", "upon", "in the middle of", "on the surface of", "in the center of",
    "in the centre of", "on the top of", "ontop of", "right on", "directly on", "atop", "to", "on the middle of", "flat on", "somewhere on",
)  # fmt: skip
BETWEEN = (
    "between {X} and {Y}", "in between {X} and {Y}", "in the middle of {X} and {Y}", "halfway between {X} and {Y}", "midway between {X} and {Y}",
    "in the space between {X} and {Y}", "somewhere between {X} and {Y}", "in the gap between {X} and {Y}", "right between {X} and {Y}",
)  # fmt: skip
SIDES: dict[str, tuple[tuple[str, ...], int, int]] = {
    "left": (LEFT, -1, 0),
    "right": (RIGHT, 1, 0),
    "behind": (BEHIND, 0, -1),
    "front": (FRONT, 0, 1),
}
EDGES = {
    "left": (-1, 0), "right": (1, 0), "top": (0, -1), "upper": (0, -1), "back": (0, -1), "far": (0, -1), "rear": (0, -1),
    "bottom": (0, 1), "lower": (0, 1), "front": (0, 1), "near": (0, 1), "closest": (0, 1),
}  # fmt: skip
EDGE_WORDS = ("edge", "side", "end", "part", "border", "half")
CORNERS = {
    "top left": (-1, -1), "top right": (1, -1), "bottom left": (-1, 1), "bottom right": (1, 1), "upper left": (-1, -1), "upper right": (1, -1),
    "lower left": (-1, 1), "lower right": (1, 1), "front left": (-1, 1), "front right": (1, 1), "back left": (-1, -1), "back right": (1, -1),
    "far left": (-1, -1), "far right": (1, -1), "near left": (-1, 1), "near right": (1, 1), "left front": (-1, 1), "right back": (1, -1),
}  # fmt: skip
NUMBER_WORDS = {
    "one": "1", "two": "2", "three": "3", "four": "4", "five": "5", "six": "6", "seven": "7", "eight": "8", "nine": "9", "ten": "10",
    "twelve": "12", "fifteen": "15", "twenty": "20", "thirty": "30", "forty": "40", "fifty": "50", "a couple of": "2", "a few": "3", "half a": "0.5",
}  # fmt: skip


def beside(letter: str, du: int, dv: int, size: str) -> tuple[str, str]:
    """Return the point outside a box in a direction; `size` = expression of the distance from its edge."""
    sizes = {True: size.format(f"{letter}.width"), False: size.format(f"{letter}.height")}
    x = {0: f"{letter}.u", -1: f"{letter}.left-{sizes[True]}", 1: f"{letter}.right+{sizes[True]}"}[
        du
    ]
    y = {
        0: f"{letter}.v",
        -1: f"{letter}.top-{sizes[False]}",
        1: f"{letter}.bottom+{sizes[False]}",
    }[dv]
    return x, y


def inside(letter: str, du: int, dv: int) -> tuple[str, str]:
    """Return the point inside a box near an edge or a corner."""
    x = {
        0: f"{letter}.u",
        -1: f"{letter}.left+0.15*{letter}.width",
        1: f"{letter}.right-0.15*{letter}.width",
    }[du]
    y = {
        0: f"{letter}.v",
        -1: f"{letter}.top+0.15*{letter}.height",
        1: f"{letter}.bottom-0.15*{letter}.height",
    }[dv]
    return x, y


def distance(draw: Draw) -> tuple[str, str]:
    """Return the words of a length and its expression in pixels; `cm` is the scale of the scene."""
    if draw.chance(0.35):
        word = draw.pick(tuple(NUMBER_WORDS))
        number = NUMBER_WORDS[word]
    elif draw.chance(0.1):
        number = word = f"{draw.below(20)}.{1 + draw.below(9)}"
    else:
        number = word = str(1 + draw.below(30) if draw.chance(0.7) else 5 * (1 + draw.below(60)))
    unit = draw.below(10)
    if unit < 5:
        glued = word[0].isdigit() and draw.chance(0.3)
        name = draw.pick(("cm", "cm", "centimeters", "centimetres", "centimeter", "cms"))
        return (f"{word}cm" if glued else f"{word} {name}"), f"{number}*cm"
    if unit == 5:
        return f"{word} {draw.pick(('mm', 'millimeters', 'millimetres'))}", f"0.1*{number}*cm"
    if unit == 6:
        return f"{word} {draw.pick(('inches', 'inch'))}", f"2.54*{number}*cm"
    return f"{word} {draw.pick(('pixels', 'px', 'pixel', 'pixels'))}", number


def _side(draw: Draw) -> Location:
    phrases, du, dv = SIDES[draw.pick(tuple(SIDES))]
    roll, text = draw.uniform(), draw.pick(phrases)
    if roll < 0.6:
        return Location(f"{text} {{A}}", *beside("a", du, dv, "0.5*{}"))
    if roll < 0.75:
        near = draw.pick(
            (
                "just",
                "slightly",
                "a bit",
                "a little",
                "immediately",
                "directly",
                "right",
                "closely",
                "a tiny bit",
            )
        )
        return Location(f"{near} {text} {{A}}", *beside("a", du, dv, "0.25*{}"))
    if roll < 0.85:
        far = draw.pick(("far", "well", "way", "a lot", "far away to the side,", "quite far"))
        return Location(f"{far} {text} {{A}}", *beside("a", du, dv, "1.5*{}"))
    words, size = distance(draw)
    return Location(f"{words} {text} {{A}}", *beside("a", du, dv, size))


def _diagonal(draw: Draw) -> Location:
    first, second = draw.pick(
        (("left", "front"), ("right", "front"), ("left", "behind"), ("right", "behind"))
    )
    if draw.chance(0.5):
        first, second = second, first
    plain = {
        "left": ("to the left", "left", "on the left"), "right": ("to the right", "right", "on the right"),
        "front": ("in front", "below", "down"), "behind": ("behind", "above", "up"),
    }  # fmt: skip
    du = SIDES[first][1] + SIDES[second][1]
    dv = SIDES[first][2] + SIDES[second][2]
    text = f"{draw.pick(plain[first])} and {draw.pick(SIDES[second][0])} {{A}}"
    return Location(text, *beside("a", du, dv, "0.5*{}"))


def _beside(draw: Draw) -> Location:
    text = draw.pick(BESIDE)
    scene = draw.pick(("A left", "A middle", "A right"))
    du = -1 if scene == "A right" else 1
    size = "0.5*{}"
    if draw.chance(0.1):
        words, size = distance(draw)
        text = f"{words} {draw.pick(('from', 'away from', 'next to', 'beside'))}"
    return Location(f"{text} {{A}}", *beside("a", du, 0, size), scene)


def _edge(draw: Draw) -> Location:
    if draw.chance(0.6):
        name = draw.pick(tuple(EDGES))
        du, dv = EDGES[name]
        words = draw.pick(EDGE_WORDS)
    else:
        name = draw.pick(tuple(CORNERS))
        du, dv = CORNERS[name]
        words = draw.pick(("corner", "corner", "corner", "part", "quarter"))
    lead = draw.pick(
        ("on the", "at the", "on the", "near the", "the", "towards the", "close to the")
    )
    return Location(f"{lead} {name} {words} of {{A}}", *inside("a", du, dv))


def _between(draw: Draw) -> Location:
    text = draw.pick(BETWEEN).replace("{X}", "{A}").replace("{Y}", "{B}")
    scene = draw.pick(("A left of B", "A right of B", "A above B", "A below B"))
    x, y = "(a.u+b.u)/2", "(a.v+b.v)/2"
    if "left" in scene:
        x = "(a.right+b.left)/2"
    elif "right" in scene:
        x = "(a.left+b.right)/2"
    elif "above" in scene:
        y = "(a.bottom+b.top)/2"
    else:
        y = "(a.top+b.bottom)/2"
    if draw.chance(0.08):
        closer, share = draw.pick((("closer to {A}", "0.25"), ("nearer to {A}", "0.25")))
        return Location(f"{text}, {closer}", f"a.u+{share}*(b.u-a.u)", f"a.v+{share}*(b.v-a.v)")
    return Location(text, x, y, scene)


def _two_sides(draw: Draw) -> Location:
    across = draw.pick(("left", "right"))
    along = draw.pick(("behind", "front"))
    x = beside("a", SIDES[across][1], 0, "0.5*{}")[0]
    y = beside("b", 0, SIDES[along][2], "0.5*{}")[1]
    text = f"{draw.pick(SIDES[across][0])} {{A}} and {draw.pick(SIDES[along][0])} {{B}}"
    if draw.chance(0.3):
        text = f"{draw.pick(SIDES[across][0])} {{A}}, {draw.pick(('at the height of', 'level with', 'in line with'))} {{B}}"
        y = "b.v"
    return Location(text, x, y)


def _three(draw: Draw) -> Location:
    lead = draw.pick(("between", "in the middle of", "in between", "in the center of", "among"))
    return Location(f"{lead} {{A}}, {{B}} and {{C}}", "(a.u+b.u+c.u)/3", "(a.v+b.v+c.v)/3")


def _away(draw: Draw) -> Location:
    text = draw.pick(("from {A} to {B}", "between {A} and {B}", "of the way from {A} to {B}"))
    word, share = draw.pick(
        (
            ("one third", "0.33"),
            ("a third", "0.33"),
            ("a quarter", "0.25"),
            ("two thirds", "0.67"),
            ("three quarters", "0.75"),
        )
    )
    text = text if text.startswith("of") else f"of the way {text}"
    return Location(f"{word} {text}", f"a.u+{share}*(b.u-a.u)", f"a.v+{share}*(b.v-a.v)")


_KINDS: tuple[tuple[float, Callable[[Draw], Location]], ...] = (
    (0.44, _side), (0.06, _diagonal), (0.13, _beside), (0.13, _edge), (0.15, _between), (0.04, _two_sides), (0.03, _three), (0.02, _away),
)  # fmt: skip


def relative(draw: Draw) -> Location:
    """Return a place that is described relative to things."""
    roll = draw.uniform()
    for share, make in _KINDS:
        if roll < share:
            return make(draw)
        roll -= share
    return _side(draw)


def absolute(draw: Draw) -> Location:
    """Return a place on a thing."""
    return Location(f"{draw.pick(ON)} {{A}}")
