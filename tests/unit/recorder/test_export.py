"""Streams become tables, conversations become data; only what was agreed to is for training."""

import csv
import json
from dataclasses import replace
from pathlib import Path
from typing import Any

import msgspec
import numpy as np
import pytest

from support.sessions import HEIGHT, WIDTH, Session, conversation, target, turn
from w2c import messages as m
from w2c import topics
from w2c.errors import ConfigError
from w2c.library import library
from w2c_recorder.columns import common_kind
from w2c_recorder.commands import recording
from w2c_recorder.conversations import conversations_of
from w2c_recorder.dataset import Camera, training_lines
from w2c_recorder.history import history_of
from w2c_recorder.reading import Recording


def table(path: Path, channel: str, out: Path, *more: str) -> list[dict[str, str]]:
    """Export a stream and read it back."""
    flags = ["--to", "csv", "--channel", channel, "--out", str(out), *more]
    assert recording(["export", str(path), *flags]) == 0
    with out.open(newline="") as file:
        return list(csv.DictReader(file))


def test_a_stream_becomes_a_table_with_a_column_a_number(
    session_file: Path, tmp_path: Path
) -> None:
    rows = table(session_file, "state/robot/joints", tmp_path / "a.csv")

    assert len(rows) == 10
    assert float(rows[3]["position[0]"]) == pytest.approx(0.3)
    assert rows[3]["tick"] == "3"
    assert rows[3]["mode"] == "tracking"
    assert rows[0]["sole_wrenches[1,5]"] == "0.0"
    assert float(rows[3]["seconds"]) == pytest.approx(3.33)


def test_a_part_of_a_recording_is_exported(session_file: Path, tmp_path: Path) -> None:
    rows = table(
        session_file, "state/robot/joints", tmp_path / "a.csv", "--start", "3.345", "--end", "3.365"
    )

    assert [row["tick"] for row in rows] == ["5", "6"]


def test_joints_have_their_names_where_somebody_asked_for_them(tmp_path: Path) -> None:
    session = conversation()
    joints = [m.JointInfo(name=name, stiffness=1.0, effort_limit=1.0) for name in ("hip", "knee")]
    description = m.RobotDescription(
        urdf="", joints=joints, sole_frames=("l", "r"), hand_frames=("l", "r"),
        hand_radius=(0.0, 0.0), camera_frame="c", initial_position=np.zeros(2),
        period_ns=2_000_000, lock_step=True,
    )  # fmt: skip
    session.call(0.1, topics.DESCRIBE, m.Empty(), description, caller="controller")
    rows = table(session.write(tmp_path / "a.mcap"), "cmd/controller/joints", tmp_path / "a.csv")

    assert float(rows[2]["position[hip]"]) == pytest.approx(0.2)
    assert float(rows[2]["position[knee]"]) == pytest.approx(-0.1)


def test_columns_that_come_later_are_in_the_table(tmp_path: Path) -> None:
    session = Session()
    for number, counters in enumerate(({}, {"late": 3})):
        health = m.Health(
            stamp_ns=0, service="llm", instance="0", phase="ready", pid=1, cpu_percent=1.5,
            memory_mb=2.0, counters=counters,
        )  # fmt: skip
        session.add(float(number), topics.HEALTH, health, sender="llm")
    rows = table(session.write(tmp_path / "a.mcap"), "health/llm/status", tmp_path / "a.csv")

    assert [row["counters.late"] for row in rows] == ["", "3"]


def test_pictures_and_fields_of_bytes_are_no_columns(session_file: Path, tmp_path: Path) -> None:
    (row, _) = table(session_file, "obs/camera/rgbd", tmp_path / "a.csv")

    assert "jpeg" not in row
    assert row["width"] == str(WIDTH)


def test_a_stream_that_is_not_there_names_those_that_are(session_file: Path) -> None:
    with pytest.raises(ConfigError, match="no stream 'state/robot'; it has cmd/controller/joints"):
        recording(["export", str(session_file), "--to", "csv", "--channel", "state/robot"])
    with pytest.raises(ConfigError, match="--to csv needs --channel"):
        recording(["export", str(session_file), "--to", "csv"])


def test_a_table_is_written_as_parquet(session_file: Path, tmp_path: Path) -> None:
    parquet = pytest.importorskip("pyarrow.parquet", reason="needs the extra parquet")
    out = tmp_path / "a.parquet"
    flags = ["--to", "parquet", "--channel", "state/robot/joints", "--out", str(out)]
    assert recording(["export", str(session_file), *flags]) == 0

    found = parquet.read_table(out).to_pylist()
    assert [row["tick"] for row in found] == list(range(10))
    assert found[3]["position[0]"] == pytest.approx(0.3)
    assert found[3]["mode"] == "tracking"


def test_a_column_has_the_type_of_all_its_cells() -> None:
    assert common_kind(None, 1) is int
    assert common_kind(int, 2.5) is float
    assert common_kind(float, 2) is float
    assert common_kind(int, "none") is str
    assert common_kind(str, 1.0) is str


# --- conversations


