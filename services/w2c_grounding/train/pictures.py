"""Pictures for training, decoded once and kept in files that are mapped into memory.

Decoding a picture takes longer than looking at it. Two plain files hold all of them squashed to
squares, as the model reads them: the colours, and which object each pixel shows. The operating
system keeps what is used in memory, as far as there is room.
"""

import errno
import hashlib
from collections.abc import Sequence
from concurrent.futures import ThreadPoolExecutor
from dataclasses import dataclass
from pathlib import Path

import cv2
import msgspec
import numpy as np
import numpy.typing as npt

from w2c.errors import ConfigError, W2CError
from w2c_grounding.train.data import PictureTruth, read_identity, read_truth

_INDEX = "pictures.json"


@dataclass(frozen=True)
class Pictures:
    """A set of pictures, squashed to squares."""

    truths: tuple[PictureTruth, ...]
    pixels: npt.NDArray[np.uint8]
    """(n, side, side, 3)"""
    identities: npt.NDArray[np.uint8]
    """(n, side, side)"""

    def __len__(self) -> int:
        """Return the number of pictures."""
        return len(self.truths)


class _Index(msgspec.Struct, frozen=True):
    """What the two files hold."""

    side: int
    digest: str


def open_pictures(files: Sequence[Path], side: int, directory: Path, threads: int = 1) -> Pictures:
    """Return the pictures of truth files, from the files in a directory, which it makes if need be.

    Raises:
        ConfigError: a picture is missing or damaged.
        W2CError: the disk is full.
    """
    truths = tuple(read_truth(path) for path in files)
    wanted = _Index(side, digest(files))
    if _found(directory) != wanted:
        _write(files, truths, side, directory, threads)
        encoded = msgspec.json.encode(wanted)
        unfinished = directory / f".{_INDEX}.unfinished"
        unfinished.write_bytes(encoded)
        unfinished.replace(directory / _INDEX)
    count = len(files)
    pixels = np.memmap(directory / "pixels.u8", np.uint8, "r", shape=(count, side, side, 3))
    identities = np.memmap(directory / "identities.u8", np.uint8, "r", shape=(count, side, side))
    return Pictures(truths, pixels, identities)


def digest(files: Sequence[Path]) -> str:
    """Return what changes when a picture of the set does: of names, sizes and times."""
    text = hashlib.sha256()
    for path in files:
        stat = path.stat()
        text.update(f"{path.resolve()} {stat.st_size} {stat.st_mtime_ns}\n".encode())
    return text.hexdigest()


def _found(directory: Path) -> _Index | None:
    try:
        return msgspec.json.decode((directory / _INDEX).read_bytes(), type=_Index)
    except (OSError, msgspec.DecodeError):
        return None


def _write(
    files: Sequence[Path],
    truths: Sequence[PictureTruth],
    side: int,
    directory: Path,
    threads: int,
) -> None:
    """Write the two files. Raises ConfigError or W2CError."""
    size = len(files) * side * side * 4
    try:
        directory.mkdir(parents=True, exist_ok=True)
        (directory / _INDEX).unlink(missing_ok=True)
        with (
            (directory / "pixels.u8").open("wb") as pixels,
            (directory / "identities.u8").open("wb") as identities,
            ThreadPoolExecutor(threads) as workers,
        ):
            # In portions: what is decoded and not yet written stays small.
            portion = 16 * threads
            for first in range(0, len(files), portion):
                part = slice(first, first + portion)
                jobs = workers.map(_squashed, files[part], truths[part], [side] * portion)
                for small, owners in jobs:
                    pixels.write(small.tobytes())
                    identities.write(owners.tobytes())
    except OSError as error:
        if error.errno in (errno.ENOSPC, errno.EDQUOT):
            raise W2CError(
                f"the disk is full: {directory} needs {size / 1e9:.1f} GB for {len(files)} "
                "pictures; free some space, or choose another --out"
            ) from error
        raise W2CError(f"{directory} cannot be written: {error}") from error


def _squashed(
    path: Path, truth: PictureTruth, side: int
) -> tuple[npt.NDArray[np.uint8], npt.NDArray[np.uint8]]:
    """Return colours (side, side, 3) and owners (side, side), as the run-time processor does."""
    from PIL import Image

    try:
        with Image.open(path.parent / truth.image) as picture:
            small = picture.convert("RGB").resize((side, side), Image.Resampling.BILINEAR)
    except OSError as error:
        raise ConfigError(f"picture of {path}: {error}; render this picture again") from error
    owners = cv2.resize(read_identity(path, truth), (side, side), interpolation=cv2.INTER_NEAREST)
    return np.asarray(small), np.asarray(owners, dtype=np.uint8)
