"""Someone who was not there reads what happened."""

from pathlib import Path

import numpy as np
import pytest

from support.recordings import raw_mark, raw_message, write_recording
from w2c import messages as m
from w2c import topics
from w2c.bus import RawReceived
from w2c_recorder.liveliness import Liveliness, key_of
from w2c_recorder.reading import Recording
from w2c_recorder.timeline import timeline_of

SECOND = 10**9


def status(phase: str) -> m.ControllerStatus:
    return m.ControllerStatus(
        stamp_ns=0, tick=0, phase=phase, in_contact=(True, True, False, False),  # type: ignore[arg-type]
        desired_forces=np.zeros((4, 3)), end_effector_positions=np.zeros((4, 3)),
        loads=np.zeros(4), solver_failures=0, lateness_us={}, tick_us={},
    )  # fmt: skip


def turn(text: str, *, ok: bool = True) -> m.Turn:
    target = m.Target(
        target_id="t1",
        frame_stamp_ns=1,
        u=640.4,
        v=312.0,
        point=None,
        normal=None,
        state="proposed",
    )
    return m.Turn(
        stamp_ns=0, text=text, module="prediction.absolute", reply="There?", ok=ok,
        target=target if ok else None, seconds=0.41,
    )  # fmt: skip


def event(state: str, distance: float = -1.0, reason: str = "") -> m.GoalEvent:
    return m.GoalEvent(
        stamp_ns=0, goal_id="g1", end_effector="right_hand", task="contact", state=state,  # type: ignore[arg-type]
        distance=distance, reason=reason,
    )  # fmt: skip


def call(service: str, method: str, outcome: str, error: str = "") -> m.CallTrace:
    return m.CallTrace(
        service=service, method=method, instance="0", outcome=outcome, duration_ms=60_000.0,
        request=b"", reply=b"", error=error,
    )  # fmt: skip


def health(phase: str) -> m.Health:
    return m.Health(
        stamp_ns=0, service="llm", instance="0", phase=phase, detail="no model", pid=1,
        cpu_percent=0.0, memory_mb=0.0,
    )  # fmt: skip


def log_record(level: str, text: str) -> m.LogRecord:
    return m.LogRecord(stamp_ns=0, level=level, logger="w2c", text=text)


def story(path: Path, *messages: tuple[topics.Topic[m.Message], str, m.Message]) -> list[str]:
    """Record messages a second apart and return the lines told of them."""
    raw = [
        raw_message(
            message, row.key("test", sender), number, sender=sender, received_ns=number * SECOND + 1
        )
        for number, (row, sender, message) in enumerate(messages)
    ]
    write_recording(path, raw)
    return [f"{e.seconds:.0f} {e.actor}: {e.text}" for e in timeline_of(Recording(path))]


@pytest.fixture
def path(tmp_path: Path) -> Path:
    return tmp_path / "session.mcap"


def test_a_turn_is_two_lines(path: Path) -> None:
    assert story(path, (topics.TURN, "dialogue", turn("on the book"))) == [
        '0 operator: "on the book"',
        "0 dialogue: prediction.absolute at (640, 312), 0.41 s: There?",
    ]


def test_a_turn_that_changed_nothing_says_so(path: Path) -> None:
    lines = story(path, (topics.TURN, "dialogue", turn("on the moon", ok=False)))

    assert lines[1] == "0 dialogue: prediction.absolute, 0.41 s, nothing changed: There?"


def test_goals_tell_what_is_left_and_why(path: Path) -> None:
    lines = story(
        path,
        (topics.GOAL_EVENT, "controller", event("moving")),
        (topics.GOAL_EVENT, "controller", event("unreachable", 0.123, "balance")),
    )

    assert lines == [
        "0 controller: right_hand contact moving",
        "1 controller: right_hand contact unreachable, 12.3 cm left: balance",
    ]


def test_the_controller_tells_changes_of_phase_only(path: Path) -> None:
    phases = ["hold", "hold", "approach", "approach", "hold"]
    lines = story(
        path, *((topics.CONTROLLER_STATUS, "controller", status(phase)) for phase in phases)
    )

    assert lines == ["0 controller: hold", "2 controller: approach", "4 controller: hold"]


