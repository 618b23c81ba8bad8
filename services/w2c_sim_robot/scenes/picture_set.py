"""A directory of pictures with truth: begun once, continued safely, never mixed with others."""

import errno
from pathlib import Path
from typing import Annotated, Literal

import msgspec

from w2c.errors import ConfigError, W2CError
from w2c_sim_robot.scenes.random_scene import PAPER_SHARE

DESCRIPTION_FILE = "set.json"
VERSION = 6
"""Of what is drawn for a seed: raised when the same seed gives another picture"""


class SetDescription(msgspec.Struct, frozen=True, kw_only=True):
    """What all pictures of a set have in common."""

    width: Annotated[int, msgspec.Meta(ge=16, le=1920)] = 640
    """[px]"""
    height: Annotated[int, msgspec.Meta(ge=16, le=1080)] = 360
    """[px]"""
    picture: Literal["png", "jpg"] = "png"
    depth: bool = True
    paper_share: Annotated[float, msgspec.Meta(ge=0.0, le=1.0)] = PAPER_SHARE
    twins_share: Annotated[float, msgspec.Meta(ge=0.0, le=1.0)] = 0.0
    version: int = VERSION


class PictureSet:
    """The files of a set. A picture is there when its truth file is: that one is written last."""

    def __init__(self, directory: Path, description: SetDescription) -> None:
        self.directory = directory
        self.description = description

    def open(self, seed: int, count: int, *, resume: bool) -> None:
        """Make the directory, or find that it holds this very set.

        Raises:
            ConfigError: it holds other files or another set, or it has pictures of these seeds and
                `resume` is not set, or it cannot be made.
        """
        described = self.directory / DESCRIPTION_FILE
        try:
            self.directory.mkdir(parents=True, exist_ok=True)
            names = sorted(path.name for path in self.directory.iterdir())
        except OSError as error:
            raise ConfigError(f"--out {self.directory} cannot be used: {error}") from error
        if described.name in names:
            self._compare(described)
        elif names:
            raise ConfigError(
                f"--out {self.directory} holds files that are no pictures of this command "
                f"({', '.join(names[:3])}{' ...' if len(names) > 3 else ''}); choose another "
                "directory"
            )
        else:
            text = msgspec.json.format(msgspec.json.encode(self.description), indent=1)
            self.write(DESCRIPTION_FILE, text + b"\n")
        done = sum(self.has(f"{number:07d}") for number in range(seed, seed + count))
        if done and not resume:
            raise ConfigError(
                f"--out {self.directory} has {done} of these {count} pictures already; "
                "add --resume to make the others, or choose another directory"
            )

    def _compare(self, described: Path) -> None:
        try:
            found = msgspec.json.decode(described.read_bytes(), type=SetDescription)
        except (OSError, msgspec.DecodeError) as error:
            raise ConfigError(f"{described}: {error}; choose another directory") from error
        ours, theirs = msgspec.structs.asdict(self.description), msgspec.structs.asdict(found)
        other = [
            f"{key} {theirs[key]}, not {ours[key]}" for key in ours if ours[key] != theirs[key]
        ]
        if other:
            raise ConfigError(
                f"--out {self.directory} holds another set: {'; '.join(other)}; choose the same "
                "flags or another directory"
            )

    def truth_file(self, name: str) -> Path:
        """Return the path of a truth file."""
        return self.directory / f"{name}.json"

    def has(self, name: str) -> bool:
        """Whether a picture is complete."""
        return self.truth_file(name).exists()

    def write(self, name: str, data: bytes) -> None:
        """Write a file as a whole: a process that is killed leaves none that is half.

        Raises:
            W2CError: the disk is full, or another reason; says what to do.
        """
        path = self.directory / name
        unfinished = path.with_name(f".{name}.unfinished")
        try:
            unfinished.write_bytes(data)
            unfinished.replace(path)
        except OSError as error:
            unfinished.unlink(missing_ok=True)
            if error.errno in (errno.ENOSPC, errno.EDQUOT):
                raise W2CError(
                    f"the disk is full: {path} was not written, all pictures before it are "
                    "complete; free some space and run the same command with --resume"
                ) from error
            raise W2CError(f"{path} cannot be written: {error}") from error
