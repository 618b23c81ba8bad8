"""The story of a recording for someone who was not there: words, calls, goals, warnings."""

from collections.abc import Callable, Iterator
from dataclasses import dataclass
from typing import Any

from w2c import messages as m
from w2c import topics
from w2c_recorder.calls import call_of, describe_call, point_text
from w2c_recorder.liveliness import Liveliness, is_liveliness_key
from w2c_recorder.reading import Recorded, Recording, topic_of

ROWS: tuple[topics.Topic[Any], ...] = (
    topics.TURN,
    topics.ADVICE,
    topics.GOAL_EVENT,
    topics.SAFETY_EVENT,
    topics.CONTROLLER_STATUS,
    topics.TRACE,
    topics.LOG,
    topics.HEALTH,
    topics.RECORDER_STATUS,
    topics.MARK,
)
LOUD_LEVELS = ("warning", "error", "critical")


@dataclass(frozen=True)
class Entry:
    """One line of the story."""

    seconds: float
    """Since the first message of the recording, by the recorder's clock [s]."""
    kind: str
    """words, answer, advice, call, goal, phase, warning, process, mark or recording"""
    actor: str
    """Who did or said it."""
    text: str
    target: m.Target | None = None
    """Of an answer, with its point and the stamp of the picture that it is meant in"""


@dataclass(frozen=True)
class _Line:
    kind: str
    actor: str
    text: str
    target: m.Target | None = None


Lines = Iterator[_Line]