def test_calls_are_told_with_their_time_and_failed_ones_with_their_reason(path: Path) -> None:
    lines = story(
        path,
        (topics.TRACE, "dialogue", call("llm", "complete", "ok")),
        (topics.TRACE, "dialogue", call("grounding", "ground", "deadline", "too late")),
        (topics.TRACE, "console", call("robot", "stop", "ok")),
    )

    assert lines == [
        "0 dialogue: call llm/complete, 60000 ms",
        "1 dialogue: call grounding/ground failed after 60000 ms: deadline: too late",
        "2 console: STOP to robot: ok",
    ]


def test_warnings_are_told_and_chatter_is_not(path: Path) -> None:
    lines = story(
        path,
        (topics.LOG, "llm", log_record("info", "chatter")),
        (topics.LOG, "llm", log_record("WARNING", "slow")),
    )

    assert lines == ["1 llm: warning: slow"]


def test_a_process_tells_changes_of_its_health(path: Path) -> None:
    lines = story(path, *((topics.HEALTH, "llm", health(p)) for p in ("ready", "ready", "failed")))

    assert lines == ["0 llm/0: ready: no model", "2 llm/0: failed: no model"]


def test_safety_events_are_told_with_value_and_limit(path: Path) -> None:
    begins = m.SafetyEvent(
        stamp_ns=0, tick=1, cause="hand_overload", state="begins", subject="right_hand",
        value=210.0, limit=150.0, unit="N", answer="holds", resumes="after resume",
        text="look at the robot",
    )  # fmt: skip

    assert story(path, (topics.SAFETY_EVENT, "controller", begins)) == [
        "0 controller: hand_overload right_hand (210 N, limit 150 N), holds: look at the robot"
    ]


def test_advice_that_is_repeated_is_told_once(path: Path) -> None:
    def advice(*remarks: m.Remark) -> m.Advice:
        return m.Advice(
            stamp_ns=0, target_id="t1", frame_stamp_ns=1, remarks=list(remarks), seconds=0.1
        )

    fine = m.Remark(kind="veto", level="fine", text="no veto", source="grounding")
    slope = m.Remark(kind="surface", level="caution", text="it slopes", source="perception")
    far = m.Remark(kind="reach", level="caution", text="it is far", source="controller")
    told = [advice(fine, slope), advice(fine, slope), advice(slope, far)]
    lines = story(path, *((topics.ADVICE, "dialogue", one) for one in told))

    assert lines == ["0 dialogue: it slopes", "2 dialogue: it is far"]


def test_losses_are_told_when_they_happen(path: Path) -> None:
    def lost(count: int) -> m.RecorderStatus:
        return m.RecorderStatus(
            stamp_ns=0, recording=True, path="a", messages=1, bytes=1, lost={"k": count}
        )

    lines = story(path, *((topics.RECORDER_STATUS, "recorder", lost(n)) for n in (2, 2, 5)))

    assert lines == ["0 recorder: lost 2 of k", "2 recorder: lost 3 of k"]


def test_marks_and_liveliness_are_told(path: Path) -> None:
    gone = Liveliness(service="llm", instance="0", alive=False)
    write_recording(
        path, [raw_mark("it wobbled", 0, 1), raw_message(gone, key_of("test", gone), received_ns=1)]
    )

    assert [(e.actor, e.text) for e in timeline_of(Recording(path))] == [
        ("mark", "it wobbled"),
        ("llm/0", "GONE"),
    ]


def test_a_message_that_cannot_be_read_is_told(path: Path) -> None:
    write_recording(path, [RawReceived(topics.TURN.key("test"), b"\xc1", 1)])

    (entry,) = timeline_of(Recording(path))
    assert entry.actor == "recording"
    assert "w2c/v1/test/event/dialogue/turn cannot be read" in entry.text


def test_control_characters_do_not_reach_the_terminal(path: Path) -> None:
    lines = story(path, (topics.LOG, "llm", log_record("error", "a\x1b[2Jb\nc")))

    assert lines == ["0 llm: error: a [2Jb c"]


def test_time_counts_from_the_first_message_of_any_kind(path: Path) -> None:
    lines = story(
        path,
        (topics.LOG, "llm", log_record("info", "chatter")),
        (topics.TURN, "dialogue", turn("hello")),
    )

    assert lines[0].startswith("1 operator")


def test_what_arrived_before_the_first_message_was_written_is_at_its_beginning(path: Path) -> None:
    came = Liveliness(service="llm", instance="0", alive=True)
    first = raw_message(came, key_of("test", came), received_ns=SECOND)
    write_recording(path, [first, raw_mark("in the queue", 0, SECOND - 5_000_000)])

    assert [entry.seconds for entry in timeline_of(Recording(path))] == [0.0, 0.0]
