"""Pictures in and out: files in memory to arrays and back."""

import io

import numpy as np
from PIL import Image, UnidentifiedImageError

from w2c.errors import RefusedError
from w2c_grounding.family import RgbImage

MAX_PIXELS = 40_000_000
"""A small file can claim to be a huge picture; this bounds what decoding may take (120 MB)."""

MAX_ASPECT = 30
"""Longer side over shorter. Scaled for a model, a longer strip would have no height left."""

_FORMATS = ("JPEG", "PNG")

_DEEP_MODES = ("I", "F")
"""Of Pillow, "I;16" too: more than 8 bits a channel, which conversion would cut off at white"""


def decode(data: bytes) -> RgbImage:
    """Return the picture (height, width, 3) of a JPEG or PNG file.

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
            return np.array(picture.convert("RGB"), dtype=np.uint8)
    except UnidentifiedImageError as error:
        raise RefusedError(
            f"the {len(data)} bytes are neither JPEG nor PNG; send a camera picture"
        ) from error
    # Pillow reports damage by whichever of these its decoder met first.
    except (OSError, SyntaxError, ValueError, Image.DecompressionBombError) as error:
        raise RefusedError(f"the picture is damaged: {error}; send it again") from error


def encode_png(image: RgbImage) -> bytes:
    """Return the picture as a PNG file."""
    buffer = io.BytesIO()
    Image.fromarray(image).save(buffer, format="PNG")
    return buffer.getvalue()
