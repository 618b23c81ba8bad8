"""Noun phrases: the ways people name a thing, up to "the thing with the wooden handle"."""

from w2c_dialogue.corpus.clauses import one_phrase, use_phrase
from w2c_dialogue.corpus.draw import Draw
from w2c_dialogue.corpus.more_things import RARER, compound, sounds_like_a_word
from w2c_dialogue.corpus.things import (
    COLOURS,
    MATERIALS,
    NEAR,
    PARTS,
    PLACES,
    PURPOSES,
    SIZES,
    STATES,
    SURFACES,
    SYLLABLES,
    THING_WORDS,
    THINGS,
    WHICH,
)

LIMBS = frozenset({"boot", "shoe", "glove", "arm", "leg", "foot", "hand", "heel", "wing", "sole"})
"""Things that are called as what a person leans with, or nearly"""
ARTICLES = ("the", "the", "the", "the", "the", "the", "a", "that", "this", "your", "my", "the", "")
NESTED = ("of", "of the", "on the", "of that")


def invented(draw: Draw) -> str:
    """Return a word nobody has heard."""
    if draw.chance(0.6):
        return sounds_like_a_word(draw)
    return "".join(draw.pick(SYLLABLES) for _ in range(2 + draw.below(3)))


def noun(draw: Draw, *, surface: bool) -> str:
    """Return the name of a thing; mostly of something to lean on where `surface`."""
    if draw.chance(0.06):
        name = invented(draw)
        if draw.chance(0.25):
            name = (
                f"{name} {draw.pick(('it', 'and', 'o', 'n', 'x', invented(draw)))} {invented(draw)}"
            )
        return f"{name} {draw.pick(THINGS)}" if draw.chance(0.6) else name
    name = _common(draw, 0.6 if surface else 0.15)
    if draw.chance(0.05):
        name = f"{draw.pick(THINGS)} {name}"
    return name


def _common(draw: Draw, surfaces: float) -> str:
    """Return the name of a thing that there is; `surfaces`: how often of something to lean on."""
    if draw.chance(surfaces):
        return draw.pick(SURFACES)
    roll = draw.uniform()
    if roll < 0.3:
        return draw.pick(RARER)
    return compound(draw) if roll < 0.45 else draw.pick(THINGS)


def _adjectives(draw: Draw) -> list[str]:
    words = []
    if draw.chance(0.18):
        words.append(draw.pick(SIZES))
    if draw.chance(0.08):
        words.append(draw.pick(STATES))
    if draw.chance(0.3):
        words.append(draw.pick(COLOURS))
    if draw.chance(0.15):
        words.append(draw.pick(MATERIALS))
    if draw.chance(0.05):
        words.append(draw.pick(("left", "right", "upper", "lower", "left-hand", "right-hand")))
    return words


def _attribute(draw: Draw) -> str:
    """Return what tells the thing from others and belongs to its name."""
    kind = draw.below(5)
    if kind == 0:
        return draw.pick(PURPOSES)
    article = draw.pick(("the", "a", ""))
    part = draw.pick(PARTS)
    quality = draw.pick(draw.pick((COLOURS, MATERIALS, SIZES)))
    link = draw.pick(("with", "with", "with", "that has", "which has", "having"))
    return f"{link} {article} {quality} {part}" if kind < 4 else f"{link} {article} {part}"


def plain_phrase(draw: Draw, *, surface: bool = False) -> str:
    """Return a noun, most often alone, else with a colour, a material or a size."""
    name = _common(draw, 0.5 if surface else 0.15)
    if draw.chance(0.65):
        return name
    return f"{draw.pick(draw.pick((COLOURS, COLOURS, MATERIALS, SIZES)))} {name}"


def phrase(draw: Draw, *, surface: bool = False) -> str:
    """Return a noun phrase without article."""
    roll = draw.uniform()
    if roll < 0.05:
        head = draw.pick(THING_WORDS)
        quality = draw.pick(draw.pick((COLOURS, MATERIALS, SIZES, STATES)))
        return f"{quality} {head}"
    if roll < 0.1:
        return " ".join(f"{draw.pick(THING_WORDS)} {_attribute(draw)}".split())
    if roll < 0.14:
        return f"{draw.pick(PARTS)} of the {noun(draw, surface=surface)}"
    if roll < 0.19:
        return use_phrase(draw)
    if roll < 0.21:
        return one_phrase(draw)
    words = [*_adjectives(draw), noun(draw, surface=surface)]
    if words[-1] in LIMBS and len(words) > 1:
        words = words[-1:]  # a right boot is not what goes there, it goes somewhere
    if draw.chance(0.06):
        words.append(_attribute(draw))
    elif draw.chance(0.05):
        words.append(draw.pick(WHICH))
    elif draw.chance(0.03):
        words.append(f"{draw.pick(NEAR)} {draw.pick(('the', 'the', 'that', 'a'))}")
        words.append(plain_phrase(draw))
    return " ".join(" ".join(words).split())


def article(draw: Draw) -> str:
    """Return an article, or nothing: people leave it out."""
    return draw.pick(ARTICLES)


def place(draw: Draw) -> str:
    """Return where the thing stands, now and then."""
    return draw.pick(PLACES) if draw.chance(0.07) else ""
