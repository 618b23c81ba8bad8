"""What counts as understood, and that the held-out questions are questions with answers."""

from pathlib import Path
from typing import Any

import msgspec
import pytest

from w2c.errors import ConfigError
from w2c_evaluation.understanding.commands import (
    HELD_OUT_FILES,
    format_table,
    judge,
    rate,
    read_questions,
    rows_of,
    wilson_interval,
)
from w2c_evaluation.understanding.judging import Expectation, HeldOut, same_objects, score

PROBES = HELD_OUT_FILES.parent / "probes"


def line(task: str, **expect: object) -> HeldOut:
    return HeldOut(id="x", task=task, voice="terse", expect=msgspec.convert(expect, Expectation))


def test_the_held_out_questions_are_many_and_in_many_voices() -> None:
    lines = [msgspec.json.decode(text, type=HeldOut) for text in read_questions([])]

    assert len(lines) >= 400
    assert len({entry.voice for entry in lines}) >= 10
    assert len({entry.id for entry in lines}) == len(lines)
    for entry in lines:
        assert score(entry, {"error": "none"}) == dict.fromkeys(score(entry, {}), False)


def test_probes_can_be_passed_and_no_two_of_them_have_one_name() -> None:
    lines = [
        msgspec.json.decode(text, type=HeldOut)
        for path in sorted(PROBES.glob("*.jsonl"))
        for text in read_questions([path])
    ]

    assert {entry.task for entry in lines} == {
        "correct",
        "relative",
        "effector",
        "analyze",
        "select",
    }
    assert len({entry.id for entry in lines}) == len(lines) > 1000
    for entry in lines:
        expect = entry.expect
        answer: dict[str, Any] = {
            "module": expect.module,
            "position": expect.position,
            "objects": [spans[0] for spans in expect.objects],
            "end_effector": expect.end_effector,
            "task_type": expect.task_type,
        }
        if expect.accept:
            left, top, right, bottom = expect.accept[0]
            answer["point"] = [0.5 * (left + right), 0.5 * (top + bottom)]
        assert all(score(entry, answer).values()), entry
        assert not any(score(entry, {"error": "none"}).values()), entry


@pytest.mark.parametrize(
    ("task", "expect", "right", "wrong"),
    [
        ("select", {"module": "correction"}, {"module": "correction"}, {"module": "prediction"}),
        (
            "effector",
            {"end_effector": "left_hand", "task_type": "reach"},
            {"end_effector": "left_hand", "task_type": "reach"},
            {"end_effector": "left_hand", "task_type": "contact"},
        ),
        (
            "relative",
            {"accept": [[10, 10, 20, 20]], "reject": [[15, 10, 20, 20]]},
            {"point": [12, 12]},
            {"point": [16, 12]},
        ),
        ("correct", {"accept": [[10, 10, 20, 20]]}, {"point": [20, 20]}, {"point": [21, 12]}),
        (
            "dialogue",
            {"modules": ["prediction", "confirmation"]},
            {"modules": ["prediction", "confirmation"]},
            {"modules": ["prediction", "correction"]},
        ),
    ],
)
def test_an_answer_is_right_or_wrong(
    task: str, expect: dict[str, object], right: dict[str, object], wrong: dict[str, object]
) -> None:
    assert list(score(line(task, **expect), right).values()) == [True]
    assert list(score(line(task, **expect), wrong).values()) == [False]
    assert list(score(line(task, **expect), {"error": "late"}).values()) == [False]


@pytest.mark.parametrize(
    ("answered", "right"),
    [
        (["red cup"], True),
        (["The red cup."], True),
        (["red cup", "table"], True),
        (["table", "red cup"], True),
        (["cup"], False),
        (["red cup", "red cup"], False),
        (["red cup", "floor"], False),
        ([], False),
    ],
)
def test_objects_are_spans_in_order_of_mention(answered: list[str], right: bool) -> None:
    expect = Expectation(objects=[["the red cup", "red cup on the table"]], optional=["the table"])

    assert same_objects(answered, expect) == right


def test_rates_are_counted_by_task_and_voice() -> None:
    lines = [line("select", module="correction"), line("dialogue", modules=["prediction"] * 3)]
    answers: list[dict[str, Any]] = [
        {"module": "correction"},
        {"modules": ["prediction", "correction", "prediction"]},
    ]
    judged = judge(lines, answers)

    assert rate(judged["select"]) == 1.0
    assert rate(judged["dialogue"]) == 0.0
    assert rate(judged["dialogue.turns"]) == pytest.approx(2 / 3)
    assert {row["case"]: row["n"] for row in rows_of(judged)}["dialogue.turns.terse"] == 3
    assert "| dialogue.turns | 0.95 | 0.667 | 3 |" in format_table(judged)


def test_the_interval_of_a_rate() -> None:
    assert wilson_interval(5, 10) == pytest.approx((0.2366, 0.7634), abs=1e-4)


@pytest.mark.parametrize("text", ["{", '{"id": "a"}', '{"id": "a", "task": "select"}'])
def test_a_line_without_an_answer_is_refused(tmp_path: Path, text: str) -> None:
    path = tmp_path / "questions.jsonl"
    path.write_text(text + "\n")

    with pytest.raises(ConfigError, match=r"questions\.jsonl, line 1"):
        read_questions([path])


def test_a_missing_file_is_refused(tmp_path: Path) -> None:
    with pytest.raises(ConfigError, match="No such file"):
        read_questions([tmp_path / "none.jsonl"])
