"""Perception of today says of yesterday's pictures what it said then."""

from collections import Counter
from pathlib import Path

import numpy as np
import pytest
from msgspec.structs import replace

from support.rewriting import rewrapped, rewritten
from w2c import topics
from w2c.messages import CallTrace, CameraView, LiftReply, Message, RobotState
from w2c_recorder.reading import Recorded, Recording, decode_call
from w2c_recorder.report import Report
from w2c_recorder.through.commands import compare
from w2c_recorder.through.options import ThroughOptions

RECORDING = Path(__file__).parent / "perception.mcap"
VIEW, LIFT, HEIGHTS = "state/perception/view", "perception/lift", "perception/heights"


def through(path: Path) -> Report:
    return compare(path, ThroughOptions(service="perception"))


@pytest.fixture(scope="module")
def kinds() -> Counter[str]:
    """How many views and answers of each kind were recorded."""
    found: Counter[str] = Counter()
    for recorded in Recording(RECORDING).of(topics.CAMERA_VIEW, topics.TRACE):
        if isinstance(recorded.message, CameraView):
            found[VIEW] += 1
        elif isinstance(recorded.message, CallTrace) and recorded.message.service == "perception":
            found[f"perception/{recorded.message.method}"] += 1
    return found


def test_every_view_and_every_answer_is_made_again(kinds: Counter[str]) -> None:
    report = through(RECORDING)
    assert report.status == 0, "\n".join(report.lines)
    outputs = report.values["outputs"]
    assert {name: count["compared"] for name, count in outputs.items()} == dict(kinds)
    assert not any(count["skipped"] for count in outputs.values())
    assert kinds[LIFT] == 3  # one of them is refused


def test_a_point_that_moved_is_a_difference(tmp_path: Path) -> None:
    def move(recorded: Recorded) -> Message | None:
        trace = recorded.message
        if not isinstance(trace, CallTrace):
            return trace
        _, reply = decode_call(trace)
        if not isinstance(reply, LiftReply):
            return trace
        moved = replace(reply, point=reply.point + np.array([0.0, 0.0, 0.001]))
        return replace(trace, reply=rewrapped(trace.reply, moved))

    report = through(rewritten(RECORDING, tmp_path / "moved.mcap", move))
    assert report.status == 1
    assert report.values["outputs"][LIFT]["differ"] == 2
    assert report.values["first_difference"]["places"][0].startswith("point[2]: ")


def test_what_was_not_recorded_is_skipped_with_the_reason(
    tmp_path: Path, kinds: Counter[str]
) -> None:
    def lose(recorded: Recorded) -> Message | None:
        view = recorded.message
        return replace(view, state_ticks=[]) if isinstance(view, CameraView) else view

    report = through(rewritten(RECORDING, tmp_path / "older.mcap", lose))
    assert report.status == 1
    assert report.values["outputs"][VIEW]["skipped"] == {
        "the view does not say which states it was made of: of an older version": kinds[VIEW]
    }
    assert not report.values["outputs"][HEIGHTS]["compared"]


def test_lost_states_make_no_other_point(tmp_path: Path) -> None:
    views = [one.message for one in Recording(RECORDING).of(topics.CAMERA_VIEW)]
    last = max(tick for view in views if isinstance(view, CameraView) for tick in view.state_ticks)

    def lose(recorded: Recorded) -> Message | None:
        state = recorded.message
        return None if isinstance(state, RobotState) and state.tick == last else state

    counts = through(rewritten(RECORDING, tmp_path / "lost.mcap", lose)).values["outputs"]
    assert list(counts[VIEW]["skipped"]) == [
        "1 of the states that it was made of are not in the recording"
    ]
    assert not any(count["differ"] for count in counts.values())
