"""The push study: its cases, its numbers, and one push from touch to report."""

from pathlib import Path

import numpy as np
import pytest

from w2c.errors import ConfigError
from w2c_evaluation.pushes import trial as push_trial
from w2c_evaluation.pushes.cases import PushCase, PushResult, all_cases
from w2c_evaluation.pushes.commands import bench
from w2c_evaluation.pushes.report import draw_pushes, format_table, make_rows
from w2c_evaluation.pushes.trial import Push


def result(case: PushCase, trial: int = 0, *, slip_seconds: float = -1.0) -> PushResult:
    times = [0.02 * k for k in range(200)]
    return PushResult(
        case=case,
        trial=trial,
        fell=False,
        loaded=True,
        mean_abs_error=1.0 + trial,
        rms_error=2.0,
        steady_error=-0.5,
        slip=0.001,
        slip_seconds=slip_seconds,
        answer="",
        detail="",
        times=times,
        wanted=[case.force] * 200,
        measured=[case.force * min(t, 1.0) for t in times],
    )


def case(name: str) -> PushCase:
    return next(c for c in all_cases() if c.name == name)


def test_every_case_has_a_name_of_its_own() -> None:
    names = [c.name for c in all_cases()]
    assert len(names) == len(set(names))


def test_the_cases_that_were_asked_for_are_there() -> None:
    found = all_cases()
    tracked = {(c.surface, c.force, c.force_control) for c in found}
    for surface in ("table", "wall"):
        for force in (20.0, 50.0, 75.0):
            assert {(surface, force, "off"), (surface, force, "full")} <= tracked
    assert {0.5, 2.0} <= {c.stiffness for c in found}
    assert {0.01, -0.01} <= {c.surface_error for c in found}
    assert any(2.0 <= abs(c.sole_pitch_deg) <= 3.0 for c in found)
    slippery = {c.assumed_friction for c in found if c.friction == 0.3}
    assert slippery == {0.3, 0.24, None}


def test_rows_have_medians_over_trials_and_all_falls() -> None:
    push = case("table.50_N.full")
    rows = {(r["case"], r["metric"]): r for r in make_rows([result(push, 0), result(push, 2)])}
    error = rows["table.50_N.full", "mean_abs_error"]
    assert (error["value"], error["n"], error["unit"]) == (2.0, 2, "N")
    assert rows["all", "falls"]["value"] == 0.0
    assert ("table.50_N.full", "slip") not in rows


def test_rows_of_a_slippery_table_say_whether_slips_were_found() -> None:
    slippery = case("lean_and_reach.friction_0.3_assumed_0.6")
    trials = [result(slippery, k, slip_seconds=s) for k, s in enumerate((-1.0, -2.0, 0.1))]
    rows = {(r["case"], r["metric"]): r for r in make_rows(trials)}
    assert rows[slippery.name, "slipped"]["value"] == 2.0
    assert (rows[slippery.name, "slips_found"]["value"], 2) == (1.0, 2)
    assert rows[slippery.name, "slip_found_after"]["value"] == pytest.approx(0.1)


def test_table_and_picture(tmp_path: Path) -> None:
    results = [result(c) for c in all_cases()]
    assert "| wall.75_N.off | 1 | 0 | 1 | 1.0 | 2.0 | -0.5 |" in format_table(results)
    draw_pushes(results, tmp_path / "p.png")
    assert (tmp_path / "p.png").read_bytes().startswith(b"\x89PNG")


def test_an_unknown_case_is_refused(tmp_path: Path) -> None:
    with pytest.raises(ConfigError, match="no case has 'ceiling'"):
        bench(["--only", "ceiling", "--run-directory", str(tmp_path)])


