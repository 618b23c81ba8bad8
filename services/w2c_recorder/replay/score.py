"""What is to be sent, and when: one pass through a recording."""

from collections.abc import Iterable, Iterator
from dataclasses import dataclass, field, replace

from w2c import messages as m
from w2c import topics
from w2c.topics import Priority
from w2c_recorder.liveliness import Liveliness, is_liveliness_key
from w2c_recorder.reading import Recorded, Recording, topic_of
from w2c_recorder.replay.answers import ANSWERED, ANSWERED_NAME, NOBODY_ASKED, Answers
from w2c_recorder.replay.namespace import Namespace
from w2c_recorder.replay.selection import Selection

FOREVER_NS = 2**63
STANDING = frozenset(
    topic for topic in topics.TOPICS if topic.kind == "state" and not topic.rate_hz
)
"""States that are said when they change: who comes later has to be told"""
REPEATED = frozenset(
    topic for topic in topics.TOPICS if topic.kind in ("state", "obs", "health") and topic.rate_hz
)
"""What is said again and again: in a part that is played slowly, or of a camera that sends a
picture only when it is asked, the next one may be far"""
OF_THE_MOMENT = STANDING | REPEATED | {topics.TURN}
"""What shows how things stood at a time. The last exchange says where the conversation was"""


@dataclass(frozen=True)
class Due:
    """One thing to do at its time."""

    at_ns: int
    """Arrival at the recorder [ns since 1970]"""
    key: str
    """Where to send; "" = nothing is sent"""
    payload: bytes = b""
    priority: Priority = Priority.DATA
    process: tuple[str, str] | None = None
    """Service and instance whose presence changes"""
    present: bool = True
    is_answer: bool = False
    """True: nothing is sent; from then on calls of the key are answered with the payload, or
    refused where that is empty"""

    @property
    def size_bytes(self) -> int:
        """What it takes in memory, about [B]."""
        return len(self.payload)


@dataclass
class LeftOut:
    """What could not be played."""

    unreadable: dict[str, int] = field(default_factory=dict)
    """Key -> messages without an envelope of this version"""
    undescribed: bool = False
    """A start of the robot is played after which nobody asked what it is"""

    def lines(self) -> list[str]:
        """Return what people are told."""
        lines = [
            f"left out: {count} messages of {key}, which are none of this version"
            for key, count in sorted(self.unreadable.items())
        ]
        if self.undescribed:
            lines.append(f"{ANSWERED_NAME} was not answered all the time: {NOBODY_ASKED}")
        return lines


class Score:
    """A recording, read as what is to be done with it."""

    def __init__(
        self,
        recording: Recording,
        selection: Selection,
        namespace: Namespace,
        start_s: float = 0.0,
        end_s: float | None = None,
    ) -> None:
        """Prepare.

        Args:
            recording: what is played.
            selection: its keys.
            namespace: whose messages they become.
            start_s: time of the timeline [s].
            end_s: the same [s]; None = to the end.
        """
        self._recording = recording
        self._selection = selection
        self._namespace = namespace
        self._start_s, self._end_s = start_s, end_s
        self._answers = Answers(recording.path)
        self._answering = ""
        """Recorded boot id of the robot whose answer was given last"""
        self.left_out = LeftOut()

    def one_pass(self) -> Iterator[Due]:
        """Yield what is to be done, once through. Raises RecordingError."""
        recording, selection = self._recording, self._selection
        recording.read_metadata()
        first_ns = recording.start_ns + round(self._start_s * 1e9)
        end_ns = FOREVER_NS
        if self._end_s is not None:
            end_ns = recording.start_ns + round(self._end_s * 1e9)
        self._namespace.begin_pass()
        self.left_out = LeftOut()
        self._answering = ""

        def wanted(key: str) -> bool:
            return selection(key) or is_liveliness_key(key)

        begun = not self._start_s
        for recorded in recording.messages_between(first_ns, end_ns, wanted):
            if not begun and selection(recorded.key):
                begun = True
                yield from self._standing(first_ns)
            yield from self._due(recorded)

    def _standing(self, first_ns: int) -> Iterator[Due]:
        """Yield how things stood at a time: who was there, and the newest of what they said."""

        def wanted(key: str) -> bool:
            return is_liveliness_key(key) or (
                topic_of(key) in OF_THE_MOMENT and self._selection(key)
            )

        found = self._recording.newest_before(first_ns, wanted)
        gone = _gone(found)
        for recorded in found:
            # What a process said again and again until it went says nothing of the time after.
            if topic_of(recorded.key) in REPEATED and _service_of(recorded.key) in gone:
                continue
            for due in self._due(recorded):
                yield replace(due, at_ns=first_ns)

    def _due(self, recorded: Recorded) -> Iterator[Due]:
        if is_liveliness_key(recorded.key):
            yield from self._presence(recorded)
            return
        payload = self._namespace.message(recorded.key, recorded.payload)
        if payload is None:
            unreadable = self.left_out.unreadable
            unreadable[recorded.key] = unreadable.get(recorded.key, 0) + 1
            return
        topic = topic_of(recorded.key)
        process = None
        if topic is not None and topic.message is m.Health:
            message = recorded.decoded().message
            if isinstance(message, m.Health):
                process = (message.service, message.instance)
                if message.service == ANSWERED.service:
                    yield from self._answer(recorded, message.instance)
        yield Due(
            recorded.log_time_ns,
            self._namespace.key(recorded.key),
            payload,
            Priority.DATA if topic is None else topic.priority,
            process,
        )

    def _answer(self, report: Recorded, instance: str) -> Iterator[Due]:
        """Yield what the robot that reports said of itself, where another start reported before."""
        envelope = report.decoded().envelope
        if envelope is None or envelope.boot_id == self._answering:
            return
        self._answering = envelope.boot_id
        key = ANSWERED.key(self._namespace.robot, instance)
        answer = self._answers.of(envelope.boot_id)
        payload = None if answer is None else self._namespace.message(key, answer.payload)
        if payload is None:
            self.left_out.undescribed = True
        yield Due(report.log_time_ns, key, payload or b"", is_answer=True)

    def _presence(self, recorded: Recorded) -> Iterator[Due]:
        change = recorded.decoded().message
        if isinstance(change, Liveliness) and self._selection.shows(change.service):
            process = (change.service, change.instance)
            yield Due(recorded.log_time_ns, "", process=process, present=change.alive)


def _service_of(key: str) -> str:
    """Return whose key it is."""
    return key.split("/")[4]


def _gone(found: Iterable[Recorded]) -> set[str]:
    """Return the services of which each process that was ever seen had gone."""
    seen: dict[str, bool] = {}
    for recorded in found:
        if is_liveliness_key(recorded.key):
            change = recorded.decoded().message
            if isinstance(change, Liveliness):
                seen[change.service] = seen.get(change.service, False) or change.alive
    return {service for service, is_there in seen.items() if not is_there}
