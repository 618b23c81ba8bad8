"""One far reach from end to end, and the targets of all of them."""

import json
from pathlib import Path

import numpy as np
import pytest

from w2c.errors import ControlError
from w2c_controller.parameters import Parameters
from w2c_evaluation.robustness import trial as trial_module
from w2c_evaluation.robustness.commands import bench
from w2c_evaluation.robustness.grid import Cell, Target
from w2c_evaluation.robustness.targets import find_target
from w2c_evaluation.robustness.trial import run_trial, trial_parameters

NEAR = Target(
    trial=0,
    mass=2.0,
    start=(0.252, -0.395, 0.997),
    point=(0.40, -0.40, 0.95),
    direction=(1.0, 0.0, 0.0),
)


def test_parameters_differ_from_the_controllers_own_only_where_they_must() -> None:
    own, slow = Parameters(), trial_parameters("full", 0.02)
    assert slow.filters.speed == 0.02
    assert slow.filters.lead_position == own.filters.lead_position
    assert slow.weights == own.weights
    assert slow.force_control.mode == "full"
    fast = trial_parameters("no_force_control", 0.4)
    assert fast.filters.speed == 0.4
    assert fast.force_control.mode == "off"
    assert fast.limits == slow.limits


@pytest.mark.slow
def test_directions_are_the_seeds_and_a_mass_shortens_the_way() -> None:
    empty, loaded = find_target(0, 0.0, seed=0), find_target(0, 12.0, seed=0)
    assert empty.direction == loaded.direction
    assert empty.start == loaded.start
    ways = [np.linalg.norm(np.subtract(t.point, t.start)) for t in (empty, loaded)]
    assert 0.3 < ways[1] < ways[0] < 1.0
    assert find_target(0, 0.0, seed=0) == empty
    assert find_target(1, 0.0, seed=0).direction != empty.direction


@pytest.mark.slow
def test_a_near_reach_with_a_mass_is_survived(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(trial_module, "HOLD_S", 0.5)
    monkeypatch.setattr(trial_module, "REST_S", 1.0)
    result = run_trial(Cell(mode="full", speed=0.2, mass=2.0, trial=0), NEAR)
    assert result.cause == "", result.detail
    assert result.survived
    assert result.reached > 0.9
    assert 0.0 < result.top_speed < 0.25


@pytest.mark.slow
def test_the_command_runs_and_resumes(tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    """The trials are made up: what is tested is what surrounds them."""
    arguments = ["--trials", "1", "--modes", "full", "--speeds", "0.2", "--masses", "2"]
    arguments += ["--workers", "1", "--run-directory", str(tmp_path), "--resume"]
    target = {**_builtins(NEAR)}
    (tmp_path / "targets.jsonl").write_text(f'{{"seed":0}}\n{json.dumps(target)}\n')
    assert bench(arguments) == 0
    trials = (tmp_path / "trials.jsonl").read_text()
    assert trials.count("\n") == 2
    assert bench(arguments) == 0
    assert (tmp_path / "trials.jsonl").read_text() == trials
    assert (tmp_path / "heat_map.png").stat().st_size > 1000
    document = json.loads((tmp_path / "results.json").read_text())
    survived = next(r for r in document["rows"] if r["metric"] == "survived")
    assert (survived["case"], survived["n"]) == ("full", 1)
    assert "published: 181 of 250" in capsys.readouterr().out


def _builtins(target: Target) -> dict[str, object]:
    return {
        "trial": target.trial,
        "mass": target.mass,
        "start": target.start,
        "point": target.point,
        "direction": target.direction,
    }


def test_a_trial_that_breaks_is_not_survived_and_says_why(monkeypatch: pytest.MonkeyPatch) -> None:
    def diverge(_: trial_module.Trial) -> str:
        raise ControlError("physics diverged at tick 7")

    monkeypatch.setattr(trial_module.Trial, "_perform", diverge)
    result = run_trial(Cell(mode="full", speed=0.2, mass=2.0, trial=0), NEAR)
    assert (result.survived, result.cause) == (False, "refused")
    assert "diverged" in result.detail
