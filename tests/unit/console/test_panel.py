"""The rows of the page's panels."""

import numpy as np
import pytest

from w2c import topics
from w2c.messages import ControllerStatus, Health, ProcessState, ProcessTable, RecorderStatus
from w2c_console.panel import Aged, controller_panel, process_rows, recorder_panel

NOW = 100_000_000_000


def health(service: str, phase: str = "ready", **fields: object) -> Health:
    values = {"pid": 1, "cpu_percent": 12.0, "memory_mb": 100.0, **fields}
    return Health(stamp_ns=0, service=service, instance="0", phase=phase, **values)  # type: ignore[arg-type]


def table(name: str, phase: str, detail: str = "", restarts: int = 0) -> Aged[ProcessTable]:
    state = ProcessState(name=name, phase=phase, pid=None, restarts=restarts, detail=detail)
    return Aged(ProcessTable(stamp_ns=0, run_directory="runs/x", processes=[state]), NOW)


def levels(rows: list) -> dict[str, tuple[str, str]]:  # type: ignore[type-arg]
    return {row.name: (row.phase, row.level) for row in rows}


def test_every_process_of_the_system_has_a_row_even_if_it_was_never_seen() -> None:
    rows = process_rows({}, None, [], NOW)
    assert [row.name for row in rows] == list(topics.SERVICES)
    assert {row.level for row in rows} == {"absent"}


def test_a_process_that_reports_is_shown_as_it_says() -> None:
    rows = process_rows(
        {("llm", "0"): Aged(health("llm", "configure", counters={"late 20 ms": 2, "x": 1}), NOW)},
        None,
        [("llm", "0")],
        NOW,
    )
    row = next(row for row in rows if row.name == "llm")
    assert (row.phase, row.level, row.cpu_percent) == ("configure", "busy", 12.0)
    assert (row.lost, row.late) == (1, 2)


@pytest.mark.parametrize(
    ("age_s", "alive", "expected"),
    [
        (0.5, True, ("ready", "good")),
        (10.0, True, ("silent", "bad")),
        (0.5, False, ("gone", "bad")),
    ],
)
def test_a_process_that_fell_silent_or_went_away_is_not_shown_as_ready(
    age_s: float, alive: bool, expected: tuple[str, str]
) -> None:
    report = {("dialogue", "0"): Aged(health("dialogue"), NOW - int(age_s * 1e9))}
    rows = process_rows(report, None, [("dialogue", "0")] if alive else [], NOW)
    assert levels(rows)["dialogue"] == expected


def test_what_the_launcher_knows_of_a_dead_process_outweighs_its_last_report() -> None:
    report = {("llm", "0"): Aged(health("llm"), NOW)}
    dead = table("llm", "restarting", "exit status -9", restarts=2)
    row = next(row for row in process_rows(report, dead, [], NOW) if row.name == "llm")
    assert (row.phase, row.level, row.restarts, row.detail) == (
        "restarting",
        "busy",
        2,
        "exit status -9",
    )


def test_a_launcher_that_is_gone_is_not_believed() -> None:
    old = table("llm", "failed")
    rows = process_rows({}, Aged(old.message, NOW - 60_000_000_000), [], NOW)
    assert levels(rows)["llm"] == ("absent", "absent")


def test_replicas_have_rows_of_their_own_and_command_lines_have_none() -> None:
    alive = [("grounding", "0"), ("grounding", "1"), ("operator", "console-0")]
    rows = process_rows({}, None, alive, NOW)
    names = [(row.name, row.instance) for row in rows]
    assert names.count(("grounding", "0")) == 1
    assert ("grounding", "1") in names
    assert "operator" not in {name for name, _ in names}


def test_the_load_of_each_end_effector_is_told() -> None:
    status = ControllerStatus(
        stamp_ns=0,
        tick=0,
        phase="contact",
        in_contact=(True, True, False, True),
        desired_forces=np.array([[0, 0, 400.0], [0, 0, 400.0], [0, 0, 0], [30.0, 0, 40.0]]),
        end_effector_positions=np.zeros((4, 3)),
        loads=np.array([410.0, 390.0, 0.0, 47.0]),
        solver_failures=0,
        lateness_us={"p50": 60.0},
        tick_us={},
    )
    panel = controller_panel(Aged(status, NOW - 200_000_000), NOW)
    assert panel is not None
    assert not panel.stale
    hand = panel.contacts[3]
    assert (hand.name, hand.in_contact, hand.load) == ("right hand", True, 47.0)
    assert hand.desired_load == pytest.approx(50.0)
    late = controller_panel(Aged(status, NOW - 5_000_000_000), NOW)
    assert late is not None
    assert late.stale


def test_losses_of_the_recorder_are_added_up() -> None:
    status = RecorderStatus(
        stamp_ns=0, recording=True, path="x.mcap", messages=5, bytes=10, lost={"a": 2, "b": 3}
    )
    panel = recorder_panel(Aged(status, NOW), NOW)
    assert panel is not None
    assert panel.lost == 5
    assert recorder_panel(None, NOW) is None
