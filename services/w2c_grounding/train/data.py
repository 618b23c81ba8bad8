"""Reads what `w2c scenes render` writes: a picture, and which object each pixel shows."""

from collections.abc import Mapping
from pathlib import Path

import cv2
import msgspec
import numpy as np
import numpy.typing as npt

from w2c.errors import ConfigError, RefusedError
from w2c_grounding.family import RgbImage
from w2c_grounding.picture import decode

MIN_VISIBLE_SHARE = 0.0012
"""Of the picture. What shows less (1106 pixels of 1280 x 720) is neither asked for nor called
absent."""
ROBOT = 255
"""In identity pictures"""


SIZES = ("large ", "small ")
"""How phrases of one among others of its kind begin"""


class PartTruth(msgspec.Struct, frozen=True):
    """A named part of an object."""

    name: str


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
    material: str = ""
    parts: tuple[PartTruth, ...] = ()
    held_out: bool = False
    """Kind and colour never occur together in pictures for training"""
    held_out_kind: bool = False
    """The kind never occurs in pictures for training"""
    held_out_material: bool = False
    """Kind and material never occur together in pictures for training"""
    box: tuple[int, int, int, int] | None = None
    """Left, top, right, bottom of what shows of it in the whole picture [px]; the last two are
    exclusive"""
    looks_like: tuple[str, ...] = ()
    """Words of materials of which it is not, but might be, as far as people see"""


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


def cropped(truth: PictureTruth, width: int, height: int, shown: Mapping[int, int]) -> PictureTruth:
    """Return the truth about a part of a picture, or about a smaller copy.

    Args:
        truth: Of the whole picture.
        width: Of the part [px].
        height: Of the part [px].
        shown: Pixels there by id of object; what is not there is no longer in the picture.
    """
    kinds_outside = {item.kind for item in truth.objects if not shown.get(item.id)}
    objects = []
    for item in truth.objects:
        if shown.get(item.id):
            phrases = item.phrases
            if item.kind in kinds_outside:
                # Large and small are said of one among others that can be seen.
                phrases = tuple(text for text in phrases if not text.startswith(SIZES))
            changes = {"phrases": phrases, "visible_pixels": shown[item.id]}
            objects.append(msgspec.structs.replace(item, **changes))
    return msgspec.structs.replace(truth, width=width, height=height, objects=tuple(objects))


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


def read_picture(path: Path, truth: PictureTruth) -> RgbImage:
    """Read the picture of a truth file. Raises ConfigError."""
    try:
        return decode((path.parent / truth.image).read_bytes())
    except (OSError, RefusedError) as error:
        raise ConfigError(f"picture of {path}: {error}; render this picture again") from error


def read_identity(path: Path, truth: PictureTruth) -> npt.NDArray[np.uint8]:
    """Return who owns each pixel (height, width). Raises ConfigError."""
    identity = cv2.imread(str(path.parent / truth.identity), cv2.IMREAD_UNCHANGED)
    if identity is None or identity.ndim != 2 or identity.dtype != np.uint8:
        raise ConfigError(
            f"{path.parent / truth.identity} is no grey 8-bit picture; render this picture again"
        )
    return np.asarray(identity, dtype=np.uint8)
