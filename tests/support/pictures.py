"""Pictures in tests: read them, or fail."""

from pathlib import Path
from typing import Any

import cv2
import numpy as np


def decoded(jpeg: bytes) -> Any:
    """Return the picture (h, w, 3) BGR of a JPEG."""
    image = cv2.imdecode(np.frombuffer(jpeg, np.uint8), cv2.IMREAD_COLOR)
    assert image is not None, "not a JPEG"
    return image


def read(path: Path) -> Any:
    """Return a picture file as it is: BGR, or one channel of 8 or 16 bits."""
    image = cv2.imread(str(path), cv2.IMREAD_UNCHANGED)
    assert image is not None, f"no picture at {path}"
    return image
