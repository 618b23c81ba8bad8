"""Recorded messages as those of another robot: keys, envelopes and boot ids.

Why so: docs/decisions/0017-replays-are-another-robot.md.
"""

import hashlib
import uuid
from collections.abc import Iterator
from typing import Any, get_args

import msgpack
import msgspec

from w2c import topics
from w2c.bus import Input
from w2c.bus.codec import ENVELOPE_VERSION
from w2c_recorder.mcap_file import NO_ENVELOPE
from w2c_recorder.reading import topic_of

BOOT_ID = "boot_id"
"""What the names of fields end in that say which start of a process is meant"""


class _RawEnvelope(msgspec.Struct, frozen=True):
    """An envelope whose message stays as it is; see `w2c.bus.codec.Envelope`."""

    version: int
    robot: str
    sender: str
    boot_id: str
    sequence: int
    monotonic_ns: int
    clock_ns: int
    inputs: list[Input]
    data: msgspec.Raw


_DECODE = msgspec.msgpack.Decoder(_RawEnvelope).decode
_ENCODE = msgspec.msgpack.Encoder().encode


class Namespace:
    """Turns what one robot's processes said into what another's say.

    All of a recording is mapped alike, so that what refers to each other still does. Each pass has
    boot ids of its own: to a reader the processes were started anew.
    """

    def __init__(self, robot: str, replay_id: str | None = None) -> None:
        """Prepare.

        Args:
            robot: id of the robot that the messages shall be of.
            replay_id: what boot ids are made from; None = a new one.
        """
        self.robot = robot
        self._replay_id = uuid.uuid4().hex if replay_id is None else replay_id
        self._pass = 0
        self._boot_ids: dict[str, str] = {}
        self._made: set[str] = set()

    def begin_pass(self) -> None:
        """Let the processes be new ones from here on."""
        self._pass += 1
        self._boot_ids = {}

    def key(self, key: str) -> str:
        """Return the key of the other robot; the same for "" and for what is no robot's key."""
        parts = key.split("/", 3)
        return "/".join((*parts[:2], self.robot, parts[3])) if len(parts) == 4 else key

    def boot_id(self, boot_id: str) -> str:
        """Return what stands for a recorded boot id in this pass; "" stays ""."""
        if not boot_id:
            return ""
        known = self._boot_ids.get(boot_id)
        if known is None:
            seed = f"{self._replay_id}/{self._pass}/{boot_id}".encode()
            known = hashlib.sha256(seed).hexdigest()[:16]
            self._boot_ids[boot_id] = known
            self._made.add(known)
        return known

    def is_own(self, boot_id: str) -> bool:
        """Tell whether a boot id was made here, in any pass."""
        return boot_id in self._made

    def message(self, key: str, payload: bytes) -> bytes | None:
        """Return the bytes of a recorded message for the other robot.

        Args:
            key: As recorded.
            payload: As recorded.

        Returns:
            The same message, with its sequence number and its times, from the other robot; None for
            bytes that are no envelope, or one of another version.
        """
        try:
            envelope = _DECODE(payload)
        except NO_ENVELOPE:
            return None
        if envelope.version != ENVELOPE_VERSION:
            return None
        topic = topic_of(key)
        data = envelope.data
        if topic in NAMING_BOOTS:
            data = msgspec.Raw(msgpack.packb(self._mapped(msgpack.unpackb(data))))
        return _ENCODE(
            msgspec.structs.replace(
                envelope,
                robot=self.robot,
                boot_id=self.boot_id(envelope.boot_id),
                inputs=[
                    Input(self.key(one.key), self.boot_id(one.boot_id), one.sequence)
                    for one in envelope.inputs
                ],
                data=data,
            )
        )

    def _mapped(self, value: Any) -> Any:
        """Return decoded data with the boot ids of this pass; arrays stay packed."""
        if isinstance(value, list):
            return [self._mapped(item) for item in value]
        if not isinstance(value, dict):
            return value
        return {
            name: self.boot_id(inner)
            if isinstance(inner, str) and str(name).endswith(BOOT_ID)
            else self._mapped(inner)
            for name, inner in value.items()
        }


def _names_boots(message_type: Any) -> bool:
    """Tell whether a message, or a part of it, says of which start of a process it speaks."""
    return any(
        field.name.endswith(BOOT_ID)
        or any(_names_boots(inner) for inner in _structs_in(field.type))
        for field in msgspec.structs.fields(message_type)
    )


def _structs_in(annotation: Any) -> Iterator[Any]:
    if isinstance(annotation, type) and issubclass(annotation, msgspec.Struct):
        yield annotation
    for argument in get_args(annotation):
        yield from _structs_in(argument)


NAMING_BOOTS = frozenset(topic for topic in topics.TOPICS if _names_boots(topic.message))
"""Streams whose messages say of which start of a process they speak"""
