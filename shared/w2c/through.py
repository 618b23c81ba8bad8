"""How a service is run on its recorded inputs: what it is given, and what it says of its outputs.

Each service that can be registers one function, a `Through`, under its name in the entry-point
group `w2c.through`. It reads the recording, does what the service did, and yields for each of its
recorded outputs how the one that it made differs from it, or why it could not make it.
"""

from collections.abc import Iterator, Sequence
from dataclasses import dataclass
from importlib.metadata import entry_points
from typing import Any, Protocol, TypeVar, cast

import msgspec

from w2c import topics
from w2c.bus import Envelope, Input
from w2c.config import ServiceConfig
from w2c.difference import Difference
from w2c.errors import ConfigError, RecordingError
from w2c.messages import Message
from w2c.topics import Topic

C = TypeVar("C", bound=ServiceConfig)

GROUP = "w2c.through"
CONFIGURATION = "configuration"
"""Fact of a process: see `w2c.facts`"""


@dataclass(frozen=True)
class Heard:
    """One recorded message of a stream."""

    topic: Topic[Any]
    message: Any
    envelope: Envelope
    key: str
    seconds: float
    """When it reached the recorder, in the time of the timeline [s]"""

    def as_input(self) -> Input:
        """Return the reference that messages made of this one carry in their `inputs`."""
        return Input(key=self.key, boot_id=self.envelope.boot_id, sequence=self.envelope.sequence)


@dataclass(frozen=True)
class Asked:
    """One recorded call."""

    service: str
    method: str
    outcome: str
    """ok, or the code of the error"""
    error: str
    """Its text"""
    request: Message | None
    """None where it does not decode"""
    reply: Message | None
    """None where none came, or it does not decode; an ErrorReply where the call was refused"""
    caller: str
    replier_boot_id: str
    """Of the process that answered; "" where none did"""
    inputs: Sequence[Input]
    """What the request was made of"""
    source: Input | None
    """Reference to the request"""
    began_s: float
    """In the time of the timeline [s]"""
    seconds: float
    """When its trace reached the recorder"""


class Session(Protocol):
    """A recording, read as often as one likes, each time from its beginning."""

    def heard(self, *rows: Topic[Any]) -> Iterator[Heard]:
        """Yield the messages of these streams that decode, in the order of their arrival."""

    def asked(self, *services: str) -> Iterator[Asked]:
        """Yield the calls to these services, in the order in which their traces arrived."""


@dataclass(frozen=True)
class Compared:
    """One output that was made again."""

    stream: str
    """Which output: kind/service/name of a message, service/method of a call"""
    what: str
    """Which one of them, as: tick 4480"""
    seconds: float
    """Of the recorded one, in the time of the timeline [s]"""
    found: Sequence[Difference]
    """Between the recorded one and the one made now; empty: equal bit by bit"""
    tolerance: float
    """Below which a difference of numbers does not count, in their unit"""
    inputs: Sequence[str] = ()
    """What it was made of, for people; only where something differs"""

    def differs(self, tolerance: float | None = None) -> bool:
        """Return whether it differs by more than a tolerance; None = its own."""
        limit = self.tolerance if tolerance is None else tolerance
        return any(difference.size > limit for difference in self.found)


@dataclass(frozen=True)
class Skipped:
    """Recorded outputs that were not made again."""

    stream: str
    seconds: float
    reason: str
    count: int = 1


class Through(Protocol):
    """What a service registers."""

    def __call__(self, session: Session, tolerance: float | None) -> Iterator[Compared | Skipped]:
        """Make the recorded outputs again.

        Args:
            session: The recording.
            tolerance: Beyond it an output differs, and what is made of it is not looked at; None =
                the service's own.

        Raises:
            RecordingError: what the service must know is not in the recording.
        """


def configuration(session: Session, service: str, config_type: type[C]) -> C:
    """Return what a process ran with, as its health reports tell; the defaults where none does.

    Raises:
        RecordingError: it told something that this version does not understand.
    """
    robot = "recorded"
    for heard in session.heard(topics.HEALTH):
        robot, health = heard.envelope.robot, heard.message
        if health.service != service or CONFIGURATION not in health.facts:
            continue
        try:
            return msgspec.json.decode(health.facts[CONFIGURATION], type=config_type)
        except msgspec.DecodeError as error:
            raise RecordingError(
                f"{service} ran with a configuration that this version does not understand: {error}"
            ) from error
    return config_type(robot=robot)


def through(service: str) -> Through:
    """Return what runs a service on a recording. Raises ConfigError where none can be."""
    points = {point.name: point for point in entry_points(group=GROUP)}
    if service not in points:
        raise ConfigError(
            f"'{service}' cannot be run on a recording; choose one of: "
            f"{', '.join(sorted(points)) or 'none is installed'}"
        )
    return cast(Through, points[service].load())
