"""Read a folder of pictures, prompts and masks, whoever made it, and say what is wrong with it.

The prompts are JSON lines (`prompts.jsonl`) or a table (`prompts.csv` with the same field names in
its first line). A bad line spoils nothing but itself: all faults are found in one pass.
"""

import csv
import io
from collections.abc import Iterator
from dataclasses import dataclass
from pathlib import Path, PurePosixPath

import cv2
import msgspec
import numpy as np
import numpy.typing as npt

from w2c.errors import ConfigError
from w2c_evaluation.benchmark.record import IMAGES, MASKS, PROMPTS_FILE, Record

Mask = npt.NDArray[np.bool_]
TABLE_FILE = "prompts.csv"
SUFFIXES = (".jpg", ".jpeg", ".png", ".JPG", ".JPEG", ".PNG")
ACCEPTED_FROM = 128
"""Of 255: masks that went through a lossy format are not exactly black and white"""
SHOWN_FAULTS = 5
SIGNATURES = (b"\xff\xd8\xff", b"\x89PNG\r\n\x1a\n")
"""How a JPEG and a PNG begin, whatever their name ends in"""
MOST_BYTES = 20_000_000
"""Of a picture: a request to grounding holds no more"""
MOST_PIXELS = 40_000_000
"""Of a picture: grounding decodes no larger one"""


@dataclass(frozen=True)
class Item:
    """A record with its files."""

    record: Record
    image: Path
    mask: Path

    def picture(self) -> bytes:
        """Return the file of the picture, JPEG or PNG. Raises ConfigError."""
        try:
            return self.image.read_bytes()
        except OSError as error:
            raise ConfigError(f"{self.image} cannot be read: {error.strerror}") from error

    def accepted(self) -> Mask:
        """Return where a point is accepted (h, w). Raises ConfigError."""
        return read_mask(self.mask)


def load(directory: Path) -> list[Item]:
    """Return the items of a folder in the order of its prompts.

    Raises:
        ConfigError: something is wrong with it; says the first faults.
    """
    items, faults = read(directory)
    if faults:
        more = f" and {len(faults) - SHOWN_FAULTS} more" if len(faults) > SHOWN_FAULTS else ""
        raise ConfigError(
            f"{directory} is no sound benchmark: {'; '.join(faults[:SHOWN_FAULTS])}{more}. "
            f"`w2c benchmark check {directory}` says all of it"
        )
    return items


def read(directory: Path) -> tuple[list[Item], list[str]]:
    """Return the sound items of a folder, and what is wrong with the others and with the whole."""
    try:
        lines = list(_lines(directory))
    except ConfigError as error:
        return [], [str(error)]
    items: list[Item] = []
    faults: list[str] = []
    seen: set[str] = set()
    for where, line in lines:
        found = _item(directory, where, line, seen)
        if isinstance(found, Item):
            items.append(found)
        else:
            faults += found
    if not lines:
        faults.append(f"{directory} has no prompts")
    return items, [*faults, *_strays(directory, items, seen)]


def read_mask(path: Path) -> Mask:
    """Return a mask (h, w): true where any channel is bright. Raises ConfigError."""
    found = _decoded(path, cv2.IMREAD_UNCHANGED)
    if found.ndim == 3:
        # An alpha channel says nothing of the area: it is opaque in most editors.
        found = found[:, :, :3].max(axis=2)
    bright = ACCEPTED_FROM if found.dtype == np.uint8 else ACCEPTED_FROM * 257
    if found.dtype == np.uint8 and found.max(initial=0) == 1:
        bright = 1
    return np.asarray(found >= bright, dtype=np.bool_)


def _lines(directory: Path) -> Iterator[tuple[str, bytes]]:
    """Yield the prompts as JSON, each with where it stands. Raises ConfigError."""
    if not directory.is_dir():
        raise ConfigError(
            f"no directory {directory}; make one with: w2c benchmark make --out {directory}"
        )
    for name in (PROMPTS_FILE, TABLE_FILE):
        path = directory / name
        if not path.is_file():
            continue
        try:
            data = path.read_bytes()
        except OSError as error:
            raise ConfigError(f"{path} cannot be read: {error.strerror}") from error
        yield from _json_lines(data) if name == PROMPTS_FILE else _table_lines(path, data)
        return
    raise ConfigError(f"{directory} has neither {PROMPTS_FILE} nor {TABLE_FILE}")


def _json_lines(data: bytes) -> Iterator[tuple[str, bytes]]:
    for number, line in enumerate(data.splitlines(), 1):
        if line.strip():
            yield f"{PROMPTS_FILE}, line {number}", line


def _table_lines(path: Path, data: bytes) -> Iterator[tuple[str, bytes]]:
    try:
        table = csv.DictReader(io.StringIO(data.decode("utf-8-sig")), strict=True)
        for row in table:
            fields = {key: value for key, value in row.items() if key and value is not None}
            yield f"{TABLE_FILE}, line {table.line_num}", msgspec.json.encode(fields)
    except (UnicodeDecodeError, csv.Error) as error:
        raise ConfigError(f"{path} is no table in UTF-8: {error}") from error


