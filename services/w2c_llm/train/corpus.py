"""Chats with the exact answer that is wanted, one JSON object a line."""

from collections.abc import Iterator
from pathlib import Path
from typing import Annotated, Literal

import msgspec

from w2c.errors import ConfigError


class Turn(msgspec.Struct, frozen=True, forbid_unknown_fields=True):
    """One message of a chat, as a chat template takes it."""

    role: Literal["system", "user", "assistant"]
    content: str


class Example(msgspec.Struct, frozen=True, forbid_unknown_fields=True):
    """One line of a corpus."""

    messages: Annotated[list[Turn], msgspec.Meta(min_length=1)]
    answer: Annotated[str, msgspec.Meta(min_length=1)]
    """What the assistant must say, character by character"""
    task: str = "all of them"
    """Under which name it is counted"""


def read_corpus(path: Path) -> list[Example]:
    """Return the examples of a file.

    Raises:
        ConfigError: there is no such file, it is empty, or a line is not an example.
    """
    if not path.is_file():
        raise ConfigError(
            f"no corpus at {path}; write one with the corpus generator of the dialogue"
        )
    examples = list(_decode_lines(path))
    if not examples:
        raise ConfigError(f"the corpus {path} holds no example")
    return examples


def _decode_lines(path: Path) -> Iterator[Example]:
    decoder = msgspec.json.Decoder(Example)
    with path.open("rb") as file:
        for number, line in enumerate(file, start=1):
            if not line.strip():
                continue
            try:
                yield decoder.decode(line)
            except (msgspec.ValidationError, msgspec.DecodeError) as error:
                raise ConfigError(f"{path}, line {number}: {error}") from error
