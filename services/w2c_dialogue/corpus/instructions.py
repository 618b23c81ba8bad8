"""First instructions: which hand or foot goes where, to lean or to reach."""

from dataclasses import dataclass

from w2c_dialogue.corpus import locations, relations
from w2c_dialogue.corpus.asides import with_aside
from w2c_dialogue.corpus.clauses import one_phrase
from w2c_dialogue.corpus.draft import Draft
from w2c_dialogue.corpus.draw import Draw
from w2c_dialogue.corpus.limbs import WITH, by_the_other, limb_phrase
from w2c_dialogue.corpus.phrases import article, phrase, place, plain_phrase
from w2c_dialogue.corpus.things import names

PUT = names("""
put, place, rest, set, lay, position, press, push, plant, support, brace, keep, hold, stick, drop,
lean, move, bring, get, make contact with, prop, park, settle, lower, apply, establish contact
with, anchor, steady, leave, fix, balance, place down, put down, set down, stabilize, land, make a
support contact with, create a contact with
""")
LEAN = names("""
lean, lean forward, support yourself, brace yourself, prop yourself, steady yourself, stand, step,
push, press, rest, put your weight, bear weight, hold yourself, stabilize yourself, balance
yourself, take support, find support, lean down, make contact, establish contact, get some
support, rest your weight, lean your body, create a contact, make a contact, push down, press
down, lean over, hold on, keep your balance, hold yourself up, put some weight, shift your weight,
transfer your weight, bend forward and lean
""")
REACH_OBJECT = names("""
reach for, grab, take, get, fetch, touch, pick up, go for, grasp, reach out to, pick, catch, tap,
poke, reach, reach towards, reach toward, reach out for, reach over to, seize, get hold of, go and
get, try to reach, try to grab, point at, get me, bring me, hand me, give me, collect, retrieve,
stretch to, stretch out for, extend to, go get, lift, lift up, snatch, feel, reach to, aim for, go
to
""")
REACH_PLACE = names("""
reach, reach out, go, stretch, point, touch, reach over, extend, reach forward, touch the spot,
reach for the point, reach the place, touch the table, reach the spot, reach for the area,
touch the place
""")
LINKS = ("", "", "goes", "should be", "should go", "must be", "down")
CONTACTS = names("contact, support contact, support, a contact, support point, contact point")
LEADS = names("""
please, can you, could you, could you please, can you please, I want you to, I need you to, I
would like you to, I'd like you to, let's, you should, go ahead and, robot, talos, hey robot, ok
now, now, next, then, ok, and now, try to, would you, I want to see you, you can, you need to, it
would be great if you, alright, great, first, hey, hi, you have to, I'd want you to, make sure to,
be careful and, now please, so now, next please, your task is to, I'm asking you to, carefully,
gently, slowly, quickly, just
""")
TAILS = names("""
please, now, carefully, thanks, thank you, for support, to support yourself, for balance, gently,
if you can, to keep your balance, slowly, ok, first, so you don't fall, robot, if possible, right
now, firmly, with some force, for stability, again, instead, this time, as a support
""")
AGAIN = names(
    """
no, | instead, | actually, | no, actually, | wait, | forget that, | let's do something else, | no,
not there, | wrong object, | I changed my mind, | sorry, I meant | not that one, | no no, | scratch
that, | new target: | I meant | rather, | on second thought, | never mind, | that's the wrong
thing, | no, I said | no, use something else, | wrong one, | no wait,
""",
    "|",
)


OTHER_SHARE = 0.06
OTHER_THINGS = names(
    """
no, the {A} | no the {A} | not this one, the {A} | not that one, the {A} | not this, the {A} | no,
not that, the {A} | wrong one, the {A} | I meant the {A} | no, I meant the {A} | sorry, the {A} |
nope, {A} | the {A} instead | no no, the {A} please | rather the {A} | the {A}, not this one | the
{A} I said | wrong thing, I want the {A} | not it, the {A} | hm no, the {A} | the {A} rather
""",
    "|",
)
"""A new target in place of the one that is shown"""


BARE_SHARE = 0.06
INSTEAD_SHARE = 0.05
INSTEAD = names(
    """
{told} instead of the {n} | {told}, not the {n} | not the {n}, {told} | forget the {n}, {told} |
{told} and not the {n} | leave the {n}, {told} | never mind the {n}, {told} | {told} rather than the
{n} | no, not the {n}, {told} | the {n} is no good, {told} | {told} | i said {told}, not the {n}
""",
    "|",
)
"""`n` is a thing that is not meant"""
STANDS_SHARE = 0.06
STANDS = names("""
that is lying on, that is standing on, standing next to, lying on, that stands beside, which lies
under, sitting on, that is leaning against, I left on, that you find on, hanging by, that hangs over
""")
"""Where a thing is that is meant: no part of its name"""


@dataclass(frozen=True)
class Instruction:
    """A first instruction with everything that is to be understood from it."""

    draft: Draft
    position: str
    x: str
    y: str
    scene: str
    effector: str
    task: str


def _with_articles(draw: Draw, text: str, *, plain: bool) -> str:
    """Put an article in front of each object, and now and then where it stands behind."""
    for letter in "ABC":
        word = "the" if plain else article(draw)
        text = text.replace(f"{{{letter}}}", f"{word} {{{letter}}}".strip())
    if text.endswith("}") and not plain:
        text = f"{text} {place(draw)}".strip()
    return text


