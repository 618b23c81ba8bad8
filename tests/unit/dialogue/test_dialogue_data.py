"""A user's own dialogues become questions; what is wrong with a line is said of that line."""

import json
from pathlib import Path
from typing import Any

import pytest

from support.documents import ROOT
from w2c.errors import ConfigError
from w2c_dialogue.corpus.dialogues import NO_EXPRESSION, DialogueExamples, read_dialogues

MUG = {"phrase": "red mug", "cx": 600, "cy": 300, "w": 100, "h": 80}
BOOK = {"phrase": "book", "cx": 900, "cy": 320, "w": 200, "h": 60}


def read(folder: Path, *turns: dict[str, Any] | str) -> DialogueExamples:
    path = folder / "mine.jsonl"
    path.write_text("\n".join(t if isinstance(t, str) else json.dumps(t) for t in turns) + "\n")
    return read_dialogues(path)


def answers(found: DialogueExamples) -> dict[str, str]:
    return {example.task: example.answer for example in found.examples}


def correction(utterance: str, point: list[float], **fields: Any) -> dict[str, Any]:
    turn = {"utterance": utterance, "module": "correction", "target": [500, 400], "point": point}
    return {**turn, "objects": [], **fields}


def test_an_instruction_answers_four_questions(tmp_path: Path) -> None:
    found = read(
        tmp_path,
        {
            "utterance": "Place your left palm to the left of the red mug.",
            "module": "prediction",
            "objects": [MUG],
            "position": "relative",
            "end_effector": "left_hand",
            "task_type": "contact",
            "point": [531, 299],
        },
    )
    assert answers(found) == {
        "select": "prediction",
        "analyze": '{"position":"relative","objects":["10-11"]}',
        "effector": '{"effector":"left_hand","task":"contact"}',
        "relative": '{"x":"a.left-0.2*a.width","y":"a.v"}',
    }
    question = found.examples[-1].messages[1]["content"]
    assert question == "A middle\nplace your left palm to the left of the A"
    assert found.summary == "1 turns, 4 questions"


def test_what_is_not_said_teaches_nothing(tmp_path: Path) -> None:
    found = read(tmp_path, {"utterance": "lean here", "module": "prediction"}, "", "  ")
    assert answers(found) == {"select": "prediction"}
    corrected = {"utterance": "closer to the mug", "module": "correction", "target": [5, 5]}
    assert answers(read(tmp_path, corrected)) == {"select": "correction"}, "objects are not known"
    named = {**corrected, "objects": []}
    assert answers(read(tmp_path, named)) == {"select": "correction", "objects": '{"objects":[]}'}
    found = read(tmp_path, {"utterance": "perfect", "module": "confirmation", "point": [1, 2]})
    assert answers(found) == {"select": "confirmation"}


@pytest.mark.parametrize(
    ("utterance", "point", "x", "y"),
    [
        ("a bit left", [481, 400], "target.u-20", "target.v"),
        ("lower and to the right", [540, 440], "target.u+40", "target.v+40"),
        ("onto the red mug", [600, 300], "a.u", "a.v"),
        ("halfway to the red mug", [555, 347], "target.u+0.5*(a.u-target.u)", None),
        ("to the right edge of the red mug", [635, 300], "a.right-0.15*a.width", "a.v"),
    ],
)
def test_a_confirmed_point_tells_what_a_correction_meant(
    tmp_path: Path, utterance: str, point: list[float], x: str, y: str | None
) -> None:
    fields = {"objects": [MUG], "target": [510, 395]} if "mug" in utterance else {}
    found = read(tmp_path, correction(utterance, point, **fields))
    value = json.loads(answers(found)["correct"])
    assert value["x"] == x
    assert value["y"] == (y or "target.v+0.5*(a.v-target.v)")


@pytest.mark.parametrize(
    ("utterance", "point", "along"),
    [
        ("closer to the red mug", [360, 438.6], "+0.4*(a.{0}-target.{0})"),
        ("a lot further off the red mug", [113.4, 581], "-100*a.way.{0}"),
    ],
)
def test_a_confirmed_point_tells_how_far_along_the_line_to_a_thing(
    tmp_path: Path, utterance: str, point: list[float], along: str
) -> None:
    said = correction(utterance, point, objects=[MUG], target=[200, 531])
    value = json.loads(answers(read(tmp_path, said))["correct"])
    assert value == {axis: f"target.{s}{along.format(s)}" for axis, s in (("x", "u"), ("y", "v"))}


