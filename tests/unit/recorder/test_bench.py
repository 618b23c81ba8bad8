"""The load of `w2c bench recording` is what it says, and so is what is made of its figures."""

from pathlib import Path

import numpy as np
import pytest

from w2c.bus import decode_envelope
from w2c_evaluation.recording.commands import over_budget
from w2c_evaluation.results import row
from w2c_recorder.bench.load import SENT_SUFFIX, run
from w2c_recorder.bench.measure import _seek_ms
from w2c_recorder.bench.traffic import EVERY, STATE_HZ, Traffic
from w2c_recorder.reading import Recording


def test_traffic_has_its_rate_and_numbers_without_gaps() -> None:
    ticks = 2 * EVERY
    messages = list(Traffic(15e6).messages(ticks / STATE_HZ))

    assert len(messages) == 2 * ticks + 2
    size = sum(len(raw.payload) for raw in messages)
    assert size == pytest.approx(15e6 * ticks / STATE_HZ, rel=0.02)
    for name, count in (("state/robot/joints", ticks), ("obs/camera/rgbd", 2)):
        numbers = [
            decode_envelope(raw.payload).sequence for raw in messages if raw.key.endswith(name)
        ]
        assert numbers == list(range(count))


def test_a_load_is_recorded_whole_and_counted(tmp_path: Path) -> None:
    path = tmp_path / "load.mcap"
    found = run(path, 2e6, 0.2)

    recorded = list(Recording(path).messages(decode=False))
    assert found["lost"] == 0
    assert sum(len(one.payload) for one in recorded) == found["sent_bytes"]
    tally = path.with_suffix(SENT_SUFFIX).read_bytes()
    assert int.from_bytes(tally, "big") == found["sent_bytes"]
    assert found["file_bytes"] == path.stat().st_size
    assert _seek_ms(path, np.random.default_rng(0), span_s=0.1) > 0.0


def test_a_loss_is_over_budget() -> None:
    rows = [
        row("15 MB/s", "lost", [0.0], "messages"),
        row("70 MB/s", "lost", [3.0], "messages"),
        row("kill -9", "worst_lost_time", [1.5], "s"),
        row("kill -9", "lost_time", [0.4, 1.5], "s"),
    ]

    assert [line.partition(",")[0] for line in over_budget(rows)] == [
        "70 MB/s: 3 messages lost",
        "kill -9: 1.50 s lost",
    ]
