"""The hand-written corpus: how people really say it, with what they mean by it.

Files of `written/`, one utterance a line, `meaning | utterance` (README.md there). Things stand in
brackets, so a line is a pattern too: things, numbers and sides may be exchanged for others.
"""

import re
from collections.abc import Sequence
from functools import cache
from typing import get_args

from w2c_dialogue.corpus.clauses import is_noun, same_kind
from w2c_dialogue.corpus.draft import Draft
from w2c_dialogue.corpus.draw import Draw, is_held_out
from w2c_dialogue.corpus.instructions import Instruction
from w2c_dialogue.corpus.measures import NUMBER_WORDS
from w2c_dialogue.corpus.moves import read_move
from w2c_dialogue.corpus.phrases import phrase, plain_phrase
from w2c_dialogue.corpus.places import Place, read_place
from w2c_dialogue.corpus.steering import Correction
from w2c_dialogue.corpus.written_lines import (
    SIDE_WORDS,
    SLOT,
    THING,
    Kind,
    Line,
    lines,
    number_words,
    numeral,
)
from w2c_dialogue.prompts.spans import MAX_SPAN_WORDS
from w2c_dialogue.utterance import LETTERS, repetitions

KEPT_SHARE = 0.5
"""How often the things of a line stay those that its author named: drawn names are less like what
people say, and a sentence about the thing ("it's scalding") fits no other"""
LENT_SHARE = 0.4
"""How often a thing in its place is one that another author named"""
LONGEST_LENT = 5
"""Words of such a name: what describes one thing at length fits few other sentences"""
MIRRORED_SHARE = 0.5
RENUMBERED_SHARE = 0.6
FEW, MANY = 12, 300
"""Numbers up to FEW are exchanged for such, others for up to MANY"""
_SIDES_MEANT = re.compile(r"left|right")


def written_instruction(draw: Draw, position: str) -> Instruction:
    """Return a written instruction of a position, absolute or relative."""
    return instruction_of(draw.pick(_instructions(position)), draw)


def instruction_of(line: Line, draw: Draw) -> Instruction:
    """Return an instruction of the pattern of a line."""
    meaning, text = vary(line, draw)
    place, effector, task = meaning.rsplit(maxsplit=2)
    position = "absolute" if place == "absolute" else "relative"
    point = Place("", "") if position == "absolute" else read_place(place)
    x, y, scene = _resolve(point, draw)
    return Instruction(_draft(text, draw), position, x, y, scene, effector, task)


def written_correction(draw: Draw) -> Correction:
    """Return a written correction."""
    return correction_of(draw.pick(_with_meaning("corrections")), draw)


def correction_of(line: Line, draw: Draw) -> Correction:
    """Return a correction of the pattern of a line."""
    meaning, text = vary(line, draw)
    point, needs_past = read_move(meaning)
    x, y, scene = _resolve(point, draw)
    return Correction(_draft(text, draw), x, y, needs_past, scene)


def written_words(draw: Draw, kind: Kind) -> Draft:
    """Return an utterance that tells its kind, whatever else it means."""
    return _draft(vary(draw.pick(_telling(kind)), draw)[1], draw)


def vary(line: Line, draw: Draw) -> tuple[str, str]:
    """Return meaning and utterance with other sides and numbers, or the same."""
    meaning, text = line.meaning, line.text
    if line.mirrors and draw.chance(MIRRORED_SHARE):
        meaning, text = _swapped(_SIDES_MEANT, meaning), mirrored(text)
    if SLOT.search(text) and draw.chance(RENUMBERED_SHARE):
        meaning, text = _renumber(meaning, text, draw)
    return number_words(meaning), SLOT.sub(r"\1", text)


def mirrored(text: str) -> str:
    """Return an utterance with left and right exchanged, capitals kept."""
    return _swapped(SIDE_WORDS, text)


