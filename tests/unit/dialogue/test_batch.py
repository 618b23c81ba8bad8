"""`dialogue batch`: lines in, lines out, with the modules of the dialogue."""

from codecs import BOM_UTF8
from collections.abc import Mapping
from contextlib import nullcontext
from pathlib import Path
from typing import Any

import msgspec
import pytest

from w2c.errors import (
    ConfigError,
    ConnectionFailedError,
    DeadlineError,
    ProcessError,
    UnavailableError,
)
from w2c_dialogue.batch import commands
from w2c_dialogue.batch.answering import Answering, find_words, name_things
from w2c_dialogue.batch.commands import answer_line
from w2c_dialogue.batch.lines import Thing
from w2c_dialogue.batch.patience import Patience
from w2c_dialogue.interfaces import Choice
from w2c_dialogue.prompts.base import Question
from w2c_dialogue.prompts.embedded import EmbeddedPrompts
from w2c_dialogue.utterance import Span, parse

CUP = {"phrase": "cup", "cx": 600, "cy": 300, "w": 40, "h": 60}
JAR = {"phrase": "the jar", "cx": 900, "cy": 320, "w": 50, "h": 80}


class Model:
    """Answers by task; remembers what it was asked."""

    language_model = "scripted"

    def __init__(self, **answers: Any) -> None:
        self.answers = answers
        self.asked: list[Question] = []
        self.priors: list[Mapping[str, float]] = []

    def complete(self, question: Question) -> Any:
        self.asked.append(question)
        answer = self.answers[question.task]
        if isinstance(answer, Exception):
            raise answer
        return answer

    def choose(self, question: Question, log_prior: Mapping[str, float]) -> Choice:
        self.priors.append(log_prior)
        option = self.answers["select"]
        option = option.pop(0) if isinstance(option, list) else option
        return Choice(option, {option: 1.0})


def answer(model: Model, line: dict[str, Any]) -> dict[str, Any]:
    return answer_line(Answering(model, EmbeddedPrompts()), msgspec.json.encode(line))


def test_each_task_has_its_fields() -> None:
    model = Model(
        select="correction",
        analyze={"position": "relative", "objects": ["4-4"]},
        effector={"effector": "left_hand", "task": "reach"},
    )

    assert answer(model, {"id": 1, "task": "select", "text": "left"}) == {
        "id": 1,
        "module": "correction",
        "probabilities": {"correction": 1.0},
    }
    assert answer(model, {"id": "b", "task": "analyze", "text": "left of the Cup."}) == {
        "id": "b",
        "position": "relative",
        "objects": ["Cup"],
    }
    assert answer(model, {"id": "c", "task": "effector", "text": "grab it"}) == {
        "id": "c",
        "end_effector": "left_hand",
        "task_type": "reach",
    }


def test_objects_are_returned_as_they_were_typed() -> None:
    model = Model(analyze={"position": "absolute", "objects": ["2-3"]})
    line = {"id": "q", "task": "analyze", "text": "on Mum\u2019s mug"}

    assert answer(model, line)["objects"] == ["Mum\u2019s mug"]


def test_a_relative_place_is_computed_from_the_given_boxes() -> None:
    model = Model(relative={"x": "(a.right+b.left)/2", "y": "a.v-2*cm"})
    line = {"id": "r", "task": "relative", "text": "between the cup and the jar"}

    found = answer(model, {**line, "objects": [JAR, CUP], "px_per_cm": 5})

    assert found == {"id": "r", "point": [747.5, 290.0], "clipped": False}
    assert model.asked[0].messages[1].content == "A left of B\nbetween the A and the B"


def test_the_analyzer_finds_things_whose_words_are_not_in_the_text() -> None:
    model = Model(
        analyze={"position": "relative", "objects": ["4-4"]}, relative={"x": "a.u", "y": "a.top"}
    )
    line = {"id": "r", "task": "relative", "text": "behind of the cups", "objects": [CUP]}

    assert answer(model, line)["point"] == [600.0, 270.0]
    assert [question.task for question in model.asked] == ["analyze", "relative"]


