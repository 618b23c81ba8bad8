"""Pictures in and out."""

import io
import struct
import zlib

import cv2
import numpy as np
import pytest
from PIL import ExifTags, Image

from w2c.errors import RefusedError
from w2c_grounding.picture import decode, encode_png


def jpeg(width: int = 64, height: int = 48, mode: str = "RGB") -> bytes:
    buffer = io.BytesIO()
    noise = np.random.default_rng(0).integers(0, 255, (height, width, 3), dtype=np.uint8)
    Image.fromarray(noise).convert(mode).save(buffer, format="JPEG")
    return buffer.getvalue()


def test_a_jpeg_becomes_an_array_indexed_by_row_then_column() -> None:
    image = decode(jpeg(64, 48))
    assert image.shape == (48, 64, 3)
    assert image.dtype == np.uint8


def test_a_grey_jpeg_becomes_three_channels() -> None:
    assert decode(jpeg(mode="L")).shape == (48, 64, 3)


def test_png_is_read_back_as_written() -> None:
    image = np.random.default_rng(1).integers(0, 255, (5, 7, 3), dtype=np.uint8)
    assert (decode(encode_png(image)) == image).all()


@pytest.mark.parametrize("data", [b"", b"not a picture", b"\xff\xd8\xff\xe0 hardly one", b"GIF89a"])
def test_bytes_that_are_no_picture_are_refused(data: bytes) -> None:
    with pytest.raises(RefusedError, match="picture"):
        decode(data)


def test_a_cut_off_jpeg_is_refused_not_half_used() -> None:
    whole = jpeg()
    with pytest.raises(RefusedError, match="damaged"):
        decode(whole[: len(whole) // 2])


def test_a_small_file_that_claims_a_huge_picture_is_refused() -> None:
    def chunk(kind: bytes, body: bytes) -> bytes:
        checksum = struct.pack(">I", zlib.crc32(kind + body))
        return struct.pack(">I", len(body)) + kind + body + checksum

    header = struct.pack(">IIBBBBB", 9000, 9000, 8, 2, 0, 0, 0)
    bomb = b"\x89PNG\r\n\x1a\n" + chunk(b"IHDR", header) + chunk(b"IDAT", b"") + chunk(b"IEND", b"")
    with pytest.raises(RefusedError, match="9000 x 9000"):
        decode(bomb)


def test_a_header_of_more_pixels_than_pillow_opens_is_too_large_not_damaged() -> None:
    whole = png(Image.new("RGB", (4, 4)))
    header = struct.pack(">IIBBBBB", 20_000, 20_000, 8, 2, 0, 0, 0)
    checksum = struct.pack(">I", zlib.crc32(b"IHDR" + header))
    with pytest.raises(RefusedError, match="too large, limit 40000000 pixels; send a smaller one"):
        decode(whole[:16] + header + checksum + whole[33:])


@pytest.mark.parametrize("held", range(1, 9))
def test_a_photograph_is_turned_upright_as_every_viewer_shows_it(held: int) -> None:
    corner = np.zeros((48, 64, 3), dtype=np.uint8)
    corner[:16, :16] = 255
    note = Image.Exif()
    note[ExifTags.Base.Orientation] = held
    buffer = io.BytesIO()
    Image.fromarray(corner).save(buffer, format="JPEG", quality=95, exif=note)
    shown = cv2.imdecode(np.frombuffer(buffer.getvalue(), np.uint8), cv2.IMREAD_COLOR)
    assert shown is not None
    upright = decode(buffer.getvalue())
    assert upright.shape == shown.shape
    assert ((upright[:, :, 0] > 128) == (shown[:, :, 0] > 128)).all()


def test_a_note_of_how_a_camera_was_held_that_nobody_can_read_says_nothing(
    monkeypatch: pytest.MonkeyPatch,
) -> None:
    def unreadable(self: Image.Image) -> Image.Exif:
        raise struct.error("unpack requires a buffer of 12 bytes")

    monkeypatch.setattr(Image.Image, "getexif", unreadable)
    assert decode(jpeg(64, 48)).shape == (48, 64, 3)


def png(image: Image.Image) -> bytes:
    buffer = io.BytesIO()
    image.save(buffer, format="PNG")
    return buffer.getvalue()


@pytest.mark.parametrize("mode", ["RGBA", "LA", "P", "1"])
def test_every_usual_kind_of_png_becomes_three_channels(mode: str) -> None:
    assert decode(png(Image.new("RGB", (64, 48), (250, 250, 250)).convert(mode))).shape == (
        48,
        64,
        3,
    )


def test_a_depth_picture_is_refused_not_read_as_white() -> None:
    deep = Image.fromarray(np.full((48, 64), 1500, dtype=np.uint16))
    with pytest.raises(RefusedError, match="8 bits"):
        decode(png(deep))


def test_a_strip_is_refused() -> None:
    with pytest.raises(RefusedError, match="3100 x 100"):
        decode(png(Image.new("RGB", (3100, 100))))
    assert decode(png(Image.new("RGB", (1, 1)))).shape == (1, 1, 3)
