"""The hand-written corpus: how people really say it, with what they mean by it.

Files of `written/`, one utterance a line, `meaning | utterance` (README.md there). Things stand in
brackets, so a line is a pattern too: things, numbers and sides may be exchanged for others.
"""

import re
from collections.abc import Iterator
from dataclasses import dataclass
from functools import cache
from importlib.resources import files
from typing import Literal, get_args

from w2c.errors import ConfigError
from w2c_dialogue.corpus import locations
from w2c_dialogue.corpus.clauses import is_noun, same_kind
from w2c_dialogue.corpus.corrections import Correction
from w2c_dialogue.corpus.draft import Draft
from w2c_dialogue.corpus.draw import Draw, is_held_out
from w2c_dialogue.corpus.instructions import Instruction
from w2c_dialogue.corpus.moves import read_move
from w2c_dialogue.corpus.phrases import phrase, plain_phrase
from w2c_dialogue.corpus.places import Place, read_place
from w2c_dialogue.prompts.base import EFFECTORS, TASKS
from w2c_dialogue.prompts.spans import MAX_SPAN_WORDS

Kind = Literal["instructions", "corrections", "confirmations", "dialogues"]
TURN_KINDS: dict[str, Kind] = {"p": "instructions", "c": "corrections", "y": "confirmations"}
KIND_OF_MODULE: dict[str, Kind] = {
    "prediction": "instructions",
    "correction": "corrections",
    "confirmation": "confirmations",
}
NOT_MIRRORED = "!"
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
_THING = re.compile(r"\[([^\[\]]+)\]")
_SLOT = re.compile(r"\{([^{}]+)\}")
_SIDE_WORDS = re.compile(r"(?<![a-z])(left|right)", re.IGNORECASE)
_SIDES_MEANT = re.compile(r"left|right")
_ADVERB = re.compile(
    r"\b(all|that's|is|be|just|about) right\b|right[,?]|^right (so|then)\b|\bleft ?over\b|"
    r"\bright (next|on|onto|there|in|behind|above|below|beside|between|at|now|here|where|under|"
    r"over|against|up|down|away|back|before|after|by|near|along|across|then|so)\b",
    re.IGNORECASE,
)
"""A `right` that is no side"""
_WORD_OF_NUMBER = {number: word for word, number in reversed(locations.NUMBER_WORDS.items())}


@dataclass(frozen=True)
class Line:
    """One line of a file."""

    kind: Kind
    meaning: str
    text: str
    mirrors: bool
    """Whether left and right may be exchanged"""

    def __str__(self) -> str:
        """Return the utterance: what decides whether the line is kept from training."""
        return self.text


@cache
def lines(kind: Kind) -> tuple[Line, ...]:
    """Return all lines of a kind, those of dialogues' turns included.

    Raises:
        ConfigError: a line is malformed; names file and line.
    """
    found = [line for line in _read_all() if line.kind == kind]
    return tuple(dict.fromkeys(found))


def read_line(kind: Kind, text: str) -> Iterator[Line]:
    """Yield the lines of one written line: one, or the turns of a dialogue.

    Raises:
        ConfigError: it is malformed.
    """
    meaning, bar, utterance = (part.strip() for part in text.partition("|"))
    if not (bar and utterance):
        raise ConfigError(f"'{text}' is not `meaning | utterance`")
    keeps = meaning.startswith(NOT_MIRRORED)
    meaning = meaning.removeprefix(NOT_MIRRORED).strip()
    if kind == "dialogues":
        letters, turns = meaning.split(), [turn.strip() for turn in utterance.split(" / ")]
        if len(letters) != len(turns) or not set(letters) <= set(TURN_KINDS):
            raise ConfigError(f"'{text}' has {len(turns)} turns and {len(letters)} letters")
        for letter, turn in zip(letters, turns, strict=True):
            yield Line(TURN_KINDS[letter], "", turn, mirrors=False)
        return
    mirrors = not keeps and bool(_SIDE_WORDS.search(utterance)) and not _ADVERB.search(utterance)
    line = Line(kind, meaning, utterance, mirrors)
    _check(line)
    yield line


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
    """Return an utterance of a kind, whatever it means."""
    return _draft(vary(draw.pick(lines(kind)), draw)[1], draw)


def vary(line: Line, draw: Draw) -> tuple[str, str]:
    """Return meaning and utterance with other sides and numbers, or the same."""
    meaning, text = line.meaning, line.text
    if line.mirrors and draw.chance(MIRRORED_SHARE):
        meaning, text = _swapped(_SIDES_MEANT, meaning), mirrored(text)
    if _SLOT.search(text) and draw.chance(RENUMBERED_SHARE):
        meaning, text = _renumber(meaning, text, draw)
    return _number_words(meaning), _SLOT.sub(r"\1", text)


def mirrored(text: str) -> str:
    """Return an utterance with left and right exchanged, capitals kept."""
    return _swapped(_SIDE_WORDS, text)


def _swapped(sides: re.Pattern[str], text: str) -> str:
    def other(match: re.Match[str]) -> str:
        word = match[0]
        swapped = "right" if word.lower() == "left" else "left"
        if word.isupper():
            return swapped.upper()
        return swapped.title() if word[0].isupper() else swapped

    return sides.sub(other, text)