class _Teller:
    """Turns messages into lines. Remembers what it said last, to tell changes only."""

    def __init__(self) -> None:
        self._controller_phase = ""
        self._process_phase: dict[str, str] = {}
        self._alive: dict[str, bool] = {}
        self._recorder_error = ""
        self._recorder_lost: dict[str, int] = {}
        self._advice: tuple[str, list[str]] = ("", [])
        self._unknown: set[str] = set()
        self._tell: dict[type[m.Message], Callable[[Any, str], Lines]] = {
            m.Turn: self._turn,
            m.Advice: self._advise,
            m.GoalEvent: self._goal,
            m.SafetyEvent: self._safety,
            m.ControllerStatus: self._controller,
            m.LogRecord: self._log,
            m.Health: self._health,
            m.RecorderStatus: self._recorder,
            m.MarkRequest: self._mark,
            Liveliness: self._liveliness,
        }

    def lines(self, recorded: Recorded) -> Lines:
        """Yield what is worth telling of a message."""
        message, envelope = recorded.message, recorded.envelope
        if message is None or envelope is None:
            yield _Line(
                "recording",
                "recording",
                f"a message of {recorded.key} cannot be read: {recorded.problem}",
            )
            return
        if recorded.problem and recorded.key not in self._unknown:
            self._unknown.add(recorded.key)
            yield _Line("recording", "recording", f"{recorded.key}: {recorded.problem}")
        if isinstance(message, m.CallTrace):
            yield self._call(recorded, message)
        else:
            yield from self._tell[type(message)](message, envelope.sender)

    def _turn(self, turn: m.Turn, sender: str) -> Lines:
        if turn.text:
            yield _Line("words", "operator", f'"{turn.text}"')
        where = ""
        if turn.target is not None:
            where = f" at ({turn.target.u:.0f}, {turn.target.v:.0f})"
            if turn.target.point is not None:
                where += f" = {point_text(turn.target.point)}"
        verdict = "" if turn.ok else ", nothing changed"
        yield _Line(
            "answer",
            sender,
            f"{turn.module}{where}, {turn.seconds:.2f} s{verdict}: {turn.reply}",
            turn.target,
        )

    def _advise(self, advice: m.Advice, sender: str) -> Lines:
        """Tell what speaks against a target, once: advice is repeated, and grows."""
        texts = [remark.text for remark in advice.remarks if remark.level != "fine"]
        told = self._advice[1] if self._advice[0] == advice.target_id else []
        self._advice = (advice.target_id, told + [text for text in texts if text not in told])
        for text in texts:
            if text not in told:
                yield _Line("advice", sender, text)

    def _goal(self, event: m.GoalEvent, sender: str) -> Lines:
        distance = f", {event.distance * 100:.1f} cm left" if event.distance >= 0 else ""
        reason = f": {event.reason}" if event.reason else ""
        text = f"{event.end_effector} {event.task} {event.state}{distance}{reason}"
        yield _Line("goal", sender, text)

    def _safety(self, event: m.SafetyEvent, sender: str) -> Lines:
        found = f"{event.value:g} {event.unit}, limit {event.limit:g} {event.unit}"
        if event.state == "ends":
            yield _Line("warning", sender, f"{event.cause} {event.subject} is over: {event.text}")
        else:
            text = f"{event.cause} {event.subject} ({found}), {event.answer}: {event.text}"
            yield _Line("warning", sender, text)

    def _controller(self, status: m.ControllerStatus, sender: str) -> Lines:
        if status.phase != self._controller_phase:
            self._controller_phase = status.phase
            text = f"{status.phase}: {status.message}" if status.message else status.phase
            yield _Line("phase", sender, text)

    def _call(self, recorded: Recorded, trace: m.CallTrace) -> _Line:
        call = call_of(recorded, trace)
        if call.method == "stop" and call.service in ("robot", "controller"):
            answer = f", {call.reply.mode}" if isinstance(call.reply, m.StopReply) else ""
            return _Line("warning", call.caller, f"STOP to {call.service}: {call.outcome}{answer}")
        kind = "call" if call.outcome == "ok" else "warning"
        return _Line(kind, call.caller, describe_call(call))

    def _log(self, record: m.LogRecord, sender: str) -> Lines:
        if record.level.lower() in LOUD_LEVELS:
            yield _Line("warning", sender, f"{record.level.lower()}: {record.text}")

    def _health(self, health: m.Health, _sender: str) -> Lines:
        name = f"{health.service}/{health.instance}"
        if health.phase != self._process_phase.get(name, ""):
            self._process_phase[name] = health.phase
            text = f"{health.phase}: {health.detail}" if health.detail else health.phase
            yield _Line("process", name, text)

    def _recorder(self, status: m.RecorderStatus, sender: str) -> Lines:
        if status.error != self._recorder_error:
            self._recorder_error = status.error
            if status.error:
                yield _Line("warning", sender, f"error: {status.error}")
        for key, count in sorted(status.lost.items()):
            before = self._recorder_lost.get(key, 0)
            if count > before:
                yield _Line("warning", sender, f"lost {count - before} of {key}")
        self._recorder_lost = status.lost

    def _mark(self, mark: m.MarkRequest, _sender: str) -> Lines:
        yield _Line("mark", "mark", mark.text)

    def _liveliness(self, change: Liveliness, _sender: str) -> Lines:
        name = f"{change.service}/{change.instance}"
        if self._alive.get(name) != change.alive:  # each file of a series tells who is there
            self._alive[name] = change.alive
            yield _Line("process", name, "appeared" if change.alive else "GONE")


def is_told(key: str) -> bool:
    """Tell whether messages of a key are part of the story."""
    return is_liveliness_key(key) or topic_of(key) in ROWS


def timeline_of(recording: Recording) -> Iterator[Entry]:
    """Yield the story in the order in which it reached the recorder. Raises RecordingError."""
    teller = _Teller()
    for recorded in recording.messages(is_told):
        # Who is there is written before what is queued: that may have arrived a moment earlier.
        seconds = max(0, recorded.log_time_ns - recording.start_ns) * 1e-9
        for line in teller.lines(recorded):
            yield Entry(
                seconds, line.kind, _printable(line.actor), _printable(line.text), line.target
            )


def _printable(text: str) -> str:
    """Return one line without control characters: much of the text comes from models and users."""
    return "".join(letter if letter.isprintable() else " " for letter in text)
