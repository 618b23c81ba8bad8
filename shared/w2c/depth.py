"""Depth on the wire: zstd of little-endian uint16 [v, u], z-depth in units, 0 = unknown."""

from typing import Any

import numpy as np
import numpy.typing as npt

from w2c.errors import MessageError

DEPTH_UNIT = 0.00025
"""[m]; 16 bits then reach 16.4 m."""
_LEVEL = 1
_MAX_PIXELS = 8192 * 8192


def encode_depth(depth: npt.NDArray[np.float32], unit: float = DEPTH_UNIT) -> bytes:
    """Return the bytes of z-depths (h, w) [m]; not finite, not positive, too far: unknown."""
    import zstandard

    scaled = np.divide(depth, np.float32(unit), dtype=np.float32)
    # NaN compares false with everything.
    scaled[~((scaled >= 0.5) & (scaled < 65535.5))] = 0.0
    units = np.rint(scaled, out=scaled).astype("<u2")
    return bytes(zstandard.ZstdCompressor(level=_LEVEL).compress(units.tobytes()))


class UnpackedDepth:
    """Depth in units of the wire, scaled where it is read: most questions read little of it.

    To be read like an array (h, w) of z-depths [m], 0 = unknown; `[:]` gives that array.
    """

    def __init__(self, units: npt.NDArray[np.uint16], unit: float) -> None:
        """Take units (h, w) and what one of them is [m]."""
        self._units = units
        self._unit = np.float32(unit)

    @property
    def shape(self) -> tuple[int, ...]:
        """Rows and columns."""
        return self._units.shape

    def __getitem__(self, index: Any) -> npt.NDArray[np.float32]:
        """Return z-depths at any index that numpy knows [m]; a copy."""
        return np.asarray(self._units[index] * self._unit, dtype=np.float32)


def unpack_depth(
    encoded: bytes, width: int, height: int, unit: float = DEPTH_UNIT
) -> UnpackedDepth:
    """Return the depth of a picture.

    Raises:
        MessageError: the bytes are not a depth picture of this size. Nothing larger is unpacked.
    """
    import zstandard

    expected = 2 * width * height
    if not 0 < width * height <= _MAX_PIXELS:
        raise MessageError(f"depth of {width}x{height} px, expected 1 to {_MAX_PIXELS} px in all")
    try:
        declared = zstandard.get_frame_parameters(encoded).content_size
        if declared != expected:
            raise MessageError(
                f"depth unpacks to {declared} bytes, expected {expected} for {width}x{height} px"
            )
        raw = zstandard.ZstdDecompressor().decompress(encoded, max_output_size=expected)
    except zstandard.ZstdError as error:
        raise MessageError(f"depth is not zstd: {error}") from error
    return UnpackedDepth(np.frombuffer(raw, dtype="<u2").reshape(height, width), unit)


def decode_depth(
    encoded: bytes, width: int, height: int, unit: float = DEPTH_UNIT
) -> npt.NDArray[np.float32]:
    """Return z-depths (h, w) [m], 0 = unknown. Raises MessageError as `unpack_depth`."""
    return unpack_depth(encoded, width, height, unit)[:]
