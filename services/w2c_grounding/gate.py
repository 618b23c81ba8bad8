"""One at a time, a few may wait, the rest hear at once that they must not."""

import threading
from collections.abc import Iterator
from contextlib import contextmanager

from w2c.errors import RefusedError


class Gate:
    """Lets one thread through at a time and bounds how many wait."""

    def __init__(self, limit: int) -> None:
        self._limit = limit
        self._turn = threading.Lock()
        self._count = threading.Lock()
        self._inside = 0

    @property
    def waiting(self) -> int:
        """Threads that wait for their turn."""
        with self._count:
            return max(0, self._inside - 1)

    @contextmanager
    def turn(self) -> Iterator[None]:
        """Hold the only turn. Raises RefusedError where the limit of waiting threads is reached."""
        with self._count:
            if self._inside > self._limit:
                raise RefusedError(
                    f"grounding is busy: {self._inside - 1} requests wait, limit {self._limit}; "
                    "ask again, or start another replica with --instance"
                )
            self._inside += 1
        try:
            with self._turn:
                yield
        finally:
            with self._count:
                self._inside -= 1
