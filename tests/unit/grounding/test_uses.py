"""Phrases of what things are for."""

from collections import Counter
from pathlib import Path

import msgspec

from w2c_dialogue.advice.wordlist import VETOED
from w2c_grounding.card import read_card
from w2c_grounding.registry import EMBEDDED
from w2c_grounding.train import uses
from w2c_grounding.train.asker import FOREIGN
from w2c_grounding.train.uses import EVERY_USE, fitting_kinds, possible_kinds, uses_of
from w2c_sim_robot.scenes.held_out import HELD_OUT_KINDS
from w2c_sim_robot.scenes.objects.catalogue import KINDS

FILE = Path(uses.__file__).with_name("uses.jsonl")


def test_every_use_is_of_kinds_that_there_are_and_of_none_that_is_kept_for_judging() -> None:
    for phrase in EVERY_USE:
        assert possible_kinds(phrase) <= set(KINDS)
        assert fitting_kinds(phrase).isdisjoint(HELD_OUT_KINDS)
        assert all(phrase in uses_of(kind) for kind in fitting_kinds(phrase))
    assert len(EVERY_USE) > 2_000


def test_a_use_is_written_once_and_a_kind_fits_or_may_fit() -> None:
    lines = [msgspec.json.decode(line) for line in FILE.read_bytes().splitlines()]
    assert Counter(phrase for line in lines for phrase in line["phrases"]) == Counter(EVERY_USE)
    for line in lines:
        assert set(line["fits"]).isdisjoint(line["may_fit"])


def test_what_is_never_touched_is_no_word_of_a_use() -> None:
    assert {thing for thing in VETOED if " " not in thing} <= set(FOREIGN)


def test_the_shipped_model_knows_no_word_of_what_is_never_touched() -> None:
    vocabulary = read_card(EMBEDDED, "embedded").vocabulary
    assert vocabulary is not None and "coffee" in vocabulary
    assert set(VETOED).isdisjoint(vocabulary)
