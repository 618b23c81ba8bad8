"""Pictures in and out: files in memory to arrays and back."""

import io

import numpy as np
from PIL import Image, UnidentifiedImageError

from w2c.errors import RefusedError
from w2c_grounding.family import RgbImage

MAX_PIXELS = 40_000_000
"""A small file can claim to be a huge picture; this bounds what decoding may take (120 MB)."""

_FORMATS = ("JPEG", "PNG")


def decode(data: bytes) -> RgbImage:
    """Return the picture (height, width, 3) of a JPEG or PNG file.

    Raises:
        RefusedError: the bytes are no picture, are cut off, or claim more than `MAX_PIXELS` pixels.
    """
    try:
        with Image.open(io.BytesIO(data), formats=_FORMATS) as picture:
            width, height = picture.size
            if width * height > MAX_PIXELS:
                raise RefusedError(
                    f"the picture has {width} x {height} pixels, limit {MAX_PIXELS}; "
                    "send a smaller one"
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
