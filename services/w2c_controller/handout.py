"""Copies of the desired state for other threads, made by the loop between two ticks."""

from collections import deque
from queue import Empty, SimpleQueue

from w2c.errors import GoalRefusedError
from w2c_controller.desired import DesiredState


class Handout:
    """Whoever needs a copy waits; the loop never does."""

    def __init__(self) -> None:
        self._waiting: deque[SimpleQueue[DesiredState]] = deque()

    def ask(self, timeout_s: float) -> DesiredState:
        """Return a copy. From any thread but the loop's.

        Raises:
            GoalRefusedError: no tick came.
        """
        slot: SimpleQueue[DesiredState] = SimpleQueue()
        self._waiting.append(slot)
        try:
            return slot.get(timeout=timeout_s)
        except Empty as error:
            raise GoalRefusedError(
                f"the robot did not move on within {timeout_s} s (stopped, or no state): no preview"
            ) from error

    def serve(self, state: DesiredState) -> None:
        """Give a copy to one who waits. For the loop."""
        if self._waiting:
            self._waiting.popleft().put(state.copy())