def _item(directory: Path, where: str, line: bytes, seen: set[str]) -> Item | list[str]:
    """Return a sound item, or what is wrong with it."""
    try:
        record = msgspec.json.decode(line, type=Record)
    except (msgspec.MsgspecError, ValueError) as error:
        return [f"{where}: {error}"]
    where = f"{where} ({record.id})"
    if record.id in seen:
        return [f"{where}: the id is used twice"]
    seen.add(record.id)
    faults: list[str] = []
    paths: list[Path] = []
    for folder, given in ((IMAGES, record.image), (MASKS, record.mask)):
        try:
            paths.append(_find(directory, folder, given, record.id))
        except ConfigError as error:
            faults.append(f"{where}: {error}")
    if not faults:
        faults = [f"{where}: {fault}" for fault in _misfits(record, *paths)]
    return faults or Item(record, *paths)


def _find(directory: Path, folder: str, given: str, name: str) -> Path:
    """Return the file of a record. Raises ConfigError where there is none."""
    if given:
        inside = PurePosixPath(given)
        if inside.is_absolute() or ".." in inside.parts:
            raise ConfigError(f"'{given}' leads out of the folder")
        path = directory / inside
        if not path.is_file():
            raise ConfigError(f"there is no {given}")
        return path
    for suffix in SUFFIXES:
        path = directory / folder / f"{name}{suffix}"
        if path.is_file():
            return path
    raise ConfigError(f"there is no {folder}/{name} with any of: {' '.join(SUFFIXES[:3])}")


def _misfits(record: Record, image: Path, mask: Path) -> list[str]:
    """Return what is wrong with a picture, its mask, and what its record says is in it."""
    try:
        picture = _decoded(image, cv2.IMREAD_COLOR)
        accepted = read_mask(mask)
    except ConfigError as error:
        return [str(error)]
    if picture.shape[:2] != accepted.shape:
        (height, width), (rows, columns) = picture.shape[:2], accepted.shape
        return [f"the picture has {width}x{height} px, its mask {columns}x{rows}"]
    if not accepted.any():
        return ["the mask is empty: no point would be accepted"]
    if accepted.all():
        return ["the mask is full: every point would be accepted"]
    pixels = picture.shape[0] * picture.shape[1]
    return [*_unreadable(image, pixels), *_wrong_things(record, accepted)]


def _unreadable(image: Path, pixels: int) -> list[str]:
    """Return why no vision model would be shown a picture."""
    data = image.read_bytes()
    if not data.startswith(SIGNATURES):
        return ["the picture is neither JPEG nor PNG inside: convert it"]
    if len(data) > MOST_BYTES or pixels > MOST_PIXELS:
        return [
            f"the picture has {len(data)} bytes and {pixels} pixels, limits {MOST_BYTES} and "
            f"{MOST_PIXELS}: make it smaller, and its mask"
        ]
    return []


def _wrong_things(record: Record, mask: Mask) -> list[str]:
    """Return what the things of a record cannot be: errors would be told of the wrong step."""
    if record.things is None:
        return []
    if not record.things:
        return ["things is empty: leave it out where they are not known"]
    height, width = mask.shape
    said = " ".join(record.prompt.casefold().split())
    faults = []
    for thing in record.things:
        left, top, right, bottom = thing.box
        if not thing.words.strip() or " ".join(thing.words.casefold().split()) not in said:
            faults.append(f"the prompt does not say '{thing.words}'")
        if not (0 <= left < right <= width and 0 <= top < bottom <= height):
            faults.append(
                f"the box of '{thing.words}' is ({left:g}, {top:g}, {right:g}, {bottom:g}), "
                f"expected left, top, right, bottom within {width}x{height}"
            )
    return faults


def _decoded(path: Path, flags: int) -> npt.NDArray[np.integer]:
    try:
        data = np.frombuffer(path.read_bytes(), np.uint8)
        found = cv2.imdecode(data, flags) if data.size else None
    except (OSError, cv2.error) as error:
        raise ConfigError(f"{path.name} cannot be read: {error}") from error
    if found is None:
        raise ConfigError(f"{path.parent.name}/{path.name} is no picture, or it is cut short")
    return np.asarray(found)


def _strays(directory: Path, items: list[Item], named: set[str]) -> list[str]:
    """Return the pictures and masks that no prompt speaks of."""
    known = {path for item in items for path in (item.image, item.mask)}
    found = (
        path
        for folder in (IMAGES, MASKS)
        for path in sorted((directory / folder).glob("*"))
        if path.suffix in SUFFIXES and path not in known and path.stem not in named
    )
    return [f"{path.parent.name}/{path.name}: no prompt belongs to it" for path in found]