def _contact(draw: Draw, location: str) -> tuple[str, str]:
    """Return a template of an instruction to lean, and the end effector.

    Now and then the place is all that is said: `left of the till`.
    """
    bare = draw.chance(BARE_SHARE)
    limb, name = limb_phrase(draw)
    tool = f"{draw.pick(WITH)} {limb}"
    comma = "," if draw.chance(0.3) else ""
    frames = (
        *[f"{draw.pick(PUT)} {limb} {location}"] * 5,
        f"{draw.pick(LEAN)} {location}{comma} {tool}",
        f"{tool}, {draw.pick(LEAN)} {location}",
        f"use {limb} to {draw.pick(LEAN)} {location}",
        f"{limb} {draw.pick(LINKS)} {location}",
        f"{draw.pick(CONTACTS)} {location} {tool}",
        f"{location} {draw.pick(PUT)} {limb}",
    )
    roll = draw.uniform()
    if roll < 0.08:
        return f"{draw.pick(LEAN)} {location}", "unspecified"
    if roll < 0.16:
        return by_the_other(draw, f"{draw.pick(LEAN)} {location}", feet=True)
    return location if bare else draw.pick(frames), "unspecified" if bare else name


def _reach(draw: Draw, location: str, *, absolute: bool) -> tuple[str, str]:
    """Return a template of an instruction to reach, and the end effector: feet only stand."""
    limb, name = limb_phrase(draw, feet=False)
    tool = f"{draw.pick(WITH)} {limb}"
    comma = "," if draw.chance(0.3) else ""
    verb = draw.pick(REACH_OBJECT) if absolute else draw.pick(REACH_PLACE)
    frames = (
        *[f"{verb} {location}{comma} {tool}"] * 2,
        *[f"{tool}{draw.pick((',', ',', ''))} {verb} {location}"] * 2,
        f"use {limb} to {verb} {location}",
    )
    roll = draw.uniform()
    if roll < 0.17:
        return f"{verb} {location}", "unspecified"
    if roll < 0.25:
        return by_the_other(draw, f"{verb} {location}", feet=False)
    return draw.pick(frames), name


def _other_thing(draw: Draw) -> Instruction:
    """Reject what is shown for another thing, which is a new target: `no, the blue one`."""
    template, effector = draw.pick(OTHER_THINGS), "unspecified"
    if draw.chance(0.35):
        limb, effector = limb_phrase(draw)
        template = f"{template}, {limb}"
    draft = Draft()
    draft.fill(template, {"A": draw.pick((one_phrase, one_phrase, plain_phrase))(draw)})
    return Instruction(draft, "absolute", "", "", "", effector, "contact")


def instruction(draw: Draw, kind: str, *, plain: bool) -> Instruction:
    """Return an instruction whose position is of this kind: absolute or relative.

    `plain`: in few words, as most are; else with all that people may say around it.
    """
    if kind == "absolute" and not plain and draw.chance(OTHER_SHARE):
        return _other_thing(draw)
    absolute = kind == "absolute"
    location = locations.absolute(draw) if absolute else relations.relative(draw)
    reach = draw.chance(0.32)
    text = "{A}" if reach and absolute else location.text
    text = _with_articles(draw, text, plain=plain)
    if reach:
        template, effector = _reach(draw, text, absolute=absolute)
    else:
        template, effector = _contact(draw, text)
    if absolute and draw.chance(STANDS_SHARE):
        template = template.replace(
            "{A}", f"{{A}} {draw.pick(STANDS)} the {plain_phrase(draw, surface=True)}"
        )
    elif absolute and draw.chance(INSTEAD_SHARE):
        template = draw.pick(INSTEAD).format(told=template, n=plain_phrase(draw))
    draft = Draft()
    if not plain:
        _lead(draw, draft)
    name = plain_phrase if plain else phrase
    letters = [letter for letter in "ABC" if f"{{{letter}}}" in location.text]
    template = template if plain else with_aside(template, draw)
    draft.fill(template, {letter: name(draw, surface=not reach) for letter in letters})
    if not plain and draw.chance(0.2):
        draft.add(draw.pick(TAILS))
    return Instruction(
        draft,
        kind,
        location.x,
        location.y,
        location.scene,
        effector,
        "reach" if reach else "contact",
    )


def _lead(draw: Draw, draft: Draft) -> None:
    """Begin with a courtesy, or with the rejection of what was said before."""
    roll = draw.uniform()
    if roll < 0.35:
        draft.add(draw.pick(LEADS))
        if draw.chance(0.2):
            draft.words[-1] += ","
    elif roll < 0.45:
        draft.add(draw.pick(AGAIN))


VAGUE = names("""
lean over there, put your right hand somewhere, reach forward, lean forward with your left hand,
place your left hand over here, use your right hand, reach out with the left hand,
take it with the left hand, with your right hand please, lean, lean on something, put
your hand on it, touch it, get that, place a contact, find a support, support yourself with your
right hand, move your left hand, give me your hand, hello, hi robot, how are you, what do you see,
what is this, help me, raise your hand, can you lean, left hand, right hand please, do something,
who are you, where is it, place your hand on that, reach for this, lean against that with your
left, dance, sing a song, tell me a joke, walk to the door then
""")


def vague(draw: Draw) -> Draft:
    """Return an instruction that names no object: the answer is a question to the operator."""
    draft = Draft()
    draft.add(draw.pick(VAGUE))
    return draft
