"""Turn a missing optional dependency into the command that installs it."""

from collections.abc import Iterator
from contextlib import contextmanager

from w2c.errors import MissingExtraError


@contextmanager
def needs_extra(extra: str) -> Iterator[None]:
    """Wrap the imports of a service: a missing third-party module becomes a MissingExtraError."""
    try:
        yield
    except ModuleNotFoundError as error:
        name = error.name or "?"
        if name.split(".")[0].startswith("w2c"):
            raise
        raise MissingExtraError(name, extra) from error
