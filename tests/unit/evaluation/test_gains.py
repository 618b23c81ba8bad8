"""The comparison of gains: its table and its results."""

import json
import math
from dataclasses import replace
from pathlib import Path

import pytest

from w2c.errors import ControlError
from w2c.library import library
from w2c_evaluation.gains import commands, trial
from w2c_evaluation.gains.commands import GAINS, bench, format_table
from w2c_evaluation.gains.trial import Case, Outcome


def outcome(case: Case, **changes: object) -> Outcome:
    values: dict[str, object] = {
        "pushed": "loaded",
        "reached": "reached",
        "fell": False,
        "push_error": 0.5,
        "push_ripple": 0.2,
        "knock_ripple": 7.8,
        "reach_error": 8.0,
        "reach_peak": 50.0,
        "hold_error": 0.6,
        "foot_error": 25.0,
    }
    return Outcome(case=case, **(values | changes))  # type: ignore[arg-type]


def test_a_line_says_how_a_trial_ended() -> None:
    case = Case(name="p1", gains={"proportional": 1.0}, stiffness=1.4)
    good, lost, fallen = format_table(
        [outcome(case), outcome(case, reason="the hand slips"), outcome(case, fell=True)]
    ).splitlines()[2:]
    assert good.startswith("| p1 | 1.4 | 0 | 0.5 | 0.2 |")
    assert good.endswith("loaded, reached |")
    assert lost.endswith("the hand slips |")
    assert fallen.endswith("fell |")


def test_the_command_runs_every_combination_and_writes_it(
    monkeypatch: pytest.MonkeyPatch, tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    monkeypatch.setattr(
        commands, "run_all", lambda _, tasks, **__: [outcome(task[0]) for task in reversed(tasks)]
    )
    path = tmp_path / "gains.json"
    arguments = ["--gains", "own", "off", "--stiffnesses", "0.7", "1.0", "--json", str(path)]
    assert bench(arguments) == 0
    lines = capsys.readouterr().out.splitlines()[2:]
    assert [line.split(" | ")[0].strip("| ") for line in lines] == ["own", "off", "own", "off"]
    document = json.loads(path.read_text())
    assert document["benchmark"] == "gains"
    cases = {row["case"] for row in document["rows"]}
    assert "off.stiffness_0.7.mass_0" in cases
    assert len(cases) == 4


def test_every_set_of_gains_is_one_of_the_controller() -> None:
    force_control = library("controller_parameters")().force_control
    for gains in GAINS.values():
        replace(force_control, **gains)


def test_a_trial_that_cannot_be_run_says_why(monkeypatch: pytest.MonkeyPatch) -> None:
    def refuse(_: Case) -> None:
        raise ControlError("this posture cannot stand")

    monkeypatch.setattr(trial, "Trial", refuse)
    case = Case(name="own", gains={}, hand_mass=30.0)
    outcome = trial.run_case(case)
    assert outcome.reason == "this posture cannot stand"
    assert math.isnan(outcome.push_error)
    assert format_table([outcome]).endswith("this posture cannot stand |")