def slide(speeds: list[float], told: float) -> tuple[float, float]:
    """Return slip and time to its report of a made-up hand that slides at these speeds [m/s]."""
    push = object.__new__(Push)
    push._told_s = told
    push._period_s = 0.002
    push._record = push_trial.Record()
    for k, speed in enumerate(speeds):
        push._record.times.append(0.02 * k)
        push._record.measured.append(50.0)
        push._record.sliding.append(np.array([speed, 0.0, 0.0]))
    return push._slip(0)


def test_a_hand_that_creeps_does_not_slip() -> None:
    assert slide([0.01] * 14, told=-1.0) == pytest.approx((0.002, -1.0))


def crept(speeds: list[float], told: float) -> float:
    """Return the time from the beginning of a made-up creep to its report."""
    push = object.__new__(Push)
    push._told_s = told
    push._period_s = 0.002
    push._record = push_trial.Record()
    for k, speed in enumerate(speeds):
        push._record.times.append(0.02 * k)
        push._record.measured.append(50.0)
        push._record.sliding.append(np.array([speed, 0.0, 0.0]))
    return push._creep(0)


def test_creep_is_timed_from_where_the_hand_was_at_rest_last() -> None:
    rest, creep = [0.0] * 100, [0.0016] * 200
    # A window of a second whose second half creeps with 1.6 mm/s is the first to be fast enough.
    assert crept(rest + creep, told=5.0) == pytest.approx(5.0 - 0.02 * 76, abs=0.03)
    assert crept(creep + rest + creep, told=8.0) == pytest.approx(8.0 - 0.02 * 276, abs=0.03)


def test_what_holds_in_the_simulator_does_not_creep() -> None:
    assert crept([0.0004] * 600, told=-1.0) == -1.0
    assert crept([0.0004] * 600, told=5.0) == -1.0


def test_creep_that_nobody_tells_of_is_known_as_such() -> None:
    assert crept([0.001] * 300, told=-1.0) == -2.0
    assert crept([0.001] * 100 + [0.0] * 100, told=-1.0) == -1.0


def test_a_slip_that_nobody_tells_of_is_known_as_such() -> None:
    assert slide([0.0] * 4 + [0.1] * 5, told=-1.0) == pytest.approx((0.01, -2.0))


def test_a_slip_is_timed_from_its_beginning() -> None:
    farthest, seconds = slide([0.0] * 5 + [0.03] * 5, told=0.22)
    assert farthest == pytest.approx(0.003)
    assert seconds == pytest.approx(0.22 - 4 * 0.02)  # its average passes 2 cm/s from there on


def test_a_jerk_that_stops_by_itself_is_no_slip() -> None:
    assert slide([0.0] * 5 + [0.024] * 5 + [0.0] * 20, told=-1.0) == pytest.approx((0.0024, -1.0))
    assert slide([0.0] * 5 + [0.024] * 6 + [0.0] * 20, told=-1.0) == pytest.approx((0.00288, -2.0))


def test_a_hand_that_trembles_does_not_slip() -> None:
    assert slide([0.05, -0.05] * 5, told=-1.0) == pytest.approx((0.001, -1.0))


@pytest.mark.slow
def test_one_push_from_touch_to_report(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(push_trial, "HOLD_S", 2.0)
    found = Push(case("table.20_N.full"), 0, 0).run()
    assert not found.fell
    assert found.loaded, found.detail
    assert abs(found.steady_error) < 5.0
    assert found.slip < 0.005
    assert len(found.times) == len(found.measured) == len(found.wanted) > 100


@pytest.mark.slow
def test_a_far_reach_over_a_slippery_support_ends_with_the_slip(
    monkeypatch: pytest.MonkeyPatch,
) -> None:
    monkeypatch.setattr(push_trial, "HOLD_S", 4.0)
    found = Push(case("lean_and_reach.friction_0.3_assumed_0.6"), 0, 0).run()
    assert not found.fell
    assert "right hand slips" in found.answer
    # It creeps, with 1 mm/s and less, and a slip that was fast would have been told at once.
    assert found.slip_seconds <= 0.2
    assert found.slip < 0.015
