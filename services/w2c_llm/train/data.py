"""What a run reads: corpus, held-out examples, a user's dialogues; and how to know them again."""

import hashlib
from collections import Counter
from collections.abc import Callable, Sequence
from dataclasses import dataclass, field
from pathlib import Path
from typing import Any, Protocol

import msgspec
from tokenizers import Tokenizer

from w2c.library import library
from w2c_llm.train.corpus import Example, read_corpus
from w2c_llm.train.tokenizer import EncodedExample, encode_all

_DIALOGUES = "dialogue_examples"
"""Name in the library; the service of the dialogue knows how it asks"""


class ReadDialogues(Protocol):
    """What the dialogue offers."""

    @property
    def examples(self) -> Sequence[Any]:
        """Objects with the fields of `Example`."""

    @property
    def summary(self) -> str:
        """What was read, and what could not be used, in one line."""


@dataclass(frozen=True)
class Source:
    """A file of examples."""

    name: str
    examples: list[Example] = field(repr=False)
    digest: str
    """Of the file's bytes, 12 digits"""

    def counts(self) -> dict[str, int]:
        """Return task -> examples, the most frequent first."""
        return dict(Counter(example.task for example in self.examples).most_common())


def read_source(path: Path) -> Source:
    """Read a corpus. Raises ConfigError."""
    return Source(path.name, read_corpus(path), digest(path))


def read_dialogues(path: Path, log: Callable[[str], None]) -> Source:
    """Read a user's own dialogues. Raises ConfigError."""
    found: ReadDialogues = library(_DIALOGUES)(path)
    log(f"{path.name}: {found.summary}")
    examples = msgspec.convert(found.examples, list[Example], from_attributes=True)
    return Source(path.name, examples, digest(path))


def digest(path: Path) -> str:
    """Return a short SHA-256 of a file."""
    with path.open("rb") as file:
        return hashlib.file_digest(file, "sha256").hexdigest()[:12]


def encode_source(
    tokenizer: Tokenizer, source: Source, limit: int, log: Callable[[str], None]
) -> list[EncodedExample]:
    """Return the tokens of a file's examples, without those of more than `limit`."""
    encoded = list(encode_all(tokenizer, source.examples))
    short = [example for example in encoded if len(example.tokens) <= limit]
    if len(short) < len(encoded):
        log(
            f"{source.name}: {len(encoded) - len(short)} examples are longer than {limit} tokens "
            "and left out"
        )
    return short
