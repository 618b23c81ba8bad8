"""`w2c demo` in lock step on one layout, then its recording: the system test."""

import json
import subprocess
import sys
from collections import Counter
from pathlib import Path

import pytest

from w2c import topics
from w2c.messages import CallTrace, GoalEvent, LogRecord, Turn
from w2c_evaluation.demo.scenario import SCENARIO_A
from w2c_recorder.reading import Recording

pytestmark = pytest.mark.slow

SUMMARY_FIELDS = {
    "turns", "end_effector_error_mm", "hand_force_N", "fell", "lateness_us", "recording", "problem",
}  # fmt: skip


@pytest.fixture(scope="module")
def run(tmp_path_factory: pytest.TempPathFactory) -> Path:
    """Play the demo once; its directory."""
    directory = tmp_path_factory.mktemp("demo")
    command = [sys.executable, "-m", "w2c.cli", "demo", "--lock-step", "--seed", "0"]
    answer = subprocess.run(
        [*command, "--run-directory", str(directory)], capture_output=True, text=True, check=False
    )
    assert answer.returncode == 0, f"{answer.stdout}\n{answer.stderr}"
    return directory


def test_the_summary_tells_the_story_in_the_agreed_shape(run: Path) -> None:
    summary = json.loads((run / "summary.json").read_text())
    assert set(summary) == SUMMARY_FIELDS
    assert [turn["text"] for turn in summary["turns"]] == [line.text for line in SCENARIO_A]
    assert [turn["module"] for turn in summary["turns"]] == [
        "prediction.absolute", "correction", "confirmation", "prediction.absolute", "confirmation",
    ]  # fmt: skip
    assert not summary["fell"]
    assert summary["hand_force_N"] > 10.0
    assert summary["end_effector_error_mm"] <= 30.0
    assert summary["problem"] == ""


def test_the_pictures_are_there(run: Path) -> None:
    for name in ("leaning.jpg", "reaching.jpg"):
        assert (run / name).stat().st_size > 20_000
    assert len(list(run.glob("target-*.jpg"))) == 3


def test_the_recording_holds_the_whole_session(run: Path) -> None:
    """Every stream is there, no state or command is missing, no error was logged."""
    recording = Recording(run / "session.mcap")
    counts: Counter[str] = Counter()
    ticks: dict[str, list[int]] = {"state": [], "cmd": []}
    turns, goals, calls, errors = [], [], set(), []
    for recorded in recording.messages():
        if recorded.topic is None:
            continue
        counts[f"{recorded.topic.kind}/{recorded.topic.name}"] += 1
        message = recorded.message
        if recorded.topic in (topics.ROBOT_STATE, topics.JOINT_COMMAND):
            ticks[recorded.topic.kind].append(message.tick)  # type: ignore[union-attr]
        elif isinstance(message, Turn) and message.text:  # the others tell how a goal ended
            turns.append(message.text)
        elif isinstance(message, GoalEvent):
            goals.append(message.state)
        elif isinstance(message, CallTrace):
            calls.add(f"{message.service}/{message.method}")
        elif isinstance(message, LogRecord) and message.level == "error":
            errors.append(message.text)
    assert turns == [line.text for line in SCENARIO_A]
    assert goals.count("loaded") == 1
    assert goals.count("reached") == 1
    assert {"llm/choose", "llm/complete", "grounding/ground", "perception/lift"} <= calls
    assert "controller/place" in calls
    assert errors == []
    for kind in ("state", "cmd"):
        unique = sorted(set(ticks[kind]))
        assert len(unique) == unique[-1] - unique[0] + 1, f"gaps in {kind}"
    for name in ("obs/rgbd", "state/view", "state/status", "health/status", "truth/physics"):
        assert counts[name] > 5, name
