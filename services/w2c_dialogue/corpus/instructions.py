"""First instructions: which hand or foot goes where, to lean or to reach."""

from dataclasses import dataclass

from w2c_dialogue.corpus import locations, relations
from w2c_dialogue.corpus.asides import with_aside
from w2c_dialogue.corpus.clauses import one_phrase
from w2c_dialogue.corpus.draft import Draft
from w2c_dialogue.corpus.draw import Draw
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


def _short_limb(draw: Draw, *, feet: bool) -> tuple[str, str]:
    """Return an end effector as thumbs type it, or corrected while it is said, and its name."""
    side, other = ("left", "right") if draw.chance(0.5) else ("right", "left")
    part, wrong = ("foot", "hand") if feet and draw.chance(0.25) else ("hand", "foot")
    template = draw.pick(draw.pick((SHORT_LIMBS, REPAIRED_LIMBS)))
    said = template.format(s=side[0], p=part[0], side=side, other=other, part=part, wrong=wrong)
    return said, f"{side}_{part}"


def _limb(draw: Draw, *, feet: bool = True) -> tuple[str, str]:
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


def _with_articles(draw: Draw, text: str, *, plain: bool) -> str:
    """Put an article in front of each object, and now and then where it stands behind."""
    for letter in "ABC":
        word = "the" if plain else article(draw)
        text = text.replace(f"{{{letter}}}", f"{word} {{{letter}}}".strip())
    if text.endswith("}") and not plain:
        text = f"{text} {place(draw)}".strip()
    return text


def _contact(draw: Draw, location: str) -> tuple[str, str]:
    """Return a template of an instruction to lean, and the end effector."""
    limb, name = _limb(draw)
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
    if draw.chance(0.08):
        return f"{draw.pick(LEAN)} {location}", "unspecified"
    return draw.pick(frames), name


def _reach(draw: Draw, location: str, *, absolute: bool) -> tuple[str, str]:
    """Return a template of an instruction to reach, and the end effector: feet only stand."""
    limb, name = _limb(draw, feet=False)
    tool = f"{draw.pick(WITH)} {limb}"
    comma = "," if draw.chance(0.3) else ""
    verb = draw.pick(REACH_OBJECT) if absolute else draw.pick(REACH_PLACE)
    frames = (
        *[f"{verb} {location}{comma} {tool}"] * 2,
        *[f"{tool}{draw.pick((',', ',', ''))} {verb} {location}"] * 2,
        f"use {limb} to {verb} {location}",
    )
    if draw.chance(0.17):
        return f"{verb} {location}", "unspecified"
    return draw.pick(frames), name


def _other_thing(draw: Draw) -> Instruction:
    """Reject what is shown for another thing, which is a new target: `no, the blue one`."""
    template, effector = draw.pick(OTHER_THINGS), "unspecified"
    if draw.chance(0.35):
        limb, effector = _limb(draw)
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
    location = locations.absolute(draw) if kind == "absolute" else relations.relative(draw)
    reach = draw.chance(0.32)
    text = "{A}" if reach and kind == "absolute" else location.text
    text = _with_articles(draw, text, plain=plain)
    if reach:
        template, effector = _reach(draw, text, absolute=kind == "absolute")
    else:
        template, effector = _contact(draw, text)
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
