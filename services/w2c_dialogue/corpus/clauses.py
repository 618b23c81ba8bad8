"""Names of things by their use, or by a clause: `thing you hang coats on`, `what keeps it open`.

The whole clause is the name: cut short, it names something else, or nothing.
"""

from collections.abc import Callable

from w2c_dialogue.corpus.draw import Draw
from w2c_dialogue.corpus.things import COLOURS, SIZES, names

HEADS = names("""
thing, thing, thing, one, one, object, thingy, tool, whatsit, gadget, bit, contraption, device,
item, piece
""")
_USES = tuple(
    tuple(use.split("/"))
    for use in names("""
water/watering/the flowers/with, hang/hanging/coats/on, wipe/wiping/your feet/on,
cut/cutting/the bread/with, sweep/sweeping/the floor/with, boil/boiling/water/in,
dry/drying/the dishes/with, hammer/hammering/nails in/with, keep/keeping/the milk/in,
put/putting/the rubbish/in, carry/carrying/the shopping/in, sit/sitting/down/on,
open/opening/bottles/with, clean/cleaning/the windows/with, stir/stirring/the soup/with,
fry/frying/eggs/in, weigh/weighing/the flour/with, dig/digging/holes/with, catch/catching/fish/with,
stand/standing/umbrellas/in, lock/locking/the gate/with, paint/painting/the wall/with,
tie/tying/the boat/to, rest/resting/your elbow/on,
write/writing/letters/with, measure/measuring/the boards/with, pour/pouring/the tea/from,
store/storing/old letters/in, play/playing/music/on, mix/mixing/the colours/on,
climb/climbing/up to the loft/with, put/putting/hot pans/on, charge/charging/the phone/with,
grate/grating/the cheese/with, pull/pulling/corks/with, hide/hiding/the keys/under,
comb/combing/the dog/with, light/lighting/the stove/with, pin/pinning/notes/to, feed/feeding/the
cat/from, chop/chopping/onions/on, strain/straining/the rice/with, wash/washing/your hands/in,
look/looking/at the stars/through, wrap/wrapping/the presents/in, hold/holding/the wood/in
""")
)
"""Verb, the same with -ing, object, preposition"""
_BARE_USES = tuple(
    tuple(use.split("/"))
    for use in names("""
drink/drinking/from, drink/drinking/out of, eat/eating/from, eat/eating/off, write/writing/with,
write/writing/in, draw/drawing/with, play/playing/with, sit/sitting/on, stand/standing/on,
sleep/sleeping/on, dig/digging/with, cut/cutting/with, cook/cooking/in, cook/cooking/with,
hammer/hammering/with, read/reading/from, clean/cleaning/with, sweep/sweeping/with, type/typing/on,
swim/swimming/in, dry off/drying off/with, tidy up/tidying up/with, climb/climbing/on
""")
)
"""The same without an object"""
_DOES = names("""
keeps the door open, lights the room, tells the time, holds the books up, makes the noise, stops the
papers flying away, holds the lid down, keeps the soup hot, cools the room, makes the toast, opens
the cans, catches the drips, hides the cables, blows warm air, turns the pages, props the shelf up,
rings at noon, shows the temperature, keeps the rain off, sharpens the knives, collects the dust,
carries the cables, covers the hole, pumps the water, spins all day, moves the belt, sucks up the
dirt, holds the curtain back, plays the records, beeps every morning, guards the drain, lifts the
car, feeds the printer, blocks the way, smells of coffee, squeaks when it rains, fell off the wall
""")
_HAS = names("""
with the holes in, with the holes in it, with all the buttons on, with the crack in, with the dent
in it, with a ribbon around it, with writing on, with the stripes on it, with water in, with nothing
in, with the flap on top, with the cable coming out, with the leaves hanging down, with the lid off,
with the numbers on, with the drawers in, with its door open, with two ears on it, with the long
neck, with the hole through the middle, with the cloth over it, with the plants on, with the wheels
underneath, with the pointy end, with the dog on it, with the light on
""")
_WHEN = names("""
every morning, when it rains, in the evening, after dinner, on Sundays, before bed, all day, in
winter, when guests come, for breakfast, for their coffee, at night, every time, when nobody looks,
for the children, in the garden, at work, all the time, in a hurry, when the power fails, as
soon as it gets dark, once a year, from time to time
""")
_WHO = ("you", "you", "we", "they", "people", "I")
_ANOTHER = names(
    "other, other, other, next, last, second, first, third, middle, lower, upper, nearer"
)


def use_phrase(draw: Draw) -> str:
    """Return a name without article: `thing to water the flowers with`."""
    name = _use(draw)
    if draw.chance(0.12):
        return f"{name} {draw.pick(_WHEN)}"
    if draw.chance(0.08) and " that " in name:
        return f"{name} and {draw.pick(_DOES)}"
    return name


def _use(draw: Draw) -> str:
    head = draw.pick(HEADS)
    if draw.chance(0.15):
        head = f"{draw.pick(draw.pick((COLOURS, SIZES)))} {head}"
    roll = draw.uniform()
    if roll < 0.25:
        return f"{head} {draw.pick(_HAS)}"
    if roll < 0.5:
        return f"{head} {draw.pick(('that', 'that', 'which'))} {draw.pick(_DOES)}"
    if roll < 0.6:
        verb, doing, preposition = draw.pick(_BARE_USES)
        return draw.pick(
            (
                f"{head} to {verb} {preposition}",
                f"{head} {draw.pick(_WHO)} {verb} {preposition}",
                f"{head} for {doing}",
            )
        )
    verb, doing, what, preposition = draw.pick(_USES)
    return draw.pick(
        (
            f"{head} to {verb} {what} {preposition}",
            f"{head} {draw.pick(_WHO)} {verb} {what} {preposition}",
            f"{head} that {draw.pick(_WHO)} {verb} {what} {preposition}",
            f"{head} for {doing} {what} {preposition}",
            f"{head} for {doing} {what}",
            f"{head} used to {verb} {what}",
        )
    )


def what_phrase(draw: Draw) -> str:
    """Return a name that takes no article: `what keeps the door open`."""
    word = draw.pick(("what", "what", "what", "whatever"))
    if draw.chance(0.5):
        return f"{word} {draw.pick(_DOES)}"
    verb, _, what, preposition = draw.pick(_USES)
    return f"{word} {draw.pick(_WHO)} {verb} {what} {preposition}"


def one_phrase(draw: Draw) -> str:
    """Return a name that only tells which: `other one`, `blue one`."""
    return f"{draw.pick(draw.pick((_ANOTHER, _ANOTHER, COLOURS, SIZES)))} one"


def same_kind(name: str, draw: Draw) -> str:
    """Return another name of the kind of one that is no noun; empty for a noun."""
    make = _maker(name)
    return make(draw) if make else ""


def is_noun(name: str) -> bool:
    """Say whether a name may stand for any other: it is no clause, and no `other one`."""
    return _maker(name) is None


def _maker(name: str) -> Callable[[Draw], str] | None:
    words = name.lower().split()
    if words[0] in ("what", "whatever"):
        return what_phrase
    if len(words) > 2 and words[0] in HEADS:
        return use_phrase
    return one_phrase if len(words) == 2 and words[1] == "one" else None
