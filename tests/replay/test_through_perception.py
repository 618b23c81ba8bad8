"""Perception of today says of yesterday's pictures what it said then."""

from collections import Counter
from collections.abc import Callable
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from msgspec.structs import replace

from support.rewriting import rewrapped, rewritten
from w2c import topics
from w2c.messages import CallTrace, CameraFrame, CameraView, LiftReply, Message, RobotState
from w2c_recorder.reading import Recorded, Recording, decode_call
from w2c_recorder.report import Report
from w2c_recorder.through.commands import compare
from w2c_recorder.through.options import ThroughOptions

RECORDING = Path(__file__).parent / "perception.mcap"
VIEW, LIFT, HEIGHTS = "state/perception/view", "perception/lift", "perception/heights"


def through(path: Path) -> Report:
    return compare(path, ThroughOptions(service="perception"))


def views() -> list[CameraView]:
    recorded = Recording(RECORDING).of(topics.CAMERA_VIEW)
    return [one.message for one in recorded if isinstance(one.message, CameraView)]


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


def alike(count: dict[str, Any]) -> int:
    """Return how many are equal; on another processor than the recording's, but for rounding."""
    return int(count["equal"] + count["within"])


def losing_first(
    kind: type[CameraFrame | CameraView],
) -> Callable[[Recorded], Message | None]:
    """Return what leaves out the first picture of a recording, or the view of it."""
    first = min(view.stamp_ns for view in views())

    def lose(recorded: Recorded) -> Message | None:
        message = recorded.message
        return None if isinstance(message, kind) and message.stamp_ns == first else message

    return lose


def test_a_lost_picture_leaves_the_states_that_were_taken_with_it(
    tmp_path: Path, kinds: Counter[str]
) -> None:
    lose = losing_first(CameraFrame)
    count = through(rewritten(RECORDING, tmp_path / "picture.mcap", lose)).values["outputs"][VIEW]
    assert count["skipped"] == {"the picture is not in the recording": 1}
    assert alike(count) == kinds[VIEW] - 1


def test_after_a_lost_view_nobody_knows_which_states_came_before(
    tmp_path: Path, kinds: Counter[str]
) -> None:
    lose = losing_first(CameraView)
    count = through(rewritten(RECORDING, tmp_path / "view.mcap", lose)).values["outputs"][VIEW]
    assert sum(count["skipped"].values()) == kinds[VIEW] - 1
    assert not count["differ"]


def without_state(path: Path, lost: int, shift: float = 0.0) -> dict[str, Any]:
    """Return how views compare without one state, and with the last one moved [m]."""
    last = max(view.stamp_ns for view in views())

    def change(recorded: Recorded) -> Message | None:
        message = recorded.message
        if isinstance(message, RobotState) and message.tick == lost:
            return None
        if shift and isinstance(message, CameraView) and message.stamp_ns == last:
            return replace(message, world_from_camera=message.world_from_camera + shift)
        return message

    outputs = through(rewritten(RECORDING, path, change)).values["outputs"]
    assert not any(outputs[name]["differ"] for name in (LIFT, HEIGHTS))
    return dict(outputs[VIEW])


def test_a_view_without_the_states_around_it_cannot_be_judged_and_others_can(
    tmp_path: Path, kinds: Counter[str]
) -> None:
    ticks = [tick for view in views() for tick in view.state_ticks]
    last = max(view.stamp_ns for view in views())
    at_picture = next(
        one.message.tick
        for one in Recording(RECORDING).of(topics.ROBOT_STATE)
        if isinstance(one.message, RobotState) and one.message.stamp_ns >= last
    )
    count = without_state(tmp_path / "near.mcap", at_picture, 0.001)
    reason = "1 of the states that it was made of are not in the recording"
    assert (alike(count), count["differ"]) == (kinds[VIEW] - 1, 0)
    assert count["skipped"] == {reason: 1}
    assert alike(without_state(tmp_path / "far.mcap", ticks[50])) == kinds[VIEW]
    assert without_state(tmp_path / "moved.mcap", ticks[50], 0.001)["differ"] == 1


def test_a_world_that_began_with_a_lost_state_may_be_elsewhere(tmp_path: Path) -> None:
    count = without_state(tmp_path / "first.mcap", views()[0].state_ticks[0], 0.001)
    assert not count["differ"]
    assert count["skipped"] == {
        "where the feet stand was found with states that are not in the recording": 1
    }