def test_things_that_are_not_spoken_of_are_passed_over() -> None:
    model = Model(
        analyze={"position": "relative", "objects": ["4-4"]}, relative={"x": "a.u", "y": "a.v"}
    )
    line = {"id": "r", "task": "relative", "text": "left of the cup", "objects": [JAR, CUP]}

    assert answer(model, line)["point"] == [600.0, 300.0]


def test_the_table_that_things_stand_on_need_not_be_among_the_objects() -> None:
    model = Model(
        analyze={"position": "relative", "objects": ["8-8", "4-5"]},
        relative={"x": "a.u", "y": "a.v"},
    )
    text = "left of the cups there on the table"
    line = {"id": "r", "task": "relative", "text": text, "objects": [{**CUP, "phrase": "big cups"}]}

    found = answer(model, line)

    assert found["point"] == [600.0, 300.0]
    assert model.asked[1].messages[1].content.endswith("left of the A on the table")


def test_what_it_means_is_what_the_line_gives() -> None:
    model = Model(
        analyze={"position": "relative", "objects": []}, relative={"x": "a.left", "y": "a.v"}
    )
    line = {"id": "r", "task": "relative", "text": "left of it", "objects": [CUP]}

    assert answer(model, line)["point"] == [580.0, 300.0]


def test_things_that_nobody_can_tell_apart_are_an_error_of_the_line() -> None:
    model = Model(analyze={"position": "relative", "objects": ["4-4", "7-7"]})
    line = {"id": "r", "task": "relative", "text": "left of the mug near the vase"}

    assert "'mug', 'vase' were heard" in answer(model, {**line, "objects": [CUP]})["error"]


def test_fields_that_are_null_are_as_good_as_left_out() -> None:
    model = Model(correct={"x": "target.u-cm", "y": "target.v"})
    line = {"id": "k", "task": "correct", "text": "a cm left", "target": [500, 300]}
    nothing = {"previous_moves": None, "objects": None, "px_per_cm": None}

    assert answer(model, {**line, **nothing})["point"] == [490.0, 300.0]


def test_a_correction_knows_the_moves_before_it() -> None:
    model = Model(correct={"x": "start.u+last.du+moves[-2].du", "y": "target.v"})
    line = {"id": "k", "task": "correct", "text": "again", "target": [500, 300]}

    found = answer(model, {**line, "previous_moves": [[-40, 0], [10, 5]]})

    assert found["point"] == [500.0, 300.0]
    assert model.asked[0].messages[1].content == "past left, right down\nagain"


def test_an_earlier_move_that_is_not_there_is_an_error_of_the_line() -> None:
    model = Model(correct={"x": "target.u+last.du", "y": "target.v"})
    line = {"id": "k", "task": "correct", "text": "again", "target": [500, 300]}

    assert "earlier move" in answer(model, line)["error"]


def test_without_a_target_the_first_turn_is_an_instruction() -> None:
    model = Model(select=["prediction", "correction", "confirmation", "prediction"])
    turns = ["on the cup", "left", "ok", "the jar"]

    found = answer(model, {"id": "d", "task": "dialogue", "turns": turns})

    assert found["modules"] == ["prediction", "correction", "confirmation", "prediction"]
    assert [bool(prior) for prior in model.priors] == [True, False, False, False]


