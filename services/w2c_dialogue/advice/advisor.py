"""Advice on the target that is shown: made after the turn is out, on a thread of its own.

It never holds up an answer. What is not ready in time, or fails, is said to be unchecked; what
nobody looks at any more is dropped.
"""

import logging
import threading
from collections.abc import Callable

from w2c.clock import Clock
from w2c.errors import W2CError
from w2c.messages import Advice, AdviceCheck
from w2c_dialogue.advice.checks import Checks, Draft
from w2c_dialogue.conversation import Shown

log = logging.getLogger("w2c.dialogue")


class Advisor:
    """Finds out about the newest target, one check after the other, and publishes after each."""

    def __init__(
        self,
        checks: Checks,
        publish: Callable[[Advice], None],
        shown_id: Callable[[], str],
        clock: Clock,
        *,
        deadline_s: float,
    ) -> None:
        """Prepare.

        Args:
            checks: What is found out.
            publish: Tells it.
            shown_id: Id of the target that is on the screen now.
            clock: Of this process.
            deadline_s: After so long no further check is begun [s].
        """
        self._checks = checks
        self._publish = publish
        self._shown_id = shown_id
        self._clock = clock
        self._deadline_s = deadline_s
        self._next: tuple[Shown, int] | None = None
        self._changed = threading.Condition()
        self._ending = False
        self._thread = threading.Thread(target=self._work, name="advice", daemon=True)

    def start(self) -> None:
        """Begin to work."""
        self._thread.start()

    def close(self) -> None:
        """End after the check that is being made."""
        with self._changed:
            self._ending = True
            self._changed.notify_all()
        if self._thread.is_alive():
            self._thread.join(timeout=2.0)

    def consider(self, shown: Shown) -> None:
        """Ask for advice on a target, instead of the one that waits. Returns at once."""
        with self._changed:
            self._next = shown, self._clock.now_ns()
            self._changed.notify_all()

    def advise(self, shown: Shown, start_ns: int) -> None:
        """Make all checks of a target that is shown since a time [ns]."""
        draft = Draft(shown, start_ns, [name for name, _ in self._checks.all])
        for name, check in self._checks.all:
            if self._over(shown):
                return
            draft.pending.remove(name)
            late_s = (self._clock.now_ns() - start_ns) * 1e-9
            if late_s > self._deadline_s:
                draft.skip(name, f"no time left after {late_s:.1f} s, limit {self._deadline_s:g} s")
            else:
                self._make(name, check, draft)
            if self._over(shown):
                return
            self._publish(draft.as_message(self._clock.now_ns()))

    def _make(self, name: AdviceCheck, check: Callable[[Draft], None], draft: Draft) -> None:
        try:
            check(draft)
        except W2CError as error:
            log.warning("advice: check not made", extra={"check": name, "reason": str(error)})
            draft.skip(name, str(error))

    def _over(self, shown: Shown) -> bool:
        """Tell whether the target is no longer on the screen."""
        over = self._ending or self._shown_id() != shown.target.target_id
        if over:
            log.info("advice dropped", extra={"target": shown.target.target_id})
        return over

    def _work(self) -> None:
        while True:
            with self._changed:
                self._changed.wait_for(lambda: self._next is not None or self._ending)
                if self._ending:
                    return
                job, self._next = self._next, None
            if job is not None:
                self.advise(*job)
