"""Pictures in and out: files in memory to arrays and back."""

import io
import struct

import numpy as np
from PIL import ExifTags, Image, UnidentifiedImageError

from w2c.errors import RefusedError
from w2c_grounding.family import RgbImage

MAX_PIXELS = 40_000_000
"""A small file can claim to be a huge picture; this bounds what decoding may take (120 MB)."""

MAX_ASPECT = 30
"""Longer side over shorter. Scaled for a model, a longer strip would have no height left."""

_TURNS = {
    2: Image.Transpose.FLIP_LEFT_RIGHT,
    3: Image.Transpose.ROTATE_180,
    4: Image.Transpose.FLIP_TOP_BOTTOM,
    5: Image.Transpose.TRANSPOSE,
    6: Image.Transpose.ROTATE_270,
    7: Image.Transpose.TRANSVERSE,
    8: Image.Transpose.ROTATE_90,
}
"""EXIF's number for how a camera was held -> what makes its picture upright; 1 is upright"""

_FORMATS = ("JPEG", "PNG")

_DEEP_MODES = ("I", "F")
"""Of Pillow, "I;16" too: more than 8 bits a channel, which conversion would cut off at white"""


def decode(data: bytes) -> RgbImage:
    """Return the picture (height, width, 3) of a JPEG or PNG file, as people see it.

    A telephone writes a photograph on its side, with a note of how it was held: it is turned
    upright.

    Raises:
        RefusedError: the bytes are no picture, are cut off, claim more than `MAX_PIXELS` pixels, or
            are a strip or a depth picture.
    """
    try:
        with Image.open(io.BytesIO(data), formats=_FORMATS) as picture:
            width, height = picture.size
            if width * height > MAX_PIXELS:
                raise RefusedError(
                    f"the picture has {width} x {height} pixels, limit {MAX_PIXELS}; "
                    "send a smaller one"
                )
            if max(width, height) > MAX_ASPECT * min(width, height):
                raise RefusedError(
                    f"the picture of {width} x {height} pixels is a strip: one side is more than "
                    f"{MAX_ASPECT} times the other; send a camera picture"
                )
            if picture.mode.split(";")[0] in _DEEP_MODES:
                raise RefusedError(
                    f"the picture has more than 8 bits a channel (mode {picture.mode}), as depth "
                    "has; send a colour or grey picture with 8"
                )
            return np.array(_upright(picture).convert("RGB"), dtype=np.uint8)
    except UnidentifiedImageError as error:
        raise RefusedError(
            f"the {len(data)} bytes are neither JPEG nor PNG; send a camera picture"
        ) from error
    # Pillow has a limit of its own, above ours, and looks at it before anyone can ask the size.
    except Image.DecompressionBombError as error:
        raise RefusedError(
            f"the picture is too large, limit {MAX_PIXELS} pixels; send a smaller one ({error})"
        ) from error
    # Pillow reports damage by whichever of these its decoder met first.
    except (OSError, SyntaxError, ValueError) as error:
        raise RefusedError(f"the picture is damaged: {error}; send it again") from error


def _upright(picture: Image.Image) -> Image.Image:
    try:
        held = picture.getexif().get(ExifTags.Base.Orientation)
    # A note that nobody can read says nothing; Pillow reports damage in it by any of these.
    except (OSError, SyntaxError, ValueError, TypeError, struct.error):
        return picture
    turn = _TURNS.get(held) if isinstance(held, int) else None
    return picture if turn is None else picture.transpose(turn)


def encode_png(image: RgbImage) -> bytes:
    """Return the picture as a PNG file."""
    buffer = io.BytesIO()
    Image.fromarray(image).save(buffer, format="PNG")
    return buffer.getvalue()
