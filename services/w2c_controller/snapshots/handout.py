"""Copies of what the loop works on for other threads, made by the loop between two ticks."""

from collections import deque
from collections.abc import Callable
from queue import Empty, SimpleQueue
from typing import Generic, TypeVar

from w2c.errors import GoalRefusedError

T = TypeVar("T")


class Handout(Generic[T]):
    """Whoever needs a copy waits; the loop never does."""

    def __init__(self) -> None:
        self._waiting: deque[SimpleQueue[T]] = deque()

    def ask(self, timeout_s: float) -> T:
        """Return a copy. From any thread but the loop's.

        Raises:
            GoalRefusedError: no tick came.
        """
        slot: SimpleQueue[T] = SimpleQueue()
        self._waiting.append(slot)
        try:
            return slot.get(timeout=timeout_s)
        except Empty as error:
            raise GoalRefusedError(
                f"the controller did not move on within {timeout_s} s: it holds, or gets no state"
            ) from error

    def __bool__(self) -> bool:
        """Whether somebody waits."""
        return bool(self._waiting)

    def serve(self, copy: Callable[[], T]) -> None:
        """Give a copy to one who waits. For the loop."""
        if self._waiting:
            self._waiting.popleft().put(copy())
