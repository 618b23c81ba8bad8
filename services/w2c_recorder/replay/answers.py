"""Calls that a replay answers as they were answered: those that ask for a lasting fact.

A service that starts on a replay asks the robot what it is, before anything else; the recording
holds the answer in the trace of who asked then. All other calls make something happen, or ask about
a moment that the caller chooses: nobody answers them.
"""

from dataclasses import dataclass
from pathlib import Path

from w2c import messages as m
from w2c import topics
from w2c_recorder.reading import Recorded, Recording, decode_payload, topic_of

ANSWERED = topics.DESCRIBE
"""The method"""
ANSWERED_NAME = f"{ANSWERED.service}/{ANSWERED.name}"
NOBODY_ASKED = "the recording does not hold what this start of the robot is: nobody asked it then"
NAME_WITHIN = 400
"""Which call it is stands in front of what was said [B]"""


@dataclass(frozen=True)
class Answer:
    """What the robot said of itself."""

    boot_id: str
    """Of the start of the robot that answered, as recorded"""
    payload: bytes
    """The reply as it was on the wire"""


class Answers:
    """The robot's descriptions of itself in a recording, one for each of its starts."""

    def __init__(self, path: Path) -> None:
        self._path = path
        self._found: dict[str, Answer | None] = {}

    def of(self, boot_id: str) -> Answer | None:
        """Return what the robot answered after one of its starts; None where nobody asked it.

        Reads the recording from its beginning to the answer, which in one of `w2c up` stands in the
        first seconds; a second question about the same start reads nothing.

        Raises:
            RecordingError: there is no such file, or it is no recording.
        """
        if boot_id not in self._found:
            self._found[boot_id] = self._read(boot_id)
        return self._found[boot_id]

    def _read(self, boot_id: str) -> Answer | None:
        # A look of its own: one that ends early must not tell of a damage that is none.
        traces = Recording(self._path).messages(
            lambda key: topic_of(key) is topics.TRACE, decode=False
        )
        for recorded in traces:
            answer = answer_of(recorded)
            if answer is not None and answer.boot_id == boot_id:
                return answer
        return None


def answer_of(recorded: Recorded) -> Answer | None:
    """Return the answer in a trace; None for other calls, and for one that got none."""
    if ANSWERED.name.encode() not in recorded.payload[:NAME_WITHIN]:
        return None
    trace = recorded.decoded().message
    if not isinstance(trace, m.CallTrace) or trace.outcome != "ok":
        return None
    if (trace.service, trace.method) != (ANSWERED.service, ANSWERED.name):
        return None
    envelope, reply, _ = decode_payload(trace.reply, ANSWERED.reply)
    if envelope is None or reply is None:
        return None
    return Answer(envelope.boot_id, trace.reply)
