"""Messages to bytes and back.

msgpack makes the bytes, msgspec validates into the structs on arrival.
Arrays are one msgpack extension type: dtype, shape, little-endian bytes. Images are bytes fields.
"""

import math
import struct
from typing import Any, TypeVar

import msgpack
import msgspec
import numpy as np

from w2c.errors import MessageError
from w2c.messages import Array, Message

ENVELOPE_VERSION = 1
ARRAY_EXTENSION = 1
MAX_BYTES = 64_000_000
MAX_DIMENSIONS = 4
_DTYPES = {"<f8", "<f4", "<i8", "<i4", "<u8", "<u4", "<u2", "|u1", "|i1", "|b1"}

M = TypeVar("M", bound=Message)


class Input(msgspec.Struct, frozen=True):
    """Reference to a message that another one was computed from."""

    key: str
    boot_id: str
    sequence: int


class Envelope(msgspec.Struct, frozen=True, forbid_unknown_fields=True):
    """What travels around every message."""

    version: int
    robot: str
    sender: str
    boot_id: str
    """New at each start of the sender"""
    sequence: int
    """Counts the sender's messages on this key"""
    monotonic_ns: int
    """Sender's monotonic clock"""
    clock_ns: int
    """Sender's wall clock, since 1970"""
    inputs: list[Input]
    data: Any
    """The message, not yet validated into its struct"""


def _pack_array(array: Array) -> msgpack.ExtType:
    """Return the extension value of an array."""
    if not array.dtype.isnative or array.dtype.str.startswith(">"):
        array = array.astype(array.dtype.newbyteorder("<"))
    dtype = array.dtype.str.encode()
    header = struct.pack(f"<BB{array.ndim}I", len(dtype), array.ndim, *array.shape)
    return msgpack.ExtType(ARRAY_EXTENSION, header + dtype + array.tobytes())


def _unpack_array(payload: bytes) -> Array:
    """Return a read-only array. Raises ValueError for bytes that are none."""
    if len(payload) < 2:
        raise ValueError(f"array of {len(payload)} bytes has no header")
    dtype_length, dimensions = payload[0], payload[1]
    if dimensions > MAX_DIMENSIONS:
        raise ValueError(f"array with {dimensions} dimensions, limit {MAX_DIMENSIONS}")
    shape_end = 2 + 4 * dimensions
    data_start = shape_end + dtype_length
    if len(payload) < data_start:
        raise ValueError(f"array header needs {data_start} bytes, got {len(payload)}")
    shape = struct.unpack_from(f"<{dimensions}I", payload, 2)
    name = payload[shape_end:data_start].decode("ascii", "replace")
    if name not in _DTYPES:
        raise ValueError(f"array dtype '{name}' is not one of {sorted(_DTYPES)}")
    dtype = np.dtype(name)
    expected = math.prod(shape) * dtype.itemsize
    if len(payload) - data_start != expected:
        raise ValueError(
            f"array {shape} of {name} needs {expected} bytes, got {len(payload) - data_start}"
        )
    return np.frombuffer(payload, dtype, offset=data_start).reshape(shape)


def _pack_default(value: Any) -> Any:
    """Tell msgpack how to pack what it does not know."""
    if isinstance(value, msgspec.Struct):
        return {name: getattr(value, name) for name in value.__struct_fields__}
    if isinstance(value, np.ndarray):
        return _pack_array(value)
    if isinstance(value, np.generic):
        return value.item()
    raise TypeError(f"{type(value).__name__} cannot travel on the bus")


def _unpack_extension(code: int, payload: bytes) -> Any:
    if code != ARRAY_EXTENSION:
        raise ValueError(f"unknown msgpack extension {code}")
    return _unpack_array(payload)


def _convert_unknown(expected: type, value: Any) -> Any:
    """Let arrays through msgspec, which does not know them; refuse all else."""
    if isinstance(value, np.ndarray):
        return value
    raise ValueError(f"expected an array, got {type(value).__name__} (for {expected})")


def encode_message(message: Message) -> bytes:
    """Return the bytes of a message without an envelope. Raises MessageError."""
    return _pack(message)


def encode_envelope(envelope: Envelope) -> bytes:
    """Return the bytes of an envelope with its message. Raises MessageError."""
    return _pack(envelope)


def _pack(value: Message | Envelope) -> bytes:
    try:
        return bytes(msgpack.packb(value, default=_pack_default))
    except UnicodeEncodeError as error:
        # What a terminal makes of bytes that are no UTF-8.
        raise MessageError(
            f"a text holds {error.object[error.start]!a}, which is no whole character; type it anew"
        ) from error


def _unpack(payload: bytes, limit: int) -> Any:
    if len(payload) > limit:
        raise MessageError(f"{len(payload)} bytes, limit {limit}")
    try:
        return msgpack.unpackb(payload, ext_hook=_unpack_extension, strict_map_key=True)
    except (ValueError, TypeError, msgpack.exceptions.UnpackException) as error:
        raise MessageError(f"not msgpack: {error}") from error


def decode_envelope(payload: bytes, limit: int = MAX_BYTES) -> Envelope:
    """Return the envelope; its data is not validated yet. Raises MessageError."""
    try:
        envelope = msgspec.convert(
            _unpack(payload, limit), Envelope, builtin_types=(bytes,), dec_hook=_convert_unknown
        )
    except msgspec.ValidationError as error:
        raise MessageError(f"not an envelope: {error}") from error
    if envelope.version != ENVELOPE_VERSION:
        raise MessageError(
            f"envelope version {envelope.version}, this program reads {ENVELOPE_VERSION}; "
            "update the older of the two hosts"
        )
    return envelope


def validate(data: Any, message_type: type[M]) -> M:
    """Return the struct of a decoded map. Raises MessageError with the offending path."""
    try:
        return msgspec.convert(
            data, message_type, builtin_types=(bytes,), dec_hook=_convert_unknown
        )
    except (msgspec.ValidationError, TypeError) as error:
        raise MessageError(f"not a {message_type.__name__}: {error}") from error


def decode_message(payload: bytes, message_type: type[M], limit: int = MAX_BYTES) -> M:
    """Return the message of bytes made by `encode_message`. Raises MessageError."""
    return validate(_unpack(payload, limit), message_type)