def _swapped(sides: re.Pattern[str], text: str) -> str:
    def other(match: re.Match[str]) -> str:
        word = match[0]
        swapped = "right" if word.lower() == "left" else "left"
        if word.isupper():
            return swapped.upper()
        return swapped.title() if word[0].isupper() else swapped

    return sides.sub(other, text)


@cache
def _telling(kind: Kind) -> tuple[Line, ...]:
    return tuple(line for line in lines(kind) if line.tells)


@cache
def _with_meaning(kind: Kind) -> tuple[Line, ...]:
    return tuple(line for line in lines(kind) if line.meaning)


@cache
def _instructions(position: str) -> tuple[Line, ...]:
    absolute = position == "absolute"
    return tuple(
        line
        for line in _with_meaning("instructions")
        if line.meaning.startswith("absolute") == absolute
    )


def _resolve(point: Place, draw: Draw) -> tuple[str, str, str]:
    """Return the expressions of a place and the fact about the boxes under which they hold."""
    at = draw.below(len(point.scenes))
    x, y = point.by_scene[at] if point.by_scene else (point.x, point.y)
    return x, y, point.scenes[at]


def _renumber(meaning: str, text: str, draw: Draw) -> tuple[str, str]:
    """Exchange the numbers in braces; a number written as a word stays one where it can."""
    drawn = []
    for said in SLOT.findall(text):
        word = said.lower() in NUMBER_WORDS
        if word:
            name = draw.pick(tuple(NUMBER_WORDS))
            drawn.append((name, NUMBER_WORDS[name]))
        else:
            number = str(1 + draw.below(FEW if float(numeral(said)) <= FEW else MANY))
            drawn.append((number, number))
    said_numbers, meant_numbers = iter(drawn), iter(drawn)
    text = SLOT.sub(lambda _: "{" + next(said_numbers)[0] + "}", text)
    return SLOT.sub(lambda _: "{" + next(meant_numbers)[1] + "}", meaning), text


def _draft(text: str, draw: Draw) -> Draft:
    """Return the words of an utterance; its things kept, or others in their place."""
    names = THING.findall(text)
    longest = max((len(name.split()) for name in names), default=0)
    keep = longest <= MAX_SPAN_WORDS and (draw.chance(KEPT_SHARE) or _names_again(text))
    return _with_names(text, names if keep else [_other(name, draw) for name in names])


def _with_names(text: str, names: Sequence[str]) -> Draft:
    """Return the words of an utterance with these names in the place of its things."""
    draft, at = Draft(), 0
    text = text.replace("<", "").replace(">", "")
    for letter, name, match in zip(LETTERS, names, THING.finditer(text), strict=False):
        _add(draft, text[at : match.start()], "")
        _add(draft, name, letter)
        at = match.end()
    _add(draft, text[at:].replace("[", "").replace("]", ""), "")
    return draft


@cache
def _names_again(text: str) -> bool:
    """Tell whether an utterance speaks of a thing twice: another name would part the two."""
    utterance, spans = _with_names(text, THING.findall(text)).finish()
    return bool(repetitions(utterance.folded, spans))


def _other(name: str, draw: Draw) -> str:
    """Return another name that can stand in the place of one."""
    if not is_noun(name):
        return same_kind(name, draw)
    if draw.chance(LENT_SHARE):
        return draw.pick(lent_names())
    return draw.pick((plain_phrase, phrase))(draw)


@cache
def lent_names() -> tuple[str, ...]:
    """Return the names of things in the lines for training that may stand in other lines."""
    found = (
        name
        for kind in get_args(Kind)
        for line in lines(kind)
        if not is_held_out(line)
        for name in THING.findall(line.text)
        if is_noun(name) and len(name.split()) <= LONGEST_LENT
    )
    return tuple(dict.fromkeys(found))


def _add(draft: Draft, text: str, letter: str) -> None:
    """Append words; what touches the word before without a space belongs to it."""
    if draft.words and text and not text[0].isspace() and not letter:
        glued, _, text = text.partition(" ")
        draft.words[-1] += glued
    draft.add(text, letter)
