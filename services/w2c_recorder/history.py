"""The conversation and the motion of a recording in memory, for questions about one instant."""

from collections.abc import Sequence
from dataclasses import dataclass, field
from typing import Generic, Protocol, TypeVar

from w2c import messages as m
from w2c import topics
from w2c.bus import Input
from w2c.errors import RecordingError
from w2c_recorder.calls import Call, call_of
from w2c_recorder.reading import Recorded, Recording

M = TypeVar("M", bound=m.Message)
ROWS = (
    topics.TURN,
    topics.GOAL_EVENT,
    topics.CONTROLLER_STATUS,
    topics.CAMERA_FRAME,
    topics.TRACE,
)
LATE_S = 0.5
"""The trace of a call may reach the recorder after what was made of its reply [s]"""


class _Arrived(Protocol):
    @property
    def at_ns(self) -> int: ...


A = TypeVar("A", bound=_Arrived)


@dataclass(frozen=True)
class Timed(Generic[M]):
    """One message and when it arrived."""

    at_ns: int
    """At the recorder [ns since 1970]"""
    message: M
    sender: str
    source: Input
    """Reference to it"""
    inputs: Sequence[Input]


@dataclass(frozen=True)
class FrameReference:
    """A picture without its bytes."""

    at_ns: int
    stamp_ns: int
    source: Input


@dataclass
class History:
    """What was said, asked, aimed at and done, each in the order of arrival."""

    start_ns: int = 0
    """First arrival of any message [ns since 1970]"""
    end_ns: int = 0
    turns: list[Timed[m.Turn]] = field(default_factory=list)
    events: list[Timed[m.GoalEvent]] = field(default_factory=list)
    statuses: list[Timed[m.ControllerStatus]] = field(default_factory=list)
    """Of 20 a second those that changed phase or goal"""
    calls: list[Call] = field(default_factory=list)
    frames: list[FrameReference] = field(default_factory=list)

    def seconds(self, at_ns: int) -> float:
        """Return a time as the timeline tells it [s]."""
        return (at_ns - self.start_ns) * 1e-9

    def instant(self, seconds: float) -> int:
        """Return a time of the timeline [ns since 1970]. Raises RecordingError outside of it."""
        length = self.seconds(self.end_ns)
        if not 0.0 <= seconds <= length:
            raise RecordingError(
                f"{seconds:.3f} s is outside of the recording, which has {length:.3f} s"
            )
        return self.start_ns + round(seconds * 1e9)

    def target_at(self, at_ns: int) -> Timed[m.Turn] | None:
        """Return the turn whose target was the present one at a time; None before the first."""
        return latest([turn for turn in self.turns if turn.message.target is not None], at_ns)

    def proposal_of(self, target_id: str) -> Timed[m.Turn] | None:
        """Return the turn that first showed a target."""
        for turn in self.turns:
            if turn.message.target is not None and turn.message.target.target_id == target_id:
                return turn
        return None

    def frame_of(self, target: m.Target, at_ns: int) -> FrameReference | None:
        """Return the picture that a target is meant in; None where it was not recorded."""
        found = [frame for frame in self.frames if frame.stamp_ns == target.frame_stamp_ns]
        # A robot that started anew counts from zero again.
        return latest(found, at_ns + round(LATE_S * 1e9)) or (found[0] if found else None)

    def evidence_of(self, target: m.Target) -> Call | None:
        """Return the call that found the objects of a target; None where none did."""
        proposal = self.proposal_of(target.target_id)
        if proposal is None or proposal.message.target is None:
            return None
        phrases = set(proposal.message.target.phrases)
        frame = self.frame_of(target, proposal.at_ns)
        limit_ns = proposal.at_ns + round(LATE_S * 1e9)
        for call in reversed(self.calls):
            if call.end_ns > limit_ns or not isinstance(call.reply, m.GroundingReply):
                continue
            if not phrases or not phrases <= {one.phrase for one in call.reply.evidence}:
                continue
            if frame is None or not call.inputs or frame.source in call.inputs:
                return call
        return None

    def call_by(self, source: Sequence[Input]) -> Call | None:
        """Return the call that one of these references names."""
        for call in self.calls:
            if call.source is not None and call.source in source:
                return call
        return None


def latest(items: Sequence[A], at_ns: int) -> A | None:
    """Return the last that had arrived at a time; None where none had."""
    for item in reversed(items):
        if item.at_ns <= at_ns:
            return item
    return None


def history_of(recording: Recording) -> History:
    """Read a recording once. Raises RecordingError."""
    history = History()
    for recorded in recording.messages(decode=False):
        history.end_ns = max(history.end_ns, recorded.log_time_ns)
        if recorded.topic in ROWS:
            _add(history, recorded.decoded())
    if not history.end_ns:
        raise RecordingError(f"{recording.path} holds no message: {recording.why_empty()}")
    history.start_ns = recording.start_ns
    return history


def _add(history: History, recorded: Recorded) -> None:
    message, envelope = recorded.message, recorded.envelope
    if message is None or envelope is None:
        return
    source = Input(key=recorded.key, boot_id=envelope.boot_id, sequence=envelope.sequence)
    at_ns = recorded.log_time_ns
    rest = (envelope.sender, source, tuple(envelope.inputs))
    if isinstance(message, m.Turn):
        history.turns.append(Timed(at_ns, message, *rest))
    elif isinstance(message, m.GoalEvent):
        history.events.append(Timed(at_ns, message, *rest))
    elif isinstance(message, m.ControllerStatus):
        last = history.statuses[-1].message if history.statuses else None
        if last is None or (last.phase, last.goal_id) != (message.phase, message.goal_id):
            history.statuses.append(Timed(at_ns, message, *rest))
    elif isinstance(message, m.CameraFrame):
        history.frames.append(FrameReference(at_ns, message.stamp_ns, source))
    elif isinstance(message, m.CallTrace):
        history.calls.append(call_of(recorded, message))
