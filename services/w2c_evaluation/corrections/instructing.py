"""Instructions that an operator could give: places that words name by what is in the picture.

Where a person expects the point: in the middle of what is named, a quarter in from a side, just
inside an edge or a corner, and a few centimetres away from a thing that it shall be beside.
"""

from collections.abc import Iterator
from dataclasses import dataclass
from math import hypot

from w2c_evaluation.corrections.eye import Eye, Look, Pixel, Thing, distance
from w2c_evaluation.corrections.saying import Chooser, Saying, sentence, spelled
from w2c_evaluation.corrections.voice import Corner, Side, Voice

NEAREST = 6
"""Of so many things people think when they look for one to name"""
DIVISIBLE_PX = 60.0
"""A thing that looks smaller has no sides worth naming"""
BESIDE_CM = 5.0
"""As far from a thing is beside it, when nothing is said"""
MOST_CM = 40
SIDE_SHARES: dict[Side, Pixel] = {
    "left": (0.25, 0.5),
    "right": (0.75, 0.5),
    "far": (0.5, 0.25),
    "near": (0.5, 0.75),
}
EDGE_SHARES: dict[Side, Pixel] = {
    "left": (0.06, 0.5),
    "right": (0.94, 0.5),
    "far": (0.5, 0.06),
    "near": (0.5, 0.94),
}
CORNER_SHARES: dict[Corner, Pixel] = {
    "far_left": (0.08, 0.08),
    "far_right": (0.92, 0.08),
    "near_left": (0.08, 0.92),
    "near_right": (0.92, 0.92),
}
AWAY: dict[Side, Pixel] = {
    "left": (-1.0, 0.0),
    "right": (1.0, 0.0),
    "far": (0.0, -1.0),
    "near": (0.0, 1.0),
}


@dataclass(frozen=True)
class Speaking:
    """Who speaks, about what."""

    voice: Voice
    look: Look
    eye: Eye
    chooser: Chooser
    unknown: frozenset[str] = frozenset()
    """Names that the robot did not find"""

    def name(self, thing: Thing) -> str | None:
        """Return what a thing is called now; None: the robot knows no name of it."""
        return self.chooser.name(thing, self.voice.colour, self.unknown)

    def nearest(self) -> list[Thing]:
        """Return the things that come to mind, the nearest to the ring first."""
        ring = self.look.ring
        return sorted(self.look.things, key=lambda thing: _away(thing, ring))[:NEAREST]

    def leaves(self, place: Pixel) -> float:
        """Return how far a place seems to be from the ring [px]."""
        return hypot(*self.eye.offset(place, self.look.ring))

    def length(self, centimetres: int) -> str:
        """Return a whole number of centimetres in words."""
        number = spelled(centimetres) if self.voice.spell_numbers else str(centimetres)
        return self.chooser.pick(self.voice.words.centimetres).format(n=number)

    def lengths(self, pixels: float, scale: float) -> Iterator[tuple[str, float]]:
        """Yield words for lengths that may be as long as something is, and how long they are.

        Args:
            pixels: As long as it seems.
            scale: How long a centimetre looks there [px].
        """
        for text, centimetres in self.voice.words.lengths.items():
            yield text, centimetres * scale
        number = round(pixels / scale)
        if 1 <= number <= MOST_CM:
            yield self.length(number), number * scale


def instructions(speaking: Speaking) -> Iterator[Saying]:
    """Yield an instruction of each meaning, in words that are drawn."""
    things = speaking.nearest()
    for thing in things:
        name = speaking.name(thing)
        if name is None:
            continue
        yield _place(speaking, "on", thing, name, thing.centre)
        if thing.furniture:
            continue
        yield from _parts(speaking, thing, name)
        yield from _beside(speaking, thing, name)
    yield from _between(speaking, [thing for thing in things if not thing.furniture])


def edge_of(thing: Thing, side: Side) -> Pixel:
    """Return where a person expects a point at an edge of a thing."""
    return thing.at(*EDGE_SHARES[side])


def corner_of(thing: Thing, corner: Corner) -> Pixel:
    """Return where a person expects a point on a corner of a thing."""
    return thing.at(*CORNER_SHARES[corner])


def divisible(thing: Thing) -> bool:
    """Tell whether a thing looks large enough to have sides."""
    return min(thing.right - thing.left, thing.bottom - thing.top) >= DIVISIBLE_PX


def _parts(speaking: Speaking, thing: Thing, name: str) -> Iterator[Saying]:
    """Yield the sides, edges and corners of a thing."""
    if not divisible(thing):
        return
    words, pick = speaking.voice.words, speaking.chooser.pick
    for side, share in SIDE_SHARES.items():
        text = pick(words.sides[side])
        yield _place(speaking, "side", thing, name, thing.at(*share), which=side, side=text)
        place = edge_of(thing, side)
        yield _place(speaking, "edge", thing, name, place, which=side, side=text)
    for corner in CORNER_SHARES:
        text = pick(words.corners[corner])
        place = corner_of(thing, corner)
        yield _place(speaking, "corner", thing, name, place, which=corner, corner=text)


def _beside(speaking: Speaking, thing: Thing, name: str) -> Iterator[Saying]:
    """Yield places around a thing."""
    for side, (across, down) in AWAY.items():
        border = thing.at(0.5 + 0.5 * across, 0.5 + 0.5 * down)
        out_u, out_v = speaking.eye.offset(border, speaking.look.ring)
        gap = across * out_u + down * out_v
        if gap <= 0.0:
            continue
        text = speaking.chooser.pick(speaking.voice.words.beside[side])
        usual = BESIDE_CM * thing.pixels_per_cm
        place = border[0] + across * usual, border[1] + down * usual
        yield _place(speaking, "beside", thing, name, place, which=side, beside=text)
        for length, pixels in speaking.lengths(gap, thing.pixels_per_cm):
            place = border[0] + across * pixels, border[1] + down * pixels
            yield _place(
                speaking,
                "beside_length",
                thing,
                name,
                place,
                which=f"{side} {length}",
                beside=text,
                length=length,
            )


def _between(speaking: Speaking, things: list[Thing]) -> Iterator[Saying]:
    """Yield the middle between two things."""
    for index, thing in enumerate(things):
        for other in things[index + 1 :]:
            name, second = speaking.name(thing), speaking.name(other)
            if name is None or second is None:
                continue
            u = 0.5 * (thing.centre[0] + other.centre[0])
            v = 0.5 * (thing.centre[1] + other.centre[1])
            yield _place(
                speaking, "between", thing, name, (u, v), which=other.names[0], other=second
            )


def _place(
    speaking: Speaking,
    kind: str,
    thing: Thing,
    name: str,
    place: Pixel,
    which: str = "",
    **words: str,
) -> Saying:
    texts: tuple[str, ...] = getattr(speaking.voice.instructions, kind)
    return Saying(
        text=sentence(speaking.chooser.pick(texts), thing=name, **words),
        kind=kind,
        meaning=f"{kind} {which} {thing.names[0]}",
        lands=place,
        leaves=speaking.leaves(place),
        thing=thing,
        name=name,
    )


def _away(thing: Thing, place: Pixel) -> float:
    """Return how far a place is outside of a thing, and a little for furniture [px]."""
    across = max(thing.left - place[0], 0.0, place[0] - thing.right)
    down = max(thing.top - place[1], 0.0, place[1] - thing.bottom)
    return hypot(across, down) + 1e-3 * distance(thing.centre, place)
