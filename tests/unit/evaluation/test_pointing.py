"""Rates of hits by case, with what training never saw apart."""

from dataclasses import dataclass
from pathlib import Path

import pytest

from w2c.errors import ProcessError
from w2c_evaluation.pointing.commands import PointingConfig, render
from w2c_evaluation.pointing.report import format_table, make_rows


@dataclass(frozen=True)
class Asked:
    kind: str = "book"
    phrase_kind: str | None = "name"
    peak_hits: bool = True
    score: float = 0.9
    unseen_kind: bool = False
    unseen_pair: bool = False
    interior_hits: bool = True
    error: float = 0.0


def test_rows_keep_apart_what_training_never_saw() -> None:
    trials = [
        Asked(),
        Asked(score=0.1),
        Asked(phrase_kind="colour", peak_hits=False, error=40.0),
        Asked(kind="hat", unseen_kind=True, peak_hits=False, error=9.0),
        Asked(unseen_pair=True),
        Asked(kind="", phrase_kind=None, peak_hits=False, score=0.4),
        Asked(kind="", phrase_kind=None, peak_hits=False, score=0.6),
    ]
    rows = {(row["case"], row["metric"]): row for row in make_rows(trials, 0.5)}
    assert rows["seen", "hit"]["value"] == pytest.approx(2 / 3)
    assert rows["seen", "hit"]["n"] == 3
    assert rows["seen", "found_and_hit"]["value"] == pytest.approx(1 / 3)
    assert rows["seen", "error_of_misses"]["value"] == 40.0
    assert rows["seen.colour", "hit"]["value"] == 0.0
    assert rows["unseen_kind", "hit"]["value"] == 0.0
    assert rows["unseen_pair", "hit"]["value"] == 1.0
    assert rows["absent", "rejected"]["value"] == 0.5
    assert ("kind.hat", "hit") not in rows
    low, high = rows["kind.book", "hit"]["spread"]
    assert low < 2 / 3 < high


def test_the_table_shows_the_targets_where_they_are_judged() -> None:
    table = format_table(make_rows([Asked(), Asked(kind="", score=0.1)], 0.5)).splitlines()
    assert next(line for line in table if "| 0.95 |" in line).startswith("| seen | hit | 1.000 |")
    assert any(line.startswith("| absent | rejected | 1.000 |") for line in table)


def test_pictures_that_cannot_be_rendered_end_it_with_the_next_step(tmp_path: Path) -> None:
    (tmp_path / "else.txt").write_text("other files")
    with pytest.raises(ProcessError, match="--run-directory"):
        render(PointingConfig(count=1), tmp_path)
