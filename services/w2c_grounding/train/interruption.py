"""Ctrl-C and SIGTERM end a training at its next step, so that nothing is lost."""

import shlex
import signal
from collections.abc import Callable, Iterator, Sequence
from contextlib import contextmanager
from types import FrameType

_SIGNALS = (signal.SIGINT, signal.SIGTERM)


@contextmanager
def interruptible() -> Iterator[Callable[[], bool]]:
    """Yield a function that says whether the process was asked to end. For the main thread.

    A second signal ends it at once, as it would have without this.
    """
    asked = False
    before = {number: signal.getsignal(number) for number in _SIGNALS}

    def remember(number: int, _: FrameType | None) -> None:
        nonlocal asked
        asked = True
        signal.signal(number, before[signal.Signals(number)])

    for number in _SIGNALS:
        signal.signal(number, remember)
    try:
        yield lambda: asked
    finally:
        for number, handler in before.items():
            signal.signal(number, handler)


def continuation(program: str, arguments: Sequence[str]) -> str:
    """Return what to tell who ended a training: the command, and what makes it go on."""
    given = [one for one in arguments if one != "--resume"]
    return f"stopped; go on with: {program} {shlex.join([*given, '--resume'])}"