def lines_of(path: Path, refused: set[str] | None = None) -> list[dict[str, Any]]:
    """Return the lines for training; a line with a refused field is refused."""
    names = refused or set()
    history = history_of(Recording(path))
    found = conversations_of(history)
    cameras = {5 * 10**9: Camera(WIDTH, HEIGHT)}
    return [
        line
        for one in found
        for line in training_lines(
            history, one, "a", cameras, lambda line: str(names & line.keys() or "")
        )
    ]


def answered(task: str, answer: str, **more: Any) -> m.Evidence:
    return m.Evidence(prompts="embedded", answers=[m.ModelAnswer(task=task, answer=answer)], **more)


def one_place(*, corrected: bool = True) -> Session:
    """An instruction in words, corrected twice or not at all, and a yes in words."""
    session = Session()
    box = m.Box(left=100.0, top=50.0, right=140.0, bottom=90.0, score=0.9)
    first = target(1, 160.0, boxes=[box], phrases=["red mug"], instruction="left of the red mug")
    relative = answered("relative", '{"x":"a.right+20","y":"a.top+10"}')
    session.add(
        1.0, topics.TURN,
        turn(first.instruction, "prediction.relative", first, evidence=relative),
    )  # fmt: skip
    last = first
    if corrected:
        second = target(2, 140.0, corrections=1, instruction=first.instruction)
        session.add(
            2.0, topics.TURN,
            turn("to the left", "correction", second,
                 evidence=answered("correct", '{"x":"target.u-20","y":"target.v"}')),
        )  # fmt: skip
        last = target(3, 120.0, corrections=2, instruction=first.instruction)
        again = answered(
            "correct", '{"x":"target.u+last.du","y":"target.v"}', corrected_from=(140.0, 24.0)
        )
        session.add(3.0, topics.TURN, turn("same again", "correction", last, evidence=again))
    limb = answered("effector", '{"effector":"left_hand","task":"contact"}')
    session.add(
        4.0, topics.TURN, turn("yes", "confirmation", last, goal_id="goal-9", evidence=limb)
    )
    return session


def test_a_place_that_was_agreed_to_teaches_all_its_fields(tmp_path: Path) -> None:
    path = one_place(corrected=False).write(tmp_path / "a.mcap")

    instruction, yes = lines_of(path)

    assert instruction == {
        "id": "a#0", "utterance": "left of the red mug", "module": "prediction",
        "end_effector": "left_hand", "task_type": "contact", "position": "relative",
        "point": [160.0, 24.0], "image": [WIDTH, HEIGHT],
        "objects": [{"phrase": "red mug", "cx": 120.0, "cy": 70.0, "w": 40.0, "h": 40.0}],
        "x": "a.right+20", "y": "a.top+10",
    }  # fmt: skip
    assert yes == {"id": "a#1", "utterance": "yes", "module": "confirmation"}


def test_a_place_that_was_corrected_teaches_neither_point_nor_objects(tmp_path: Path) -> None:
    instruction, first, last, _ = lines_of(one_place().write(tmp_path / "a.mcap"))

    assert instruction.keys() == {"id", "utterance", "module", "end_effector", "task_type"}
    assert (first["target"], first["previous_moves"]) == ([160.0, 24.0], [])
    assert "point" not in first
    assert (last["target"], last["point"]) == ([140.0, 24.0], [120.0, 24.0])
    assert last["previous_moves"] == [[-20.0, 0.0]]
    assert last["x"] == "target.u+last.du"


def test_without_a_yes_nothing_is_for_training(tmp_path: Path) -> None:
    session = one_place()
    session.raw.pop()

    assert lines_of(session.write(tmp_path / "a.mcap")) == []


def test_what_the_reader_refuses_is_left_out(tmp_path: Path) -> None:
    path = one_place(corrected=False).write(tmp_path / "a.mcap")

    assert "x" not in lines_of(path, {"x"})[0]
    assert lines_of(path, {"objects"})[0].keys() & {"objects", "point", "position"} == set()
    assert lines_of(path, {"utterance"}) == []


@pytest.mark.parametrize("recorded", [True, False])
def test_an_answer_to_a_question_stands_for_what_was_asked_about(
    tmp_path: Path, recorded: bool
) -> None:
    session = Session()
    shown = target(1, 40.0, instruction="on the mug")
    if recorded:
        session.add(0.5, topics.TURN, turn("on the mug", "question", None, ok=False))
    session.add(1.0, topics.TURN, turn("the red one", "prediction.absolute", shown))
    session.add(2.0, topics.TURN, turn("yes", "confirmation", shown, goal_id="goal-1"))

    lines = lines_of(session.write(tmp_path / "a.mcap"))

    said = [(line["utterance"], line["module"]) for line in lines]
    instruction = [("on the mug", "prediction")] if recorded else []
    assert said == [*instruction, ("yes", "confirmation")]


