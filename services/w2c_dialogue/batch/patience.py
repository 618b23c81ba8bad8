"""Waiting for a language model that is being started anew, or is busy."""

import time
from collections.abc import Callable, Sequence
from typing import TypeVar

from w2c.errors import UnavailableError

PAUSES_S = (1.0, 2.0, 4.0, 8.0)
"""A process that died is started anew within a few seconds, model and all."""
T = TypeVar("T")


class Patience:
    """Asks again where nobody answers; after one time in vain it waits no more until one does."""

    def __init__(
        self, pauses: Sequence[float] = PAUSES_S, pause: Callable[[float], None] = time.sleep
    ) -> None:
        self._pauses = tuple(pauses)
        self._left = self._pauses
        self._pause = pause

    def ask(self, work: Callable[[], T]) -> T:
        """Return what the work comes to. Raises UnavailableError where nobody answers at last."""
        for wait in self._left:
            try:
                return work()
            except UnavailableError:
                self._pause(wait)
        self._left = ()
        result = work()
        self._left = self._pauses
        return result
