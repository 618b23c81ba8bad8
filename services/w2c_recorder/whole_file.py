"""Files that another library writes, and that are there whole or not at all."""

import tempfile
from collections.abc import Iterator
from contextlib import contextmanager
from pathlib import Path

from w2c.errors import ConfigError


@contextmanager
def whole_file(out: Path) -> Iterator[Path]:
    """Yield where to write a file; it gets its name when the block ends without an error.

    That is in a directory of its own beside the name, with room for other files that are needed
    on the way, and goes in any case but a kill -9.

    Args:
        out: name of the new file.

    Raises:
        ConfigError: there is such a file already, or none can be made there.
    """
    if out.exists():
        raise ConfigError(f"{out} is there already; remove it, or choose another --out")
    try:
        out.parent.mkdir(parents=True, exist_ok=True)
        with tempfile.TemporaryDirectory(prefix=f".{out.name}-", dir=out.parent) as directory:
            unfinished = Path(directory) / out.name
            yield unfinished
            unfinished.rename(out)
    except OSError as error:
        raise ConfigError(
            f"{out} cannot be written: {error.strerror}; choose another --out"
        ) from error
