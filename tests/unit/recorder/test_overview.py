"""The overview counts what is there, and says what is not."""

from pathlib import Path

from support.recordings import MARK_KEY, raw_mark, write_recording
from w2c.bus import RawReceived
from w2c_recorder.overview import overview_of
from w2c_recorder.reading import Recording
from w2c_recorder.recovery import recover

SECOND = 10**9


def test_counts_rates_gaps_and_losses(tmp_path: Path) -> None:
    arrivals = [0.0, 0.5, 1.0, 2.0]
    numbers = [0, 1, 2, 5]
    marks = [
        raw_mark("x", number, received_ns=SECOND + int(arrival * SECOND))
        for number, arrival in zip(numbers, arrivals, strict=True)
    ]
    write_recording(tmp_path / "a.mcap", marks)

    overview = overview_of(Recording(tmp_path / "a.mcap"))

    (channel,) = overview.channels
    assert (channel.key, channel.message, channel.count) == (MARK_KEY, "MarkRequest", 4)
    assert channel.rate_hz == 1.5
    assert channel.longest_gap_ns == SECOND
    assert channel.lost == 2
    assert (overview.start_ns, overview.duration_s) == (SECOND, 2.0)
    assert (overview.messages, overview.complete, overview.damage) == (4, True, "")
    assert overview.session["robot"] == "test"


def test_a_single_message_has_no_rate(tmp_path: Path) -> None:
    write_recording(tmp_path / "a.mcap", [raw_mark("x")])

    assert overview_of(Recording(tmp_path / "a.mcap")).channels[0].rate_hz == 0.0


def test_an_empty_recording_has_an_overview(tmp_path: Path) -> None:
    write_recording(tmp_path / "a.mcap", [])
    overview = overview_of(Recording(tmp_path / "a.mcap"))

    assert (overview.channels, overview.duration_s, overview.messages) == ([], 0.0, 0)


def test_malformed_and_unknown_messages_are_counted(tmp_path: Path) -> None:
    write_recording(
        tmp_path / "a.mcap",
        [RawReceived(MARK_KEY, b"\xc1", 1), RawReceived("w2c/v9/x", b"\xc1", 2)],
    )
    marks, unknown = overview_of(Recording(tmp_path / "a.mcap")).channels

    assert (marks.malformed, marks.message) == (1, "MarkRequest")
    assert (unknown.malformed, unknown.message) == (1, "")


def test_an_unclosed_file_says_so_and_a_recovered_one_too(tmp_path: Path) -> None:
    path = tmp_path / "a.mcap"
    write_recording(path, [raw_mark("x")], close=False)
    before = overview_of(Recording(path))
    recover(path)
    after = overview_of(Recording(path))

    assert not before.complete
    assert before.damage.startswith("not closed")
    assert (after.complete, after.damage) == (True, "")
    assert "ends in the middle" in after.recovered