@pytest.mark.parametrize(
    ("utterance", "point", "moves"),
    [
        ("2 cm left", [480, 400], []),  # a number was said: 20 px may be a bit, or 2 cm
        ("two centimetres left", [480, 400], []),
        ("again", [480, 400], [[-20, 0]]),  # a bit, or once more
        ("somewhere over there", [123, 45], []),
    ],
)
def test_no_meaning_is_guessed_where_several_fit_or_none(
    tmp_path: Path, utterance: str, point: list[float], moves: list[list[float]]
) -> None:
    found = read(tmp_path, correction(utterance, point, previous_moves=moves))
    assert set(answers(found)) == {"select", "objects"}
    assert found.unused == {NO_EXPRESSION: 1}
    assert NO_EXPRESSION in found.summary


def test_expressions_that_are_given_settle_it(tmp_path: Path) -> None:
    turn = correction(
        "again", [480, 400], previous_moves=[[-20, 0]], x="target.u + last.du", y="target.v+last.dv"
    )
    assert json.loads(answers(read(tmp_path, turn))["correct"])["x"] == "target.u+last.du"


def test_a_picture_of_another_size_is_scaled(tmp_path: Path) -> None:
    small = {key: value if key == "phrase" else value / 2 for key, value in MUG.items()}  # type: ignore[operator]  # numbers
    turn = correction("to the red mug", [300, 150], image=[640, 360], objects=[small])
    turn["target"] = [100, 100]
    question = read(tmp_path, turn).examples[-1]
    assert question.messages[1]["content"].startswith("past none, A middle\n")
    assert json.loads(question.answer) == {"x": "a.u", "y": "a.v"}


@pytest.mark.parametrize(
    ("turn", "reason"),
    [
        ("no json", "malformed"),
        ({"utterance": "x"}, "`module`"),
        ({"utterance": "x", "module": "dance"}, "'dance'"),
        ({"utterance": "x", "module": "prediction", "efector": "left_hand"}, "unknown field"),
        ({"utterance": " ", "module": "prediction"}, "no words"),
        ({"utterance": "x" * 600, "module": "prediction"}, "600 characters"),
        ({"utterance": "x", "module": "prediction", "image": [0, 720]}, "> 0"),
        ({"utterance": "lean on it", "module": "prediction", "objects": [MUG]}, "word for word"),
        (
            {"utterance": "left", "module": "correction", "point": [1, 2], "objects": []},
            "needs the target",
        ),
        (correction("left", [480, 400], x="target.u-20"), "both or none"),
        (correction("left", [480, 400], x="target.u-40", y="target.v"), r"give \(460, 400\)"),
        (correction("left", [480, 400], x="b.u", y="target.v"), "'b.u' is not known"),
        (correction("left", [480, 400], x="import os", y="target.v"), "is not"),
        (correction("left", [480, 400], x="1+" * 40 + "1", y="target.v"), "81 characters"),
    ],
)
def test_a_wrong_line_is_named_with_its_fault(
    tmp_path: Path, turn: dict[str, Any] | str, reason: str
) -> None:
    with pytest.raises(ConfigError, match=rf"mine.jsonl, line 2: .*{reason}"):
        read(tmp_path, {"utterance": "yes", "module": "confirmation"}, turn)


def test_an_empty_file_and_none(tmp_path: Path) -> None:
    with pytest.raises(ConfigError, match="no turn"):
        read(tmp_path, "")
    with pytest.raises(ConfigError, match="cannot be read"):
        read_dialogues(tmp_path / "missing")


def test_the_lines_of_the_reference_are_read(tmp_path: Path) -> None:
    page = ROOT / "docs" / "reference" / "dialogues.md"
    lines = page.read_text().partition("```json\n")[2].partition("```")[0].splitlines()
    found = read(tmp_path, *lines)
    assert found.lines == 4
    assert found.unused == {}
    tasks = [example.task for example in found.examples]
    assert tasks.count("correct") == 2
    assert {"relative", "analyze", "effector", "objects", "select"} <= set(tasks)
