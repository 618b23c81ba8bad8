"""How one operator talks: phrasings written by hand, one file a voice.

A file holds words (directions, amounts, lengths, sides) and phrasings with places for them. Which
of them is said, and when, is decided elsewhere: a voice knows nothing of pictures.
"""

import string
from functools import cache
from pathlib import Path
from typing import Annotated, Literal

import msgspec

from w2c.errors import ConfigError

VOICE_FILES = Path(__file__).parent / "voices"
FEWEST_PHRASINGS = 20

Side = Literal["left", "right", "far", "near"]
"""As seen in the picture: far is up"""
Corner = Literal["far_left", "far_right", "near_left", "near_right"]
Texts = Annotated[tuple[str, ...], msgspec.Meta(min_length=1)]


class Words(msgspec.Struct, frozen=True, kw_only=True, forbid_unknown_fields=True):
    """What is put into phrasings."""

    left: Texts
    right: Texts
    up: Texts
    down: Texts
    tiny: Texts
    small: Texts
    large: Texts
    lengths: Annotated[dict[str, float], msgspec.Meta(min_length=1)]
    """Known lengths -> how long they are [cm]"""
    centimetres: Texts
    """With {n}, a whole number"""
    sides: dict[Side, Texts]
    """As in: the left edge"""
    corners: dict[Corner, Texts]
    beside: dict[Side, Texts]
    """As in: left of the cup"""
    answer: Texts
    """To a question, with {option}"""
    cancel: Texts


class Instructions(msgspec.Struct, frozen=True, kw_only=True, forbid_unknown_fields=True):
    """Phrasings that name a place."""

    on: Texts
    side: Texts
    edge: Texts
    corner: Texts
    beside: Texts
    beside_length: Texts
    between: Texts


class Corrections(msgspec.Struct, frozen=True, kw_only=True, forbid_unknown_fields=True):
    """Phrasings that change the point that is shown."""

    amount: Texts
    plain: Texts
    both: Texts
    plain_both: Texts
    length: Texts
    double: Texts
    same: Texts
    half: Texts
    too_far: Texts
    back: Texts
    wrong_way: Texts
    onto: Texts
    onto_side: Texts
    onto_corner: Texts
    level: Texts
    towards: Texts
    halfway: Texts


class Voice(msgspec.Struct, frozen=True, kw_only=True, forbid_unknown_fields=True):
    """One way to talk."""

    name: str = ""
    """Of its file"""
    about: str
    colour: Annotated[float, msgspec.Meta(ge=0, le=1)]
    """How often a thing is called by its colour where its name alone would do"""
    spell_numbers: bool = False
    """Numbers in words, as a speech recogniser may write them"""
    words: Words
    instructions: Instructions
    corrections: Corrections

    @property
    def phrasings(self) -> int:
        """How many different phrasings it has."""
        groups = (*_groups(self.instructions), *_groups(self.corrections))
        return len({text for _, texts in groups for text in texts})


SLOTS: dict[str, set[str]] = {
    "on": {"thing"},
    "side": {"side", "thing"},
    "edge": {"side", "thing"},
    "corner": {"corner", "thing"},
    "beside": {"beside", "thing"},
    "beside_length": {"length", "beside", "thing"},
    "between": {"thing", "other"},
    "amount": {"amount", "to"},
    "plain": {"to"},
    "both": {"amount", "to", "amount2", "to2"},
    "plain_both": {"to", "to2"},
    "length": {"length", "to"},
    "onto": {"thing"},
    "onto_side": {"side", "thing"},
    "onto_corner": {"corner", "thing"},
    "level": {"thing"},
    "towards": {"thing"},
    "halfway": {"thing"},
}
"""Which places each kind of phrasing has; none of them where it is not named"""


@cache
def voice_names() -> tuple[str, ...]:
    """Return the names of all voices."""
    return tuple(sorted(path.stem for path in VOICE_FILES.glob("*.toml")))


@cache
def read_voice(name: str) -> Voice:
    """Return a voice.

    Raises:
        ConfigError: there is none of this name, or its file is wrong; says where.
    """
    if name not in voice_names():
        raise ConfigError(f"there is no voice '{name}'; known: {', '.join(voice_names())}")
    return parse_voice((VOICE_FILES / f"{name}.toml").read_bytes(), name)


def parse_voice(data: bytes, name: str) -> Voice:
    """Return the voice of a file's bytes. Raises ConfigError that says what is wrong with them."""
    try:
        voice = msgspec.toml.decode(data, type=Voice)
    except msgspec.DecodeError as error:
        raise ConfigError(f"voice '{name}': {error}") from error
    for kind, texts in (*_groups(voice.instructions), *_groups(voice.corrections)):
        for text in texts:
            found = slots_of(text)
            if found != SLOTS.get(kind, set()):
                wanted = ", ".join(sorted(SLOTS.get(kind, set()))) or "nothing"
                raise ConfigError(
                    f"voice '{name}', {kind}: '{text}' has the places "
                    f"{', '.join(sorted(found)) or 'nothing'}, expected {wanted}"
                )
    if voice.phrasings < FEWEST_PHRASINGS:
        raise ConfigError(
            f"voice '{name}' has {voice.phrasings} phrasings; write at least {FEWEST_PHRASINGS}"
        )
    return msgspec.structs.replace(voice, name=name)


def slots_of(text: str) -> set[str]:
    """Return the names of the places in a phrasing."""
    return {field for _, field, _, _ in string.Formatter().parse(text) if field is not None}


def _groups(
    phrasings: Instructions | Corrections,
) -> tuple[tuple[str, tuple[str, ...]], ...]:
    return tuple(msgspec.structs.asdict(phrasings).items())
