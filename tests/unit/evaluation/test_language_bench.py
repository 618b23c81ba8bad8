"""Rows, targets and table of `w2c bench language`, and what an instruction asks."""

from dataclasses import dataclass
from pathlib import Path
from typing import Any

import pytest

from w2c import topics
from w2c.bus.inprocess import InProcessHub
from w2c.messages import ChooseReply, ChooseRequest, CompleteReply, CompleteRequest
from w2c_evaluation.language.commands import cache_folder
from w2c_evaluation.language.instruction import ServiceCost, ask_instruction
from w2c_evaluation.language.report import (
    EMBEDDED,
    comparison_rows,
    format_table,
    missed,
    service_rows,
)
from w2c_evaluation.results import make_results


@dataclass
class Cost:
    milliseconds: float
    prompt_tokens: int
    answer_tokens: int = 9
    text: str = "yes"


@dataclass
class Pair:
    case: str
    plain: Cost
    ours: Cost


@dataclass
class Comparison:
    pairs: list[Pair]
    first: list[Cost]


def comparison(ours_ms: float = 10.0, ours_tokens: int = 20) -> Comparison:
    ours = Cost(ours_ms, ours_tokens)
    pairs = [Pair("select", Cost(100.0, 600), ours), Pair("effector", Cost(80.0, 600), ours)]
    return Comparison(pairs, [Cost(100.0, 620)])


def value(rows: list[dict[str, Any]], case: str, metric: str) -> float:
    return float(next(r["value"] for r in rows if (r["case"], r["metric"]) == (case, metric)))


def test_rows_have_the_names_that_are_relied_upon() -> None:
    rows = comparison_rows(comparison())
    assert value(rows, "select", "plain_ms") == 100.0
    assert value(rows, "select", "ours_ms") == 10.0
    assert value(rows, "effector", "speedup") == 8.0
    assert value(rows, "all", "speedup") == 9.0
    assert value(rows, "all", "plain_tokens") == 600
    assert value(rows, "all", "ours_tokens") == 20
    assert value(rows, "all", "same_answers") == 1.0
    assert value(comparison_rows(comparison(), EMBEDDED), "embedded.all", "first_ms") == 100.0


def test_an_answer_that_differs_is_counted() -> None:
    differing = comparison()
    differing.pairs[0].ours = Cost(10.0, 20, text="no")
    rows = comparison_rows(differing)
    assert value(rows, "all", "same_answers") == 0.5
    assert value(rows, "effector", "same_answers") == 1.0


def test_targets_that_are_missed_are_named() -> None:
    good = [*comparison_rows(comparison()), *service_rows(ServiceCost([200.0, 250.0], 90.0, 120.0))]
    assert missed(good) == []
    slow = comparison_rows(comparison(ours_ms=25.0, ours_tokens=50))
    assert [line.split(":")[0] for line in missed(slow)] == ["all token_ratio", "all speedup"]
    assert missed(comparison_rows(comparison(ours_ms=25.0), EMBEDDED)) == []
    lines = missed(service_rows(ServiceCost([400.0], 90.0, 500.0)))
    assert lines == [
        "instruction milliseconds: 400, above 300",
        "service idle_memory_mb: 500, above 400",
    ]


def test_the_table_has_a_line_a_kind() -> None:
    rows = [*comparison_rows(comparison()), *service_rows(ServiceCost([200.0, 250.0], 90.0, 120.0))]
    table = format_table(make_results("language", 0, rows))
    assert "| select (1) | 100 | 10 | 10 | 600 | 20 | 9 | 9 | 1 |" in table
    assert "225 ms" in table
    assert "computes 90 ms" in table
    assert "120 MB" in table
    alone = format_table(make_results("language", 0, rows[-3:]))
    assert "120 MB" in alone
    assert "|" not in alone


@pytest.mark.parametrize(
    ("position", "tasks"),
    [
        ("absolute", ["select", "analyze", "effector"]),
        ("relative", ["select", "analyze", "relative", "effector"]),
    ],
)
def test_an_instruction_asks_what_the_dialogue_asks(position: str, tasks: list[str]) -> None:
    hub = InProcessHub()
    server, caller = hub.connect("llm"), hub.connect("evaluation")
    asked: list[str] = []
    answers: dict[str, Any] = {
        "analyze": {"position": position, "objects": ["5-5"]},
        "relative": {"x": "a.u", "y": "a.v"},
        "effector": {"effector": "left_hand", "task": "contact"},
    }
    cost: dict[str, Any] = {"prompt_tokens": 1, "reused_tokens": 0, "queue_ms": 0.0}

    def complete(request: CompleteRequest, _: object) -> CompleteReply:
        asked.append(request.messages[0].content)
        return CompleteReply(
            text="",
            value=answers[asked[-1]],
            model="fake",
            completion_tokens=1,
            prefill_ms=0.0,
            decode_ms=0.0,
            **cost,
        )

    def choose(request: ChooseRequest, _: object) -> ChooseReply:
        asked.append(request.messages[0].content)
        return ChooseReply(
            option="prediction",
            probabilities={"prediction": 1.0},
            model="fake",
            prefill_ms=0.0,
            **cost,
        )

    server.serve(topics.COMPLETE, complete)
    server.serve(topics.CHOOSE, choose)
    assert ask_instruction(caller, "lean left of the mug") > 0.0
    assert asked == tasks


def test_large_files_go_where_the_user_keeps_such(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setenv("XDG_CACHE_HOME", "/somewhere")
    assert cache_folder("") == Path("/somewhere/words2contact")
    assert cache_folder("here") == Path("here")
    monkeypatch.delenv("XDG_CACHE_HOME")
    assert cache_folder("") == Path.home() / ".cache" / "words2contact"
