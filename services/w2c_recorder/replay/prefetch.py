"""Work ahead on a thread of its own: who sends must not wait for the disk."""

import queue
import threading
from collections.abc import Generator, Iterable, Iterator
from contextlib import contextmanager
from typing import Protocol, TypeVar

BATCHES = 8
BATCH_ITEMS = 100
BATCH_BYTES = 1_000_000
PUT_TIMEOUT_S = 0.1
"""How long the thread takes to notice that nobody wants more [s]"""


class _Sized(Protocol):
    @property
    def size_bytes(self) -> int: ...


T = TypeVar("T", bound=_Sized)


@contextmanager
def prefetched(items: Iterable[T]) -> Generator[Iterator[T]]:
    """Give the items of an iterable that a thread walks through ahead of the reader.

    A bounded number waits. What the iterable raises comes out at the reader, after all items before
    it. The thread ends with the block.
    """
    waiting: queue.Queue[list[T] | BaseException | None] = queue.Queue(BATCHES)
    ending = threading.Event()
    thread = threading.Thread(target=_walk, args=(items, waiting, ending), name="prefetch")
    thread.start()
    try:
        yield _taken(waiting)
    finally:
        ending.set()
        thread.join()


def _walk(
    items: Iterable[T],
    waiting: "queue.Queue[list[T] | BaseException | None]",
    ending: threading.Event,
) -> None:
    last: BaseException | None = None
    try:
        for batch in _batches(items):
            if not _put(waiting, batch, ending):
                return
    except Exception as error:  # it belongs to the reader
        last = error
    _put(waiting, last, ending)


def _batches(items: Iterable[T]) -> Iterator[list[T]]:
    batch: list[T] = []
    size = 0
    try:
        for item in items:
            batch.append(item)
            size += item.size_bytes
            if len(batch) >= BATCH_ITEMS or size >= BATCH_BYTES:
                yield batch
                batch, size = [], 0
    except Exception:
        yield batch
        raise
    yield batch


def _put(
    waiting: "queue.Queue[list[T] | BaseException | None]",
    entry: list[T] | BaseException | None,
    ending: threading.Event,
) -> bool:
    """Return whether it was taken; False where nobody wants more."""
    while not ending.is_set():
        try:
            waiting.put(entry, timeout=PUT_TIMEOUT_S)
        except queue.Full:
            continue
        return True
    return False


def _taken(waiting: "queue.Queue[list[T] | BaseException | None]") -> Iterator[T]:
    while True:
        entry = waiting.get()
        if entry is None:
            return
        if isinstance(entry, BaseException):
            raise entry
        yield from entry
