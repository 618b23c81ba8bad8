"""What requests cost lately, in one line for the health report."""

import statistics
import threading
from collections import deque

from w2c_llm.backend import Usage

_KEPT = 100


class Metrics:
    """Costs of the last requests. Thread-safe."""

    def __init__(self) -> None:
        self._lock = threading.Lock()
        self._answered = 0
        self._costs: deque[tuple[float, Usage]] = deque(maxlen=_KEPT)

    def add(self, queue_ms: float, usage: Usage) -> None:
        """Count an answer, and what it cost."""
        with self._lock:
            self._answered += 1
            self._costs.append((queue_ms, usage))

    def summary(self) -> str:
        """Return counts and medians over the last hundred answers; "" before the first."""
        with self._lock:
            answered, costs = self._answered, list(self._costs)
        if not costs:
            return ""
        queue = statistics.median(queue_ms for queue_ms, _ in costs)
        prefill = statistics.median(usage.prefill_ms for _, usage in costs)
        decode = statistics.median(usage.decode_ms for _, usage in costs)
        asked = sum(usage.prompt_tokens for _, usage in costs)
        reused = sum(usage.reused_tokens for _, usage in costs)
        return (
            f"{answered} answers; median of the last {len(costs)}: queue {queue:.0f}, "
            f"prefill {prefill:.0f}, decode {decode:.0f} ms; "
            f"{100 * reused / max(asked, 1):.0f} % of prompts reused"
        )