@pytest.mark.parametrize(
    ("line", "reason", "number"),
    [
        (b"{broken", "malformed", None),
        (b"[]", "object", None),
        (b'{"id": 7, "task": "dance", "text": "x"}', "dance", 7),
        (b'{"id": 8, "task": "select"}', "text", 8),
        (b'{"id": 9, "task": "select", "text": ""}', "no words", 9),
        (b'{"id": 10, "task": "correct", "text": "left", "target": [1e999, 2]}', "range", 10),
        (
            b'{"id": 11, "task": "relative", "text": "left of it", "objects": [{"phrase": "it", '
            b'"cx": 1, "cy": 1, "w": -2, "h": 2}]}',
            "objects",
            11,
        ),
        (b"[" * 100_000, "nested too deeply", None),
        (b'{"id": "\\ud800", "task": "select", "text": "left"}', "surrogate", None),
        (b'{"id": {"a": 1}, "task": "select", "text": "left"}', "int | str", None),
        (b'{"id": 1e999, "task": "select", "text": "left"}', "range", None),
        (b'{"id": 12, "task": "correct", "text": "left", "target": null}', "target", 12),
        (b'{"id": 13, "task": "dialogue", "turns": ["on the cup", "?"]}', "turn 2: I heard", 13),
    ],
)
def test_a_bad_line_is_answered_with_the_reason(
    line: bytes, reason: str, number: int | None
) -> None:
    found = answer_line(Answering(Model(select="correction"), EmbeddedPrompts()), line)

    assert found["id"] == number
    assert reason in found["error"]
    assert msgspec.json.decode(msgspec.json.encode(found)) == found, "it can be written"


def test_a_slow_model_fails_a_line_and_a_lost_one_the_batch() -> None:
    line = {"id": "e", "task": "effector", "text": "grab it"}

    assert "too late" in answer(Model(effector=DeadlineError("too late")), line)["error"]
    with pytest.raises(ConnectionFailedError):
        answer(Model(effector=ConnectionFailedError("gone")), line)


def test_a_model_that_is_started_anew_is_waited_for_once() -> None:
    gone, right = UnavailableError("nobody"), {"effector": "left_hand", "task": "reach"}
    line = b'{"id": "e", "task": "effector", "text": "grab it"}'
    model = Model(effector=gone)
    waited: list[float] = []

    def pause(seconds: float) -> None:
        waited.append(seconds)
        if len(waited) == 3:
            model.answers["effector"] = right

    patience = Patience(pause=pause)
    answering = Answering(model, EmbeddedPrompts())
    assert answer_line(answering, line, patience)["end_effector"] == "left_hand"
    assert waited == [1.0, 2.0, 4.0]

    model.answers["effector"] = gone
    waited[:] = [0.0] * 10
    assert "nobody" in answer_line(answering, line, patience)["error"]
    assert "nobody" in answer_line(answering, line, patience)["error"]
    assert len(waited) == 14, "the second line did not wait"
    model.answers["effector"] = right
    assert "error" not in answer_line(answering, line, patience)
    model.answers["effector"] = gone
    answer_line(answering, line, patience)
    assert len(waited) == 18, "it answered meanwhile: it is waited for again"


def test_words_of_a_thing_are_found_once_each() -> None:
    utterance = parse("from the mug to the other mug's handle")

    assert find_words(utterance, "Mug", []) == Span(3, 3)
    assert find_words(utterance, "mug", [Span(3, 3)]) == Span(7, 7)
    assert find_words(utterance, "other mug", []) == Span(6, 7)
    assert find_words(utterance, "jar", []) is None
    assert name_things(utterance, [Thing(phrase="jar", cx=0, cy=0, w=1, h=1)]) is None


class Silent:
    """A bus that nobody asks: the model is scripted."""


def run(
    monkeypatch: pytest.MonkeyPatch, model: Model, directory: Path, *flags: str, status: int = 0
) -> list[dict[str, Any]]:
    """Run the command, and return the answers that it leaves."""
    monkeypatch.setattr(commands, "_language_model", lambda _: nullcontext(Silent()))
    monkeypatch.setattr(commands, "RemoteServices", lambda *_, **__: model)
    files = ["--in", str(directory / "in.jsonl"), "--out", str(directory / "out.jsonl")]
    assert commands.batch([*files, *flags]) == status
    return [msgspec.json.decode(line) for line in (directory / "out.jsonl").open("rb")]


