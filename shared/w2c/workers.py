"""Worker processes that end with the one that started them, also where that was killed."""

import os
import threading
from multiprocessing import parent_process

ORPHANED = 1
"""Exit status of a worker without a parent"""


def end_with_parent() -> None:
    """Let this worker end when its parent has: the initializer of a pool of processes.

    A worker waits for tasks from a pipe that stays open when the parent is killed, and would wait,
    with all its memory, for ever.
    """
    parent = parent_process()
    if parent is None:
        return

    def watch() -> None:
        parent.join()
        os._exit(ORPHANED)

    threading.Thread(target=watch, name="parent-watch", daemon=True).start()
