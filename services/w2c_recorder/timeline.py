"""The story of a recording for someone who was not there: words, goals, warnings."""

from collections.abc import Callable, Iterator
from dataclasses import dataclass
from typing import Any

from w2c import messages as m
from w2c import topics
from w2c_recorder.liveliness import Liveliness, is_liveliness_key
from w2c_recorder.reading import Recorded, Recording, decode_call, topic_of

ROWS: tuple[topics.Topic[Any], ...] = (
    topics.TURN,
    topics.GOAL_EVENT,
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
    actor: str
    """Who did or said it."""
    text: str


class _Teller:
    """Turns messages into lines. Remembers what it said last, to tell changes only."""

    def __init__(self) -> None:
        self._controller_phase = ""
        self._process_phase: dict[str, str] = {}
        self._recorder_error = ""
        self._tell: dict[type[m.Message], Callable[[Any, str], Iterator[tuple[str, str]]]] = {
            m.Turn: self._turn,
            m.GoalEvent: self._goal,
            m.ControllerStatus: self._controller,
            m.CallTrace: self._call,
            m.LogRecord: self._log,
            m.Health: self._health,
            m.RecorderStatus: self._recorder,
            m.MarkRequest: self._mark,
            Liveliness: self._liveliness,
        }

    def lines(self, message: m.Message, sender: str) -> Iterator[tuple[str, str]]:
        """Yield (actor, text) of what is worth telling of a message."""
        yield from self._tell[type(message)](message, sender)

    def _turn(self, turn: m.Turn, sender: str) -> Iterator[tuple[str, str]]:
        yield "operator", f'"{turn.text}"'
        where = f" at ({turn.target.u:.0f}, {turn.target.v:.0f})" if turn.target else ""
        verdict = "" if turn.ok else ", nothing changed"
        yield sender, f"{turn.module}{where}, {turn.seconds:.2f} s{verdict}: {turn.reply}"

    def _goal(self, event: m.GoalEvent, sender: str) -> Iterator[tuple[str, str]]:
        distance = f", {event.distance * 100:.1f} cm left" if event.distance >= 0 else ""
        reason = f": {event.reason}" if event.reason else ""
        yield sender, f"{event.end_effector} {event.task} {event.state}{distance}{reason}"

    def _controller(self, status: m.ControllerStatus, sender: str) -> Iterator[tuple[str, str]]:
        if status.phase != self._controller_phase:
            self._controller_phase = status.phase
            yield sender, f"{status.phase}: {status.message}" if status.message else status.phase

    def _call(self, trace: m.CallTrace, sender: str) -> Iterator[tuple[str, str]]:
        name = f"{trace.service}/{trace.method}"
        if trace.method == "stop" and trace.service in ("robot", "controller"):
            reply = decode_call(trace)[1]
            answer = f", {reply.mode}" if isinstance(reply, m.StopReply) else ""
            yield sender, f"STOP to {trace.service}: {trace.outcome}{answer}"
        elif trace.outcome != "ok":
            yield (
                sender,
                f"call {name} failed after {trace.duration_ms:.0f} ms: "
                f"{trace.outcome}: {trace.error}",
            )

    def _log(self, record: m.LogRecord, sender: str) -> Iterator[tuple[str, str]]:
        if record.level.lower() in LOUD_LEVELS:
            yield sender, f"{record.level.lower()}: {record.text}"

    def _health(self, health: m.Health, _sender: str) -> Iterator[tuple[str, str]]:
        name = f"{health.service}/{health.instance}"
        if health.phase != self._process_phase.get(name, ""):
            self._process_phase[name] = health.phase
            yield name, f"{health.phase}: {health.detail}" if health.detail else health.phase

    def _recorder(self, status: m.RecorderStatus, sender: str) -> Iterator[tuple[str, str]]:
        if status.error != self._recorder_error:
            self._recorder_error = status.error
            if status.error:
                yield sender, f"error: {status.error}"

    def _mark(self, mark: m.MarkRequest, _sender: str) -> Iterator[tuple[str, str]]:
        yield "mark", mark.text

    def _liveliness(self, change: Liveliness, _sender: str) -> Iterator[tuple[str, str]]:
        yield f"{change.service}/{change.instance}", "appeared" if change.alive else "GONE"


def is_told(key: str) -> bool:
    """Tell whether messages of a key are part of the story."""
    return is_liveliness_key(key) or topic_of(key) in ROWS


def timeline_of(recording: Recording) -> Iterator[Entry]:
    """Yield the story in the order in which it reached the recorder. Raises RecordingError."""
    teller = _Teller()
    for recorded in recording.messages(is_told):
        seconds = (recorded.log_time_ns - recording.start_ns) * 1e-9
        for actor, text in _lines(teller, recorded):
            yield Entry(seconds, _printable(actor), _printable(text))


def _lines(teller: _Teller, recorded: Recorded) -> Iterator[tuple[str, str]]:
    if recorded.message is None or recorded.envelope is None:
        yield "recording", f"a message of {recorded.key} cannot be read: {recorded.problem}"
    else:
        yield from teller.lines(recorded.message, recorded.envelope.sender)


def _printable(text: str) -> str:
    """Return one line without control characters: much of the text comes from models and users."""
    return "".join(letter if letter.isprintable() else " " for letter in text)
