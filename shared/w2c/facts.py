"""What a process is: its configuration, and the checksum of the model that it runs."""

import hashlib
import threading
from pathlib import Path
from typing import Protocol, runtime_checkable

import msgspec

BLOCK_BYTES = 1 << 20


@runtime_checkable
class ModelConfiguration(Protocol):
    """A configuration that names the files of a model."""

    def model_files(self) -> Path | None:
        """Return the model's file or directory; None where it is not on this machine."""


def checksum_of(path: Path) -> str:
    """Return the SHA-256 of a file; of a directory, that of its files' names and checksums.

    Raises:
        OSError: it cannot be read.
    """
    if not path.is_dir():
        digest = hashlib.sha256()
        with path.open("rb") as file:
            while block := file.read(BLOCK_BYTES):
                digest.update(block)
        return digest.hexdigest()
    lines = (
        f"{checksum_of(one)}  {one.relative_to(path).as_posix()}\n"
        for one in sorted(path.rglob("*"))
        if one.is_file()
    )
    return hashlib.sha256("".join(lines).encode()).hexdigest()


class Facts:
    """What the health reports of a process tell of it, the same in each.

    The checksum of a large model takes seconds: until a thread of its own has it, it is not told.
    """

    def __init__(self, config: msgspec.Struct) -> None:
        self._facts = {"configuration": msgspec.json.encode(config, enc_hook=str).decode()}
        if isinstance(config, ModelConfiguration):
            path = config.model_files()
            if path is not None:
                thread = threading.Thread(
                    target=self._add_checksum, args=(path,), name="checksum", daemon=True
                )
                thread.start()

    def __call__(self) -> dict[str, str]:
        """Return name -> value of what is known by now."""
        return self._facts

    def _add_checksum(self, path: Path) -> None:
        try:
            checksum = checksum_of(path)
        except OSError as error:  # the model's own loader says what is wrong with it
            checksum = f"not known: {error.strerror}"
        self._facts = {**self._facts, "model": str(path), "model_sha256": checksum}
