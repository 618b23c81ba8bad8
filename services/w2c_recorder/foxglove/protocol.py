"""Messages of Foxglove as an MCAP file holds them: bytes, schema, and the numbers in them."""

from dataclasses import dataclass
from typing import Any

from foxglove_schemas_protobuf.Color_pb2 import Color
from foxglove_schemas_protobuf.Pose_pb2 import Pose
from foxglove_schemas_protobuf.Quaternion_pb2 import Quaternion
from foxglove_schemas_protobuf.Vector3_pb2 import Vector3
from google.protobuf.descriptor import FileDescriptor
from google.protobuf.descriptor_pb2 import FileDescriptorSet
from google.protobuf.message import Message
from google.protobuf.timestamp_pb2 import Timestamp


@dataclass(frozen=True)
class Shown:
    """One message for Foxglove."""

    topic: str
    """Below `foxglove/<robot>/`"""
    message: Message


def schema_of(message: Message) -> tuple[str, bytes]:
    """Return name and descriptors of a message: what a reader needs to decode it."""
    described = FileDescriptorSet()
    _describe(message.DESCRIPTOR.file, described, set())
    return message.DESCRIPTOR.full_name, described.SerializeToString()


def _describe(file: FileDescriptor, described: FileDescriptorSet, known: set[str]) -> None:
    """Add a file after those that it needs: some readers take them in their order."""
    if file.name in known:
        return
    known.add(file.name)
    for needed in file.dependencies:
        _describe(needed, described, known)
    file.CopyToProto(described.file.add())


def timestamp(nanoseconds: int) -> Timestamp:
    """Return a time [ns since 1970]."""
    return Timestamp(seconds=nanoseconds // 10**9, nanos=nanoseconds % 10**9)


def vector(values: Any) -> Vector3:
    """Return a vector (3,)."""
    return Vector3(x=float(values[0]), y=float(values[1]), z=float(values[2]))


def pose_at(position: Any) -> Pose:
    """Return a pose with the axes of its frame."""
    return Pose(position=vector(position), orientation=Quaternion(w=1.0))


def colour(red: float, green: float, blue: float, opacity: float = 1.0) -> Color:
    """Return a colour, each from 0 to 1."""
    return Color(r=red, g=green, b=blue, a=opacity)
