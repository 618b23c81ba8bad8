"""Timing in turns, its table, and the budget."""

import builtins
from typing import Any

import pytest

from w2c.errors import MissingExtraError
from w2c_evaluation.control.commands import over_budget
from w2c_evaluation.control.timing import BLOCK, PINK, format_table, make_rows, time_cases


class FakeCase:
    """Takes as long as it is told, and notes when its turn was."""

    def __init__(self, name: str, microseconds: int, log: list[str]) -> None:
        self.name = name
        self._taken = 1000 * microseconds
        self._log = log

    def prepare(self) -> None:
        self._log.append(f"prepare {self.name}")

    def step(self) -> int:
        self._log.append(self.name)
        return self._taken


class CaseWithParts(FakeCase):
    def time_parts(self, ticks: int) -> dict[str, list[int]]:
        return {"filters": [5000] * ticks}


def test_cases_take_turns_and_all_are_prepared_before() -> None:
    log: list[str] = []
    times, parts = time_cases([CaseWithParts("a", 100, log), FakeCase(PINK, 200, log)], 450)
    assert log[:2] == ["prepare a", f"prepare {PINK}"]
    assert log[2 : 2 + 2 * BLOCK] == ["a"] * BLOCK + [PINK] * BLOCK
    assert len(times["a"]) == len(times[PINK]) == 600
    assert set(times["a"]) == {100.0}
    assert parts == {"a": {"filters": [5.0] * BLOCK}}


def test_rows_and_table_name_what_is_relied_upon() -> None:
    times = {"two_feet.static": [100.0, 120.0], PINK: [200.0, 400.0]}
    rows = make_rows(times, {"two_feet.static": {"rest": [3.0]}})
    found = {(row["case"], row["metric"]): row["value"] for row in rows}
    assert found["two_feet.static", "tick_cpu_median"] == 110.0
    assert found[PINK, "tick_cpu_p99"] == pytest.approx(398.0)
    assert found["two_feet.static", "rest_cpu_median"] == 3.0
    assert {row["unit"] for row in rows} == {"us"}
    assert "0.37 pink" in format_table(times, {})


@pytest.mark.parametrize(("taken", "over"), [(80.0, 2), (60.0, 0), (90.0, 3)])
def test_the_budget_is_a_share_of_pink(taken: float, over: int) -> None:
    times = {
        "two_feet_hand.moving": [taken] * 10,
        "two_feet_hand.stalled": [taken] * 10,
        PINK: [101.0] * 10,
    }
    assert len(over_budget(times)) == over


def test_a_missing_extra_is_named(monkeypatch: pytest.MonkeyPatch) -> None:
    import sys

    original = builtins.__import__

    def without_pink(name: str, *arguments: Any, **keywords: Any) -> Any:
        if name.split(".", maxsplit=1)[0] == "pink":
            raise ModuleNotFoundError("No module named 'pink'", name="pink")
        return original(name, *arguments, **keywords)

    monkeypatch.delitem(sys.modules, "w2c_controller.bench.inverse_kinematics", raising=False)
    monkeypatch.setattr(builtins, "__import__", without_pink)
    with pytest.raises(MissingExtraError, match=r"\[bench\]"):
        __import__("w2c_controller.bench.inverse_kinematics")