@cache
def _read_all() -> tuple[Line, ...]:
    folder = files("w2c_dialogue.corpus") / "written"
    found: list[Line] = []
    for file in sorted(folder.iterdir(), key=lambda entry: entry.name):
        if not file.name.endswith(".txt"):
            continue
        kind = next((kind for kind in get_args(Kind) if file.name.startswith(kind)), None)
        if kind is None:
            raise ConfigError(f"{file.name}: a file begins with {', '.join(get_args(Kind))}")
        for number, text in enumerate(file.read_text(encoding="utf-8").splitlines(), 1):
            if not text.strip() or text.startswith("#"):
                continue
            try:
                found += read_line(kind, text)
            except ConfigError as error:
                raise ConfigError(f"{file.name}, line {number}: {error}") from error
    return tuple(found)


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


def _check(line: Line) -> None:
    """Refuse a meaning that cannot be read, or that speaks of things the utterance does not."""
    things = len(_THING.findall(line.text))
    meaning = _number_words(line.meaning)
    for said in _SLOT.findall(line.text):
        _numeral(said)
    if len(_SLOT.findall(line.meaning)) not in (0, len(_SLOT.findall(line.text))):
        raise ConfigError(f"'{line.text}' and its meaning have different numbers in braces")
    if line.kind == "confirmations":
        if meaning != "yes":
            raise ConfigError(f"'{meaning}' is no meaning of a confirmation: yes")
        return
    if line.kind == "corrections":
        read_move(meaning)
    else:
        place, effector, task = _parts(meaning)
        if effector not in EFFECTORS or task not in TASKS:
            raise ConfigError(f"'{meaning}' names no end effector and task")
        if place != "absolute":
            read_place(place)
    needed = {"A"} if meaning.startswith("absolute") else set(re.findall(r"\b[ABC]\b", meaning))
    if needed != set("ABC"[: len(needed)]) or len(needed) > things:
        raise ConfigError(f"'{line.text}' has {things} things in brackets, meant: {needed}")


def _parts(meaning: str) -> tuple[str, str, str]:
    parts = meaning.rsplit(maxsplit=2)
    if len(parts) != 3:
        raise ConfigError(f"'{meaning}' is not `place effector task`")
    return parts[0], parts[1], parts[2]


def _resolve(point: Place, draw: Draw) -> tuple[str, str, str]:
    """Return the expressions of a place and the fact about the boxes under which they hold."""
    at = draw.below(len(point.scenes))
    x, y = point.by_scene[at] if point.by_scene else (point.x, point.y)
    return x, y, point.scenes[at]


def _renumber(meaning: str, text: str, draw: Draw) -> tuple[str, str]:
    """Exchange the numbers in braces; a number written as a word stays one where it can."""
    drawn = []
    for said in _SLOT.findall(text):
        word = said.lower() in locations.NUMBER_WORDS
        if word:
            name = draw.pick(tuple(locations.NUMBER_WORDS))
            drawn.append((name, locations.NUMBER_WORDS[name]))
        else:
            number = str(1 + draw.below(FEW if float(_numeral(said)) <= FEW else MANY))
            drawn.append((number, number))
    said_numbers, meant_numbers = iter(drawn), iter(drawn)
    text = _SLOT.sub(lambda _: "{" + next(said_numbers)[0] + "}", text)
    return _SLOT.sub(lambda _: "{" + next(meant_numbers)[1] + "}", meaning), text


def _number_words(meaning: str) -> str:
    """Return a meaning without braces, its numbers as numerals."""
    return _SLOT.sub(lambda match: _numeral(match[1]), meaning)


def _numeral(said: str) -> str:
    value = locations.NUMBER_WORDS.get(said.lower(), said)
    try:
        float(value)
    except ValueError as error:
        raise ConfigError(f"'{said}' in braces is no number") from error
    return value


def _draft(text: str, draw: Draw) -> Draft:
    """Return the words of an utterance; its things kept, or others in their place."""
    longest = max((len(name.split()) for name in _THING.findall(text)), default=0)
    keep = longest <= MAX_SPAN_WORDS and draw.chance(KEPT_SHARE)
    draft, at = Draft(), 0
    text = text.replace("<", "").replace(">", "")
    for letter, match in zip("abc", _THING.finditer(text), strict=False):
        _add(draft, text[at : match.start()], "")
        _add(draft, match[1] if keep else _other(match[1], draw), letter)
        at = match.end()
    _add(draft, text[at:].replace("[", "").replace("]", ""), "")
    return draft


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
        for name in _THING.findall(line.text)
        if is_noun(name) and len(name.split()) <= LONGEST_LENT
    )
    return tuple(dict.fromkeys(found))


def _add(draft: Draft, text: str, letter: str) -> None:
    """Append words; what touches the word before without a space belongs to it."""
    if draft.words and text and not text[0].isspace() and not letter:
        glued, _, text = text.partition(" ")
        draft.words[-1] += glued
    draft.add(text, letter)
