"""A recorded session is a regression test: the controller of today gives yesterday's commands."""

import json
from collections import Counter
from pathlib import Path

import pytest
from msgspec.structs import replace

from support.rewriting import rewritten
from w2c import topics
from w2c.errors import ConfigError, RecordingError
from w2c.messages import CallTrace, JointCommand, Message
from w2c_recorder.reading import Recorded, Recording
from w2c_recorder.report import Report
from w2c_recorder.through.commands import compare, run
from w2c_recorder.through.options import ThroughOptions

RECORDING = Path(__file__).parent / "controller.mcap"
ELSEWHERE = 1e-6
"""Other processors round sums otherwise, and the loop of robot and controller is not closed here:
what was recorded goes in."""
COMMAND = "cmd/controller/joints"
UNHEARD = (22, 23, 24)
LOST = (30, 31, 32)
"""After the goal, before the snapshot that was asked for."""
ALTERED = {20: 1e-7, 25: 1e-4}
"""Tick -> by how much [rad]"""


def through(path: Path, tolerance: float | None = ELSEWHERE) -> Report:
    return compare(path, ThroughOptions(service="controller", tolerance=tolerance))


def tick_of(recorded: Recorded) -> int:
    return int(getattr(recorded.message, "tick", -1))


@pytest.fixture(scope="module")
def kinds() -> Counter[str]:
    """How many messages of each kind were recorded."""
    return Counter(type(one.message).__name__ for one in Recording(RECORDING).messages())


@pytest.fixture(scope="module")
def snapshots() -> list[int]:
    return [tick_of(one) for one in Recording(RECORDING).of(topics.CONTROLLER_SNAPSHOT)]


def test_every_recorded_output_is_made_again(kinds: Counter[str]) -> None:
    report = through(RECORDING)
    assert report.status == 0, "\n".join(report.lines)
    outputs = report.values["outputs"]
    assert {name: count["compared"] for name, count in outputs.items()} == {
        COMMAND: kinds["JointCommand"],
        "event/controller/goal": kinds["GoalEvent"],
        "event/controller/safety": kinds["SafetyEvent"],
        "state/controller/snapshot": kinds["ControllerSnapshot"],
        "state/controller/status": kinds["ControllerStatus"],
    }
    assert not any(count["skipped"] for count in outputs.values())
    assert min(kinds["GoalEvent"], kinds["SafetyEvent"]) >= 2


def test_lost_commands_are_made_all_the_same_and_after_lost_states_it_goes_on_from_a_snapshot(
    tmp_path: Path, kinds: Counter[str], snapshots: list[int]
) -> None:
    def lose(recorded: Recorded) -> Message | None:
        state_lost = recorded.topic is topics.ROBOT_STATE and tick_of(recorded) in LOST
        command_lost = recorded.topic is topics.JOINT_COMMAND and tick_of(recorded) in UNHEARD
        return None if state_lost or command_lost else recorded.message

    report = through(rewritten(RECORDING, tmp_path / "lost.mcap", lose))
    count = report.values["outputs"][COMMAND]
    skipped = min(tick for tick in snapshots if tick > LOST[-1]) - LOST[0] + 1
    assert report.status == 0
    assert sum(count["skipped"].values()) == skipped
    assert count["compared"] == kinds["JointCommand"] - skipped - len(UNHEARD)
    assert not count["differ"]
    reasons = " ".join(count["skipped"])
    assert f"the state of tick {LOST[0]} is not in the recording" in reasons


def test_the_first_difference_is_shown_with_what_it_was_made_of(
    tmp_path: Path, snapshots: list[int], capsys: pytest.CaptureFixture[str]
) -> None:
    def alter(recorded: Recorded) -> Message | None:
        if not isinstance(recorded.message, JointCommand) or tick_of(recorded) not in ALTERED:
            return recorded.message
        position = recorded.message.position.copy()
        position[5] += ALTERED[tick_of(recorded)]
        return replace(recorded.message, position=position)

    path = rewritten(RECORDING, tmp_path / "altered.mcap", alter)
    result = tmp_path / "result.json"
    options = ThroughOptions(service="controller", tolerance=ELSEWHERE, json=result)
    assert run(path, options) == 1
    text = capsys.readouterr().out
    assert f"FIRST DIFFERENCE: {COMMAND}, tick 25, at " in text
    assert "position[5] leg_left_6_joint: " in text
    assert "0.0001 apart" in text
    assert "state of tick 25, robot time 0.050 s" in text
    after = min(tick for tick in snapshots if tick > 25) - 25
    assert f"skipped {after}: after the command of tick 25, which differs" in text
    values = json.loads(result.read_text())
    count = values["outputs"][COMMAND]
    assert count["differ"] == 1
    assert count["within"] >= 1  # on another processor than the recording's, all but for rounding
    assert count["largest_within"] == pytest.approx(1e-7, rel=1e-2)
    assert values["first_difference"]["which"] == "tick 25"


def test_a_goal_that_nobody_asked_for_is_not_guessed(tmp_path: Path) -> None:
    def forget(recorded: Recorded) -> Message | None:
        trace = recorded.message
        return None if isinstance(trace, CallTrace) and trace.method == "place" else trace

    count = through(rewritten(RECORDING, tmp_path / "asked.mcap", forget)).values["outputs"][
        COMMAND
    ]
    assert list(count["skipped"]) == [
        "the call that asked for goal 'reach' is not in the recording"
    ]
    assert not count["differ"]


def test_a_recording_that_begins_later_is_compared_from_its_first_snapshot_on(
    tmp_path: Path, kinds: Counter[str], snapshots: list[int]
) -> None:
    begin = 10

    def late(recorded: Recorded) -> Message | None:
        return None if 0 <= tick_of(recorded) < begin else recorded.message

    count = through(rewritten(RECORDING, tmp_path / "late.mcap", late)).values["outputs"][COMMAND]
    first = min(tick for tick in snapshots if tick >= begin)
    assert count["compared"] == kinds["JointCommand"] - first - 1
    assert not count["differ"]


def test_what_cannot_be_run_says_what_is_missing(tmp_path: Path) -> None:
    def forget(recorded: Recorded) -> Message | None:
        return None if isinstance(recorded.message, CallTrace) else recorded.message

    with pytest.raises(RecordingError, match="no answered call of robot/describe"):
        through(rewritten(RECORDING, tmp_path / "undescribed.mcap", forget))
    with pytest.raises(ConfigError, match=r"choose one of: .*controller"):
        compare(RECORDING, ThroughOptions(service="console"))
    nothing = rewritten(
        RECORDING, tmp_path / "nothing.mcap", lambda one: None if one.topic else one.message
    )
    report = through(nothing)
    assert report.status == 1
    assert "NOTHING could be compared" in report.lines
