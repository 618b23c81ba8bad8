"""Bytes in, structs out; anything else is refused, never a crash."""

import msgpack
import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st
from hypothesis.extra import numpy as hnp

from w2c.bus.codec import (
    ARRAY_EXTENSION,
    Envelope,
    _pack_array,
    _unpack_array,
    decode_envelope,
    decode_message,
    encode_envelope,
    encode_message,
)
from w2c.errors import MessageError
from w2c.messages import Empty, JointCommand, Picture, SayRequest

DTYPES = st.sampled_from(["<f8", "<f4", "<i8", "<i4", "<u2", "|u1", "|b1"])


@given(hnp.arrays(DTYPES, hnp.array_shapes(min_dims=0, max_dims=4, min_side=0, max_side=4)))
def test_arrays_survive_the_wire_bit_by_bit(array: np.ndarray) -> None:
    again = _unpack_array(_pack_array(array).data)
    assert again.dtype == array.dtype
    assert again.shape == array.shape
    assert again.tobytes() == array.tobytes()


def test_big_endian_arrays_arrive_little_endian() -> None:
    again = _unpack_array(_pack_array(np.array([1.5, -2.0], dtype=">f8")).data)
    assert again.dtype == np.dtype("<f8")
    assert again.tolist() == [1.5, -2.0]


@given(st.binary(max_size=200))
def test_any_bytes_give_an_envelope_or_a_message_error(payload: bytes) -> None:
    try:
        decode_envelope(payload)
    except MessageError:
        return


@given(st.binary(max_size=60))
def test_any_array_payload_gives_an_array_or_a_message_error(payload: bytes) -> None:
    packed = msgpack.packb({"tick": 0, "position": msgpack.ExtType(ARRAY_EXTENSION, payload)})
    try:
        decode_message(packed, JointCommand)
    except MessageError:
        return


def envelope(version: int = 1) -> Envelope:
    return Envelope(version, "talos", "llm", "boot", 0, 1, 2, [], Empty())


def test_a_newer_envelope_is_refused_with_both_versions() -> None:
    with pytest.raises(MessageError, match="version 2, this program reads 1"):
        decode_envelope(encode_envelope(envelope(2)))


def test_too_many_bytes_are_refused_before_they_are_read() -> None:
    with pytest.raises(MessageError, match="limit 10"):
        decode_envelope(encode_envelope(envelope()), limit=10)


def test_a_huge_array_header_allocates_nothing() -> None:
    header = bytes([3, 2]) + (2**31).to_bytes(4, "little") * 2 + b"<f8"
    packed = msgpack.packb({"tick": 0, "position": msgpack.ExtType(ARRAY_EXTENSION, header)})
    with pytest.raises(MessageError, match="needs"):
        decode_message(packed, JointCommand)


def test_half_a_character_is_refused_by_name() -> None:
    with pytest.raises(MessageError, match="udcff"):
        encode_message(SayRequest(text="lean on the caf\udcff"))


def test_text_does_not_pass_for_bytes() -> None:
    packed = msgpack.packb({"stamp_ns": 0, "jpeg": "aGVsbG8="})
    with pytest.raises(MessageError, match="bytes"):
        decode_message(packed, Picture)
