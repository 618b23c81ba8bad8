"""A session that is killed leaves no process, and a recording that can be read."""

import sys
import time
from contextlib import suppress
from pathlib import Path

import psutil
import pytest

from w2c.errors import ProcessError
from w2c_evaluation.recording.killed import Killed, kill_session, longest_silence_s

RECORDER = """
import os, sys, time
from pathlib import Path
from mcap.writer import Writer
directory = Path(sys.argv[1])
(directory / "pid").write_text(str(os.getpid()))
with (directory / "session.mcap").open("wb", buffering=0) as file:
    writer = Writer(file)
    writer.start()
    channel = writer.register_channel("w2c/v1/test/x", "msgpack", 0)
    while True:
        writer.add_message(channel, time.time_ns(), b"", time.time_ns())
        writer.flush()
        time.sleep(0.01)
"""
LAUNCHER = "import subprocess, sys; subprocess.run([sys.executable, '-c', *sys.argv[1:]])"


def test_every_process_is_killed_and_what_was_recorded_is_read(tmp_path: Path) -> None:
    command = [sys.executable, "-c", LAUNCHER, RECORDER, str(tmp_path)]

    began = time.monotonic()
    found = kill_session(command, tmp_path, after_s=0.1)

    assert found.messages > 0
    # Nothing, where a message came between the look at the clock and the death of the recorder.
    assert 0.0 <= found.lost_s < time.monotonic() - began
    with suppress(psutil.NoSuchProcess):
        recorder = psutil.Process(int((tmp_path / "pid").read_text()))
        assert recorder.status() == psutil.STATUS_ZOMBIE  # dead; nobody has waited for it yet


def test_what_was_not_written_yet_is_lost_since_the_recording_began(tmp_path: Path) -> None:
    only_the_header = RECORDER.replace(
        "while True:", "writer.flush(); time.sleep(60)\n    while True:"
    )
    command = [sys.executable, "-c", only_the_header, str(tmp_path)]

    found = kill_session(command, tmp_path, after_s=0.2)

    assert found.messages == 0
    assert found.lost_s >= 0.2
    assert found.surely_lost_s == found.lost_s


def test_a_silence_like_those_before_is_no_loss() -> None:
    second = 10**9
    reports = [0, second, 2 * second, 3 * second]
    stream = [*reports, *range(9 * second, 10 * second, second // 100)]

    assert longest_silence_s(reports) == pytest.approx(1.0)
    assert longest_silence_s(stream) == pytest.approx(0.01)
    assert longest_silence_s(reports[:1]) == 0.0
    assert Killed(4, lost_s=1.1, silence_s=1.0).surely_lost_s == pytest.approx(0.1)
    assert Killed(4, lost_s=0.4, silence_s=1.0).surely_lost_s == 0.0


def test_a_session_that_ends_by_itself_is_none_that_was_killed(tmp_path: Path) -> None:
    with pytest.raises(ProcessError, match="ended by itself, with status 3"):
        kill_session([sys.executable, "-c", "raise SystemExit(3)"], tmp_path, after_s=0.0)


def test_a_session_that_records_nothing_is_killed_too(tmp_path: Path) -> None:
    command = [sys.executable, "-c", "import time; time.sleep(60)"]

    with pytest.raises(ProcessError, match="nothing was recorded"):
        kill_session(command, tmp_path, after_s=0.0, patience_s=0.1)

    assert "time.sleep(60)" not in str([one.cmdline() for one in psutil.Process().children()])
