"""Reading the hand-written corpus: files of `written/`, one utterance a line (README.md there)."""

import re
from collections.abc import Iterator
from dataclasses import dataclass
from functools import cache
from importlib.resources import files
from typing import Literal, get_args

from w2c.errors import ConfigError
from w2c_dialogue.corpus.measures import NUMBER_WORDS
from w2c_dialogue.corpus.moves import read_move
from w2c_dialogue.corpus.places import read_place
from w2c_dialogue.prompts.base import EFFECTORS, TASKS

Kind = Literal["instructions", "corrections", "confirmations", "dialogues"]
TURN_KINDS: dict[str, Kind] = {"p": "instructions", "c": "corrections", "y": "confirmations"}
KIND_OF_MODULE: dict[str, Kind] = {
    "prediction": "instructions",
    "correction": "corrections",
    "confirmation": "confirmations",
}
NOT_MIRRORED, NOT_CHOSEN_BY = "!", "?"
"""Flags before a meaning: left and right stay; the words alone do not tell their module"""
THING = re.compile(r"\[([^\[\]]+)\]")
SLOT = re.compile(r"\{([^{}]+)\}")
SIDE_WORDS = re.compile(r"(?<![a-z])(left|right)", re.IGNORECASE)
_ADVERB = re.compile(
    r"\b(all|that's|is|be|just|about) right\b|right[,?]|^right (so|then)\b|\bleft ?over\b|"
    r"\bright (next|on|onto|there|in|behind|above|below|beside|between|at|now|here|where|under|"
    r"over|against|up|down|away|back|before|after|by|near|along|across|then|so)\b",
    re.IGNORECASE,
)
"""A `right` that is no side"""


@dataclass(frozen=True)
class Line:
    """One line of a file."""

    kind: Kind
    meaning: str
    text: str
    mirrors: bool
    """Whether left and right may be exchanged"""
    tells: bool = True
    """Whether the words alone tell the module: "left of the iron, then" may be a new place too"""

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
    words = meaning.lstrip(NOT_MIRRORED + NOT_CHOSEN_BY)
    flags, meaning = meaning.removesuffix(words), words.strip()
    if not meaning:
        raise ConfigError(f"'{text}' has no meaning")
    if kind == "dialogues":
        if flags:
            raise ConfigError(f"'{text}' has flags, and no turn of a dialogue has")
        letters, turns = meaning.split(), [turn.strip() for turn in utterance.split(" / ")]
        if len(letters) != len(turns) or not set(letters) <= set(TURN_KINDS):
            raise ConfigError(f"'{text}' has {len(turns)} turns and {len(letters)} letters")
        for letter, turn in zip(letters, turns, strict=True):
            yield Line(TURN_KINDS[letter], "", turn, mirrors=False)
        return
    sides = bool(SIDE_WORDS.search(utterance)) and not _ADVERB.search(utterance)
    mirrors, tells = sides and NOT_MIRRORED not in flags, NOT_CHOSEN_BY not in flags
    line = Line(kind, meaning, utterance, mirrors, tells)
    _check(line)
    yield line


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


def _check(line: Line) -> None:
    """Refuse a meaning that cannot be read, or that speaks of things the utterance does not."""
    things = len(THING.findall(line.text))
    meaning = number_words(line.meaning)
    for said in SLOT.findall(line.text):
        numeral(said)
    if len(SLOT.findall(line.meaning)) not in (0, len(SLOT.findall(line.text))):
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


def number_words(meaning: str) -> str:
    """Return a meaning without braces, its numbers as numerals."""
    return SLOT.sub(lambda match: numeral(match[1]), meaning)


def numeral(said: str) -> str:
    """Return a number in braces as digits. Raises ConfigError where it is none."""
    value = NUMBER_WORDS.get(said.lower(), said)
    try:
        float(value)
    except ValueError as error:
        raise ConfigError(f"'{said}' in braces is no number") from error
    return value
