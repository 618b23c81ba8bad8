"""Depth pictures on the wire."""

import numpy as np
import pytest
import zstandard

from w2c.depth import DEPTH_UNIT, decode_depth, encode_depth, unpack_depth
from w2c.errors import MessageError


def test_round_trip_keeps_depth_within_half_a_unit() -> None:
    depth = np.random.default_rng(0).uniform(0.1, 16.0, (36, 64)).astype(np.float32)

    back = decode_depth(encode_depth(depth), 64, 36)

    assert back.dtype == np.float32
    assert np.abs(back - depth).max() <= 0.5 * DEPTH_UNIT + 1e-6


def test_what_is_read_of_it_is_what_the_whole_has_there() -> None:
    """To the bit: a recorded session is compared with what is computed from it anew."""
    rng = np.random.default_rng(0)
    encoded = encode_depth(rng.uniform(0.0, 16.0, (36, 64)).astype(np.float32))
    whole, unpacked = decode_depth(encoded, 64, 36), unpack_depth(encoded, 64, 36)
    rows, columns = rng.integers(36, size=50), rng.integers(64, size=50)

    assert unpacked.shape == whole.shape
    assert unpacked[3, 5] == whole[3, 5]
    assert (unpacked[4:20:3, ::7] == whole[4:20:3, ::7]).all()
    assert (unpacked[rows, columns] == whole[rows, columns]).all()
    assert unpacked[4:9].dtype == np.float32


def test_what_cannot_be_measured_is_unknown() -> None:
    depth = np.array([[0.0, -1.0, np.nan, np.inf, 17.0, 1.0]], dtype=np.float32)

    assert decode_depth(encode_depth(depth), 6, 1).tolist() == [[0, 0, 0, 0, 0, 1.0]]


def test_another_size_is_refused() -> None:
    encoded = encode_depth(np.ones((4, 8), np.float32))

    with pytest.raises(MessageError, match="64 bytes, expected 72"):
        decode_depth(encoded, 9, 4)


def test_bytes_that_are_no_depth_are_refused() -> None:
    with pytest.raises(MessageError, match="not zstd"):
        decode_depth(b"nonsense", 8, 4)


def test_a_bomb_is_not_unpacked() -> None:
    bomb = zstandard.ZstdCompressor().compress(bytes(50_000_000))

    with pytest.raises(MessageError, match="50000000 bytes"):
        decode_depth(bomb, 8, 4)