def test_every_line_has_its_answer_in_its_place(
    monkeypatch: pytest.MonkeyPatch, tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    lines = [b'{"id": 1, "task": "select", "text": "left"}', b"", b"{broken", b"[" * 50_000]
    lines.append(b'{"id": "z", "task": "select", "text": "yes"}')
    (tmp_path / "in.jsonl").write_bytes(BOM_UTF8 + b"\r\n".join(lines))
    model = Model(select=["correction", "confirmation"])

    found = run(monkeypatch, model, tmp_path, "--json", str(tmp_path / "results.json"))

    assert [answer["id"] for answer in found] == [1, None, None, "z"]
    assert [answer.get("module") for answer in found] == ["correction", None, None, "confirmation"]
    assert "2 of 4 lines could not be answered" in capsys.readouterr().err
    results = msgspec.json.decode((tmp_path / "results.json").read_bytes())
    rows = {(row["case"], row["metric"]): row for row in results["rows"]}
    assert results["benchmark"] == "dialogue.batch"
    assert rows["select", "answered"]["value"] == rows["select", "answered"]["n"] == 2
    assert rows["malformed", "answered"]["value"] == 0
    assert rows["select", "seconds"]["spread"][0] <= rows["select", "seconds"]["value"]


def test_a_batch_that_was_cut_short_goes_on_where_it_was(
    monkeypatch: pytest.MonkeyPatch, tmp_path: Path
) -> None:
    lines = [{"id": n, "task": "select", "text": "left"} for n in range(4)]
    (tmp_path / "in.jsonl").write_bytes(b"\n".join(map(msgspec.json.encode, lines)))
    (tmp_path / "out.jsonl").write_bytes(b'{"id":0,"module":"kept"}\n{"id":1,"error":"k"}\n{"id":')

    found = run(monkeypatch, Model(select="correction"), tmp_path, "--resume")

    assert [answer["id"] for answer in found] == [0, 1, 2, 3]
    assert found[0]["module"] == "kept"
    assert found[3]["module"] == "correction"
    assert run(monkeypatch, Model(), tmp_path, "--resume") == found, "nothing is left to ask"


def test_a_batch_does_not_go_on_behind_answers_to_other_lines(
    monkeypatch: pytest.MonkeyPatch, tmp_path: Path
) -> None:
    (tmp_path / "in.jsonl").write_bytes(b'{"id": 1, "task": "select", "text": "left"}')
    (tmp_path / "out.jsonl").write_bytes(b'{"id":2,"module":"x"}\n')

    with pytest.raises(ConfigError, match=r"line 1 of .* answers another file"):
        run(monkeypatch, Model(), tmp_path, "--resume")
    assert (tmp_path / "out.jsonl").read_bytes() == b'{"id":2,"module":"x"}\n'


@pytest.mark.parametrize(
    ("flags", "reason"),
    [
        (["--model", "nowhere.gguf"], "no file nowhere.gguf"),
        (["--model", "nowhere.gguf", "--attach"], "leave it out with --attach"),
    ],
)
def test_a_model_that_is_not_there_is_told_before_anything_starts(
    tmp_path: Path, flags: list[str], reason: str
) -> None:
    with pytest.raises(ConfigError, match=reason):
        commands.batch(["--in", "in.jsonl", "--out", str(tmp_path / "out.jsonl"), *flags])
    assert not (tmp_path / "out.jsonl").exists()


def test_logs_stay_where_a_model_did_not_start(
    monkeypatch: pytest.MonkeyPatch, tmp_path: Path
) -> None:
    monkeypatch.setattr("tempfile.tempdir", str(tmp_path))
    with commands._run_directory() as directory:
        (directory / "launcher.log").touch()
    assert not directory.exists()
    with pytest.raises(ProcessError), commands._run_directory() as directory:
        raise ProcessError("it did not start")
    assert directory.exists()
