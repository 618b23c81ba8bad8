"""Reads what `w2c scenes render` writes: a picture, and which object each pixel shows."""

from collections.abc import Sequence
from dataclasses import dataclass
from pathlib import Path

import cv2
import msgspec
import numpy as np
import numpy.typing as npt

from w2c.errors import ConfigError

MIN_VISIBLE_SHARE = 0.0004
"""Of the picture. What shows less (92 pixels of 640 x 360) is neither asked for nor called
absent."""


class ObjectTruth(msgspec.Struct, frozen=True):
    """One object of a picture, without the fields that training has no use for."""

    id: int
    """Its value in the identity picture"""
    kind: str
    colour: str
    names: tuple[str, ...]
    """What people call it, the usual word first"""
    phrases: tuple[str, ...]
    """All phrases that fit it"""
    visible_pixels: int
    held_out: bool = False
    """Kind and colour never occur together in pictures for training"""


class PictureTruth(msgspec.Struct, frozen=True):
    """One truth file."""

    image: str
    """File name of the picture"""
    identity: str
    """File name of the picture whose values say which object a pixel shows; 0 = none"""
    width: int
    height: int
    seed: int
    objects: tuple[ObjectTruth, ...]

    def clearly_visible(self) -> list[ObjectTruth]:
        """Return the objects that show enough of themselves to be asked for."""
        least = MIN_VISIBLE_SHARE * self.width * self.height
        return [item for item in self.objects if item.visible_pixels >= least]


@dataclass(frozen=True)
class Pictures:
    """A set of pictures in memory, squashed to squares as the model reads them."""

    truths: tuple[PictureTruth, ...]
    pixels: npt.NDArray[np.uint8]
    """(n, side, side, 3)"""
    identities: npt.NDArray[np.uint8]
    """(n, side, side)"""

    def __len__(self) -> int:
        """Return the number of pictures."""
        return len(self.truths)


def truth_files(directory: Path) -> list[Path]:
    """Return the truth files of a directory in the order of their seeds. Raises ConfigError."""
    if not directory.is_dir():
        raise ConfigError(
            f"no directory {directory}; make pictures with: w2c scenes render --out {directory}"
        )
    files = sorted(directory.glob("[0-9]*.json"))
    if not files:
        raise ConfigError(
            f"{directory} holds no truth files (NUMBER.json); "
            f"make pictures with: w2c scenes render --out {directory} --count 3000"
        )
    return files


def read_truth(path: Path) -> PictureTruth:
    """Read one truth file. Raises ConfigError."""
    try:
        return msgspec.json.decode(path.read_bytes(), type=PictureTruth)
    except (OSError, msgspec.DecodeError) as error:
        raise ConfigError(f"truth file {path}: {error}; render this picture again") from error


def read_identity(path: Path, truth: PictureTruth) -> npt.NDArray[np.uint8]:
    """Return who owns each pixel (height, width). Raises ConfigError."""
    identity = cv2.imread(str(path.parent / truth.identity), cv2.IMREAD_UNCHANGED)
    if identity is None or identity.ndim != 2 or identity.dtype != np.uint8:
        raise ConfigError(
            f"{path.parent / truth.identity} is no grey 8-bit picture; render this picture again"
        )
    return np.asarray(identity, dtype=np.uint8)


def load_pictures(files: Sequence[Path], side: int) -> Pictures:
    """Read pictures and squash them to `side` x `side`, as the run-time processor does.

    Raises:
        ConfigError: a file is missing or damaged.
    """
    from PIL import Image

    truths = tuple(read_truth(path) for path in files)
    pixels = np.empty((len(files), side, side, 3), dtype=np.uint8)
    identities = np.empty((len(files), side, side), dtype=np.uint8)
    for index, (path, truth) in enumerate(zip(files, truths, strict=True)):
        try:
            with Image.open(path.parent / truth.image) as picture:
                small = picture.convert("RGB").resize((side, side), Image.Resampling.BILINEAR)
        except OSError as error:
            raise ConfigError(f"picture of {path}: {error}; render this picture again") from error
        pixels[index] = np.asarray(small)
        owners = read_identity(path, truth)
        identities[index] = cv2.resize(owners, (side, side), interpolation=cv2.INTER_NEAREST)
    return Pictures(truths, pixels, identities)