@pytest.mark.parametrize(
    ("asked", "limb"),
    [("left of the red mug", "left_hand"), ("on the table", None)],
    ids=["these words", "others"],
)
def test_the_limb_may_have_been_asked_for_before_the_yes(
    tmp_path: Path, asked: str, limb: str | None
) -> None:
    session = Session()
    shown = target(1, 40.0, instruction="Left of the red mug!")
    session.add(1.0, topics.TURN, turn(shown.instruction, "prediction.absolute", shown))
    chat = [m.ChatMessage(role="user", content=asked)]
    answer = {"effector": "left_hand", "task": "contact"}
    session.call(
        1.5, topics.COMPLETE, m.CompleteRequest(messages=chat, schema={}),
        m.CompleteReply(
            text="", value=answer, model="tiny", prompt_tokens=1, reused_tokens=0,
            completion_tokens=1, queue_ms=0, prefill_ms=0, decode_ms=0,
        ),
    )  # fmt: skip
    session.add(2.0, topics.TURN, turn("yes", "confirmation", shown, goal_id="goal-1"))

    instruction, _ = lines_of(session.write(tmp_path / "a.mcap"))

    assert instruction.get("end_effector") == limb


def test_the_centimetres_of_a_correction_are_those_at_the_earlier_target(tmp_path: Path) -> None:
    history = history_of(Recording(one_place().write(tmp_path / "a.mcap")))
    (one,) = conversations_of(history)
    seen = one.turns[1]
    assert seen.message.target is not None
    nearer = msgspec.structs.replace(seen.message.target, point=np.array([0.5, -0.2, 1.3]))
    one.turns[1] = replace(seen, message=msgspec.structs.replace(seen.message, target=nearer))
    pose = np.eye(4)
    pose[:3, :3] = np.diag([1.0, -1.0, -1.0])
    pose[:3, 3] = (0.5, -0.2, 1.8)  # half a metre above it
    view = m.CameraView(
        stamp_ns=1, world_from_camera=pose, intrinsics=(900.0, 900.0, 32.0, 24.0), width=64,
        height=48,
    )  # fmt: skip
    cameras = {5 * 10**9: Camera(64, 48, view)}
    last = list(training_lines(history, one, "a", cameras, lambda _: ""))[2]

    assert last["px_per_cm"] == pytest.approx(18.0)


def test_the_scale_at_a_target_comes_from_the_camera() -> None:
    pose = np.eye(4)
    pose[:3, :3] = np.diag([1.0, -1.0, -1.0])  # looks down
    pose[:3, 3] = (0.5, -0.2, 1.8)
    view = m.CameraView(
        stamp_ns=1, world_from_camera=pose, intrinsics=(900.0, 900.0, 32.0, 24.0), width=64,
        height=48,
    )  # fmt: skip

    assert Camera(64, 48, view).pixels_per_cm(target(1, 40.0)) == pytest.approx(9.0)  # 1 m below
    assert Camera(64, 48).pixels_per_cm(target(1, 40.0)) is None


def test_the_written_lines_are_those_that_training_reads(tmp_path: Path) -> None:
    out = tmp_path / "data"
    path = one_place().write(tmp_path / "a.mcap")

    assert recording(["export", str(path), "--to", "dataset", "--out", str(out)]) == 0

    found = library("dialogue_examples")(out / "dialogues.jsonl")
    assert found.lines == 4
    assert len(found.examples) > 4


def test_all_that_is_known_of_a_conversation_is_written_with_its_picture(
    session_file: Path, tmp_path: Path
) -> None:
    out = tmp_path / "data"
    recording(["export", str(session_file), "--to", "dataset", "--out", str(out)])

    (known,) = [json.loads(line) for line in (out / "conversations.jsonl").read_text().splitlines()]
    assert (known["outcome"], known["corrections"], known["distance_m"]) == ("loaded", 1, 0.004)
    assert [one["utterance"] for one in known["turns"]] == ["on the book", "to the left"]
    assert known["turns"][0]["objects"][0]["phrase"] == "book"
    assert known["confirmed"]["point"] == [0.5, -0.2, 0.8]
    picture = out / known["confirmed"]["picture"]
    assert picture.read_bytes()[:2] == b"\xff\xd8"


def test_what_was_never_agreed_to_says_so(tmp_path: Path) -> None:
    session = one_place()
    session.raw.pop()
    session.add(5.0, topics.TURN, turn("hm", "none", None, ok=False))
    (known,) = conversations_of(history_of(Recording(session.write(tmp_path / "a.mcap"))))

    assert known.outcome == "not confirmed"
    assert [one.message.text for one in known.failed] == ["hm"]


def test_a_yes_belongs_to_the_target_that_it_names(tmp_path: Path) -> None:
    session = Session()
    first, second = target(1, 40.0, instruction="here"), target(2, 20.0, instruction="there")
    session.add(1.0, topics.TURN, turn("here", "prediction.absolute", first))
    session.add(2.0, topics.TURN, turn("there", "prediction.absolute", second))
    session.add(3.0, topics.TURN, turn("yes", "confirmation", first, goal_id="goal-1"))

    outcomes = [
        one.outcome
        for one in conversations_of(history_of(Recording(session.write(tmp_path / "a"))))
    ]

    assert outcomes == ["confirmed", "not confirmed"]
