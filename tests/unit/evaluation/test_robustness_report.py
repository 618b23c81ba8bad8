"""The grid, its results file, its tables and its picture."""

from pathlib import Path

import pytest

from w2c_evaluation.results import make_results
from w2c_evaluation.robustness.grid import (
    MASSES,
    MODES,
    PUBLISHED,
    SPEEDS,
    Cause,
    Cell,
    Mode,
    TrialResult,
    cells,
)
from w2c_evaluation.robustness.report import draw_heat_map, format_tables, make_rows


def result(mode: Mode, speed: float, mass: float, trial: int, cause: Cause = "") -> TrialResult:
    return TrialResult(
        cell=Cell(mode=mode, speed=speed, mass=mass, trial=trial),
        survived=cause == "",
        cause=cause,
        reached=0.95 if cause == "" else 0.5,
        achieved_speed=0.8 * speed if cause == "" else -1.0,
        top_speed=speed,
        robot_seconds=40.0,
        cpu_seconds=20.0,
    )


def study() -> list[TrialResult]:
    """Return two trials of each cell: `off` always falls, `full` falls once with 12 kg."""
    found = []
    for cell in cells(MODES, SPEEDS, MASSES, 2):
        cause: Cause = "fell" if cell.mode == "no_force_control" else ""
        if cell.mode == "full" and cell.mass == 12.0 and cell.trial == 1:
            cause = "short"
        found.append(result(cell.mode, cell.speed, cell.mass, cell.trial, cause))
    return found


def test_the_published_grid_adds_up() -> None:
    totals = {mode: sum(sum(line) for line in PUBLISHED[mode]) for mode in MODES}
    assert totals == {"no_force_control": 30, "no_torque_limit": 135, "full": 181}
    for rows in PUBLISHED.values():
        assert [len(row) for row in rows] == [len(MASSES)] * len(SPEEDS)


def test_every_cell_has_every_trial_once() -> None:
    everything = list(cells(MODES, SPEEDS, MASSES, 10))
    assert len(everything) == len(set(everything)) == 750


def test_any_beginning_of_the_study_has_all_modes() -> None:
    first = list(cells(MODES, SPEEDS, MASSES, 10))[:75]
    assert {cell.mode for cell in first} == set(MODES)
    assert {cell.trial for cell in first} == {0}


def test_rows_have_the_names_that_others_rely_on() -> None:
    rows = make_rows(study())
    totals = {r["case"]: r for r in rows if r["metric"] == "survived" and r["case"] in MODES}
    assert [totals[mode]["value"] for mode in MODES] == [0.0, 50.0, 45.0]
    assert {totals[mode]["n"] for mode in MODES} == {50}
    assert {totals[mode]["unit"] for mode in MODES} == {"count"}
    document = make_results("robustness", 0, rows)
    assert set(document) == {"benchmark", "commit", "seed", "versions", "machine", "rows"}


def test_rows_give_causes_cells_and_achieved_speeds() -> None:
    rows = {(r["case"], r["metric"]): r for r in make_rows(study())}
    assert rows["no_force_control", "fell"]["value"] == 50.0
    assert rows["full", "short"]["value"] == 5.0
    assert rows["full.0.4_m_s.12_kg", "survived"]["value"] == 1.0
    assert rows["full.0.4_m_s.0_kg", "achieved_speed"]["value"] == pytest.approx(0.32)
    assert rows["no_force_control.0.4_m_s.0_kg", "achieved_speed"]["n"] == 0


def test_tables_stand_beside_the_published_ones() -> None:
    text = format_tables(study())
    assert "### full: 45 of 50 (published: 181 of 250)" in text
    assert "| 0.4 | 2/2 (9/10) 0.32 m/s |" in text
    assert "Failures: short 5." in text


def test_a_part_of_the_grid_makes_a_table_too() -> None:
    text = format_tables([result("full", 0.15, 3.0, 0)])
    assert "| 0.15 | 1/1 0.12 m/s |" in text


def test_the_picture_is_drawn_and_the_same_again(tmp_path: Path) -> None:
    for name in ("a.png", "b.png"):
        draw_heat_map(study(), tmp_path / "images" / name)
    first, second = ((tmp_path / "images" / name).read_bytes() for name in ("a.png", "b.png"))
    assert first.startswith(b"\x89PNG")
    assert first == second
