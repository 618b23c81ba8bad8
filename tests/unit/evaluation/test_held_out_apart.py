"""The sentences that judge the language model are not in the corpus that trains it.

Short ones are ("half of that back"): there are few ways to say them. A whole sentence of six words,
or a description of a thing of five, is one that somebody has read.
"""

import re
from typing import get_args

import msgspec

from w2c_dialogue.corpus.written import mirrored
from w2c_dialogue.corpus.written_lines import THING, Kind, lines
from w2c_evaluation.understanding.commands import read_questions

LONG_SENTENCE, LONG_DESCRIPTION = 6, 5
"""Words: too many for chance"""


class Said(msgspec.Struct, frozen=True):
    text: str = ""
    turns: list[str] = []


def words(text: str) -> str:
    """Return a text without case and punctuation, between spaces."""
    unmarked = re.sub(r"[\[\]{}<>]", "", text.lower())
    return f" {' '.join(re.sub(r'[^a-z0-9 ]+', ' ', unmarked).split())} "


def judging() -> set[str]:
    said = (msgspec.json.decode(line, type=Said) for line in read_questions([]))
    return {words(text) for one in said for text in (one.text, *one.turns)}


def read_before(sentence: str, things: list[str], known: set[str]) -> bool:
    """Tell whether a sentence, or one of its things, stands in the known ones."""
    if len(sentence.split()) >= LONG_SENTENCE and words(sentence) in known:
        return True
    long = [words(name) for name in things if len(name.split()) >= LONG_DESCRIPTION]
    return any(name in text for name in long for text in known)


def test_no_sentence_and_no_description_is_in_both() -> None:
    known = judging()
    said = [line for kind in get_args(Kind) for line in lines(kind)]
    written = [line.text for line in said] + [mirrored(line.text) for line in said if line.mirrors]

    assert len(known) > 1000
    assert len(written) > 10_000
    assert [text for text in written if read_before(text, THING.findall(text), known)] == []


def test_what_is_in_both_is_found() -> None:
    known = {words("Sit on the bench where the old men play chess, robot.")}

    assert read_before("lean on the [bench where the old men]", ["bench where the old men"], known)
    assert read_before("sit on the bench where the old men play chess robot!", [], known)
    assert not read_before("sit on the bench", ["bench"], known)
