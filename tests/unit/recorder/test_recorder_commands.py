"""The verbs print what they find and exit as the others do."""

import json
import subprocess
import sys
from collections.abc import Iterator
from pathlib import Path

import pytest
from mcap.writer import Writer

from support.recordings import MARK_KEY, raw_mark, raw_message, write_recording
from support.sessions import conversation
from w2c import topics
from w2c.errors import ConfigError, RecordingError
from w2c.messages import MarkRequest, RecorderStatus
from w2c.through import Skipped
from w2c_recorder.commands import describe_status, record, recording
from w2c_recorder.mcap_file import McapFile
from w2c_recorder.replay.commands import replay
from w2c_recorder.through.commands import compare
from w2c_recorder.through.options import ThroughOptions
from w2c_recorder.through.session import RecordedSession


@pytest.fixture
def file(tmp_path: Path) -> Path:
    path = tmp_path / "session.mcap"
    write_recording(path, [raw_mark("it wobbled", 0, 10**9), raw_mark("again", 3, 2 * 10**9)])
    return path


def test_info_prints_channels_and_losses(file: Path, capsys: pytest.CaptureFixture[str]) -> None:
    assert recording(["info", str(file)]) == 0

    printed = capsys.readouterr().out
    (row,) = [line for line in printed.splitlines() if line.startswith(MARK_KEY)]
    assert row.split()[1:] == ["MarkRequest", "2", "1.0", "1000.0", "2"]
    assert "1.0 s" in printed


def test_info_writes_the_same_as_json(file: Path, tmp_path: Path) -> None:
    recording(["info", str(file), "--json", str(tmp_path / "info.json")])
    values = json.loads((tmp_path / "info.json").read_text())

    assert values["messages"] == 2
    assert values["complete"] is True
    assert values["channels"][0]["lost"] == 2
    assert values["channels"][0]["rate_hz"] == 1.0


