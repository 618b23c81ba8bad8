"""Does what is due when it is due."""

import threading
from collections.abc import Callable, Iterator
from dataclasses import dataclass, field

from w2c.bus import StandIn
from w2c.clock import Clock
from w2c_recorder.replay.answers import NOBODY_ASKED
from w2c_recorder.replay.lateness import Lateness
from w2c_recorder.replay.score import Due

SLICE_NS = 100_000_000
"""A pause in the recording is slept through in pieces, to see whether it goes on at all [ns]"""


@dataclass
class Played:
    """What was sent."""

    messages: int = 0
    bytes: int = 0
    keys: set[str] = field(default_factory=set)
    answered: set[str] = field(default_factory=set)
    """Calls that anyone may make: service/method"""
    passes: int = 0
    lateness: Lateness = field(default_factory=Lateness)


class Player:
    """Sends messages at the pace at which they came.

    Deadlines are counted from the first message of a pass, so that lateness does not add up: after
    a pause of this process what is late goes out at once, in its order.
    """

    def __init__(
        self,
        bus: StandIn,
        clock: Clock,
        *,
        speed: float = 1.0,
        keep_on: Callable[[], bool] = lambda: True,
        stop: threading.Event | None = None,
    ) -> None:
        """Prepare.

        Args:
            bus: where to send.
            clock: of the deadlines.
            speed: 1 = as it was.
            keep_on: looked at ten times a second; False or an error ends it.
            stop: ends it.
        """
        self._bus = bus
        self._clock = clock
        self._speed = speed
        self._keep_on = keep_on
        self._stop = stop or threading.Event()
        self._look_at_ns = 0
        self._present: set[tuple[str, str]] = set()
        self.played = Played()

    def play(self, dues: Iterator[Due]) -> bool:
        """Do all of one pass. Returns False where it was ended before. Raises what `dues` does."""
        begin_ns: int | None = None
        for due in dues:
            if begin_ns is None:
                begin_ns, first_ns = self._clock.now_ns(), due.at_ns
                deadline_ns = begin_ns
            after_ns = round((due.at_ns - first_ns) / self._speed)
            # Two threads of the recorder may overtake each other; the order of the file holds.
            deadline_ns = max(deadline_ns, begin_ns + after_ns)
            if not self._wait_until(deadline_ns):
                return False
            self._do(due, deadline_ns)
        self.played.passes += 1
        return True

    def leave(self) -> None:
        """Let all who are stood in for disappear."""
        for service, instance in sorted(self._present):
            self._bus.disappear(service, instance)
        self._present.clear()

    def _wait_until(self, deadline_ns: int) -> bool:
        while True:
            now_ns = self._clock.now_ns()
            if now_ns >= self._look_at_ns:
                self._look_at_ns = now_ns + SLICE_NS
                if self._stop.is_set() or not self._keep_on():
                    return False
            if now_ns >= deadline_ns:
                return True
            self._clock.sleep_until(min(deadline_ns, now_ns + SLICE_NS))

    def _do(self, due: Due, deadline_ns: int) -> None:
        if due.process is not None:
            self._change(due.process, present=due.present)
        if not due.key:
            return
        if due.is_answer:
            self._answer(due)
            return
        self.played.lateness.add(max(0, self._clock.now_ns() - deadline_ns))
        self._bus.publish_raw(due.key, due.payload, due.priority)
        self.played.messages += 1
        self.played.bytes += len(due.payload)
        self.played.keys.add(due.key)

    def _answer(self, due: Due) -> None:
        if not due.payload:
            self._bus.refuse_raw(due.key, NOBODY_ASKED)
            return
        self._bus.answer_raw(due.key, due.payload)
        _, service, _, method = due.key.rsplit("/", 3)
        self.played.answered.add(f"{service}/{method}")

    def _change(self, process: tuple[str, str], *, present: bool) -> None:
        if present == (process in self._present):
            return
        if present:
            self._bus.appear(*process)
            self._present.add(process)
        else:
            self._bus.disappear(*process)
            self._present.discard(process)
