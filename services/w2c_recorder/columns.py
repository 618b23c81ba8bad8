"""Messages of one stream as rows of numbers."""

from collections.abc import Iterator, Mapping
from dataclasses import dataclass

import msgspec
import numpy as np

from w2c import messages as m
from w2c import topics
from w2c.errors import ConfigError, RecordingError
from w2c_recorder.reading import Recorded, Recording, decode_call

TIMES = ("seconds", "log_time_ns", "publish_time_ns", "sequence")
"""First columns of every table"""
LONGEST_ARRAY = 200
"""Elements; pictures, maps of heat and of heights have more and are no numbers of a table"""

Cell = float | int | str
Row = dict[str, Cell]
Kind = type[float] | type[int] | type[str]


@dataclass(frozen=True)
class Span:
    """A part of a recording, in the time of the timeline [s]."""

    start: float = 0.0
    end: float = float("inf")


def rows_of(recording: Recording, name: str, span: Span) -> Iterator[Row]:
    """Yield a row a message of a stream (`state/robot/joints`), in the order of arrival.

    Raises:
        ConfigError: the recording has no such stream; says which it has.
        RecordingError: there is no such file, or none of the messages can be read.
    """
    joints = joint_names(recording)
    known: set[str] = set()
    problem, found, read = "", 0, 0
    for recorded in recording.messages(decode=False):
        stream = recorded.key.split("/", 3)[-1]
        known.add(stream)
        seconds = (recorded.log_time_ns - recording.start_ns) * 1e-9
        if stream != name or not span.start <= seconds <= span.end:
            continue
        found += 1
        message = recorded.decoded()
        if message.message is None:
            problem = message.problem
            continue
        read += 1
        yield _row(message, message.message, seconds, joints)
    if name not in known:
        raise ConfigError(
            f"{recording.path} has no stream '{name}'; it has {', '.join(sorted(known)) or 'none'}"
        )
    if found and not read:
        raise RecordingError(f"no message of {name} can be read: {problem}")


def joint_names(recording: Recording) -> list[str]:
    """Return the names of the joints, in the order of the vectors; none where nobody asked."""
    for recorded in recording.of(topics.TRACE):
        trace = recorded.message
        if not isinstance(trace, m.CallTrace) or trace.method != topics.DESCRIBE.name:
            continue
        reply = decode_call(trace)[1]
        if isinstance(reply, m.RobotDescription):
            return [joint.name for joint in reply.joints]
    return []


def _row(recorded: Recorded, message: m.Message, seconds: float, joints: list[str]) -> Row:
    times = (seconds, recorded.log_time_ns, recorded.publish_time_ns, recorded.sequence)
    row: Row = dict(zip(TIMES, times, strict=True))
    for field in message.__struct_fields__:
        row.update(_cells(field, getattr(message, field), joints))
    return row


def _cells(name: str, value: object, joints: list[str]) -> Iterator[tuple[str, Cell]]:
    """Yield the columns of a field: one a number or a word, one an element of an array."""
    if isinstance(value, bool):
        yield name, int(value)
    elif isinstance(value, int | float | str):
        yield name, value
    elif isinstance(value, np.ndarray):
        if value.size <= LONGEST_ARRAY:
            yield from _elements(name, value, joints)
    elif isinstance(value, msgspec.Struct):
        for field in value.__struct_fields__:
            yield from _cells(f"{name}.{field}", getattr(value, field), joints)
    elif isinstance(value, Mapping):
        for key, inner in value.items():
            yield from _cells(f"{name}.{key}", inner, joints)
    elif isinstance(value, list | tuple) and len(value) <= LONGEST_ARRAY:
        for index, inner in enumerate(value):
            yield from _cells(f"{name}[{index}]", inner, joints)


def _elements(name: str, array: m.Array, joints: list[str]) -> Iterator[tuple[str, Cell]]:
    labels = joints if array.ndim == 1 and len(joints) == len(array) else None
    for index in np.ndindex(array.shape):
        label = ",".join(map(str, index)) if labels is None else labels[index[0]]
        yield f"{name}[{label}]", array[index].item()


def common_kind(before: Kind | None, cell: Cell) -> Kind:
    """Return the type that a column needs for its cells so far and one more."""
    kind = type(cell)
    if before is None or before is kind:
        return kind
    return str if str in (before, kind) else float