def test_timeline_prints_the_story(
    file: Path, tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    assert recording(["timeline", str(file), "--json", str(tmp_path / "story.json")]) == 0

    lines = capsys.readouterr().out.splitlines()
    assert [line.split(maxsplit=2) for line in lines] == [
        ["0:00.000", "mark", "it wobbled"],
        ["0:01.000", "mark", "again"],
    ]
    entries = json.loads((tmp_path / "story.json").read_text())["entries"]
    assert entries[1] == {"seconds": 1.0, "kind": "mark", "actor": "mark", "text": "again"}


def test_an_unclosed_file_is_shown_and_called_so(
    tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    path = tmp_path / "session.mcap"
    write_recording(path, [raw_mark("a")], close=False)

    assert recording(["info", str(path)]) == 0
    assert "DAMAGED: not closed" in capsys.readouterr().out
    assert recording(["timeline", str(path)]) == 0
    assert "was not closed" in capsys.readouterr().out


def test_info_names_clocks_that_are_not_the_recorders(
    tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    path = tmp_path / "session.mcap"
    ages = {"camera": -int(0.8e9), "llm": int(0.001e9), "robot": int(2e9)}
    write_recording(
        path,
        [
            raw_message(MarkRequest(text="x"), MARK_KEY, sender=sender, boot_id=sender,
                        clock_ns=10**12, received_ns=10**12 + age)
            for sender, age in ages.items()
        ],
    )  # fmt: skip
    recording(["info", str(path)])

    lines = [line for line in capsys.readouterr().out.splitlines() if line.startswith("CLOCK")]
    assert lines == [
        "CLOCK: that of camera is at least 0.800 s ahead",
        "CLOCK: that of robot is behind, or its messages take 2.000 s and more",
    ]


def test_info_names_the_models(tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    path = tmp_path / "session.mcap"
    file = McapFile(path, {"robot": "test"})
    file.describe("process llm/0", {"configuration": "{}", "model": "a.gguf", "model_sha256": "ab"})
    file.describe("process robot/0", {"configuration": "{}"})
    file.write(raw_mark("a"), 1)
    file.close()
    recording(["info", str(path)])

    assert "llm/0                a.gguf, SHA-256 ab" in capsys.readouterr().out


ACTIONS = [
    ["info"],
    ["timeline"],
    ["check"],
    ["frame", "--at", "0"],
    ["why", "--at", "0"],
    ["export", "--to", "csv", "--channel", "state/robot/joints"],
    ["export", "--to", "dataset"],
    ["export", "--to", "mp4"],
]


@pytest.mark.parametrize("action", ACTIONS, ids=" ".join)
@pytest.mark.parametrize(
    ("content", "problem"),
    [
        (b"these are notes and no recording", "not an MCAP file"),
        (b"", "is empty: nothing was recorded"),
        (None, "no recording at"),
    ],
    ids=["foreign", "empty", "missing"],
)
def test_a_file_that_holds_nothing_is_an_error(
    tmp_path: Path, action: list[str], content: bytes | None, problem: str
) -> None:
    path = tmp_path / "notes.mcap"
    if content is not None:
        path.write_bytes(content)

    with pytest.raises(RecordingError, match=problem):
        recording([*action, str(path)])


@pytest.mark.parametrize("action", ["frame", "why"])
def test_an_instant_of_a_file_without_messages_is_an_error(tmp_path: Path, action: str) -> None:
    path = tmp_path / "session.mcap"
    path.write_bytes(b"\x89MCAP0\r\n")

    with pytest.raises(RecordingError, match="holds no message: ends in the middle"):
        recording([action, "--at", "0", str(path)])


def test_the_help_shows_the_flags_of_every_action(capsys: pytest.CaptureFixture[str]) -> None:
    with pytest.raises(SystemExit):
        recording(["--help"])
    printed = capsys.readouterr().out

    assert all(flag in printed for flag in ("--json", "--html", "--budget", "--at", "--out"))


def test_a_json_that_cannot_be_written_is_a_usage_error(file: Path) -> None:
    with pytest.raises(ConfigError, match="cannot be written"):
        recording(["info", str(file), "--json", str(file / "info.json")])


@pytest.mark.parametrize("arguments", [[], ["replay", "x"], ["info"]])
def test_recording_without_a_known_action_is_a_usage_error(arguments: list[str]) -> None:
    with pytest.raises(SystemExit) as exit_info:
        recording(arguments)
    assert exit_info.value.code == 2


@pytest.mark.parametrize("arguments", [[], ["pause"], ["mark"], ["mark", "--robot", "x"]])
def test_record_without_a_known_action_says_what_there_is(arguments: list[str]) -> None:
    with pytest.raises(ConfigError, match="choose one of: start"):
        record(arguments)


def test_a_mark_has_a_bounded_text() -> None:
    with pytest.raises(ConfigError, match="1 to 1000 characters, this one 1001"):
        record(["mark", "x" * 1001])


def test_verbs_load_without_the_recorders_own_dependencies() -> None:
    """Where the extra is not installed, the verb says so instead of failing at import."""
    program = (
        "import sys, w2c_recorder.__main__, w2c_recorder.commands, w2c_recorder.replay.commands; "
        "sys.exit(bool({'mcap', 'lz4', 'zstandard'} & set(sys.modules)))"
    )
    assert subprocess.run([sys.executable, "-c", program], check=False).returncode == 0


def test_the_status_tells_losses_and_why_it_stopped() -> None:
    status = RecorderStatus(
        stamp_ns=0, recording=False, path="runs/a.mcap", messages=3, bytes=2_000_000,
        lost={"k": 4}, error="disk full",
    )  # fmt: skip

    assert describe_status(status).splitlines() == [
        "not recording; last file: runs/a.mcap",
        "3 messages, 2.0 MB",
        "lost 4 of k",
        "stopped by itself: disk full",
    ]


@pytest.mark.parametrize("action", ACTIONS, ids=" ".join)
def test_of_a_half_written_session_what_is_there_is_read(
    tmp_path: Path,
    monkeypatch: pytest.MonkeyPatch,
    capsys: pytest.CaptureFixture[str],
    action: list[str],
) -> None:
    monkeypatch.chdir(tmp_path)
    path = conversation().write(tmp_path / "a.mcap", close=False)
    path.write_bytes(path.read_bytes() + b"\x05\xff")
    words = [word if word != "0" else "3.35" for word in action]

    recording([*words, str(path)])

    printed = capsys.readouterr().out
    assert printed
    assert action[0] == "frame" or "not closed" in printed


@pytest.mark.parametrize(
    "words",
    [
        ["info", "--json"],
        ["timeline", "--html"],
        ["export", "--to", "csv", "--channel", "event/recorder/mark", "--out"],
    ],
    ids=" ".join,
)
def test_a_recording_is_not_written_over_by_what_is_made_of_it(
    file: Path, tmp_path: Path, words: list[str]
) -> None:
    before = file.read_bytes()
    (tmp_path / "link").symlink_to(file)

    with pytest.raises(ConfigError, match="is the recording itself"):
        recording([words[0], str(file), *words[1:], str(tmp_path / "link")])

    assert file.read_bytes() == before


def test_a_replay_through_a_service_leaves_its_recording(file: Path) -> None:
    with pytest.raises(ConfigError, match="is the recording itself"):
        replay([str(file), "--through", "controller", "--json", str(file)])


@pytest.fixture
def foreign(tmp_path: Path) -> Path:
    """A recording of another program, with messages of its own encoding."""
    path = tmp_path / "foreign.mcap"
    with path.open("wb") as stream:
        writer = Writer(stream)
        writer.start(profile="ros2", library="another")
        channel = writer.register_channel(topic="/tf", message_encoding="cdr", schema_id=0)
        for number in range(3):
            writer.add_message(channel, log_time=number + 10**18, data=b"x", publish_time=0)
        writer.finish()  # type: ignore[no-untyped-call]
    return path


def test_of_another_programs_recording_info_tells_what_is_in_it(
    foreign: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    assert recording(["info", str(foreign)]) == 0

    printed = capsys.readouterr().out
    assert "UTC, 0.0 s" in printed
    assert "/tf  3 in another encoding" in printed


def test_another_programs_recording_is_called_so(
    foreign: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    recording(["timeline", str(foreign)])

    assert "nothing to tell: another program wrote it; it has /tf" in capsys.readouterr().out
    with pytest.raises(RecordingError, match="no message: another program wrote it; it has /tf"):
        recording(["why", "--at", "0", str(foreign)])


@pytest.mark.parametrize("close", [True, False], ids=["whole", "cut off"])
def test_a_replay_through_a_service_says_where_the_recording_ends(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch, close: bool
) -> None:
    path = tmp_path / "a.mcap"
    write_recording(path, [raw_mark("a")], close=close)

    def read_all(session: RecordedSession, _tolerance: float | None) -> Iterator[Skipped]:
        yield from (Skipped("marks", one.seconds, "") for one in session.heard(topics.MARK))

    monkeypatch.setattr("w2c_recorder.through.commands.through", lambda _service: read_all)
    lines = compare(path, ThroughOptions(service="controller")).lines

    assert ("not closed" in lines[-1]) is not close
