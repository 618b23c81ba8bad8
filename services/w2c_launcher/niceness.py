"""Which processes wait when the cores do not suffice for all."""

import errno
import os
import time
from pathlib import Path

_SESSION_GROUP = Path("/proc/self/autogroup")
"""Where the kernel shares the cores between sessions first, and then between their processes: a
process alone in its session is as nice as this file says"""
_ATTEMPTS, _PAUSE_S = 20, 0.12
"""The kernel takes one such wish in a tenth of a second, from whoever is not root"""


def give_way(niceness: int, session_group: Path = _SESSION_GROUP) -> None:
    """Let this process, first and only one of its session, wait for those that are less nice."""
    if niceness == 0:
        return
    os.nice(niceness)
    for _ in range(_ATTEMPTS):
        try:
            session_group.write_text(str(niceness))
        except FileNotFoundError:  # this kernel knows processes only
            return
        except OSError as error:
            if error.errno != errno.EAGAIN:
                return  # containers may show the file and keep it; the process is nice all the same
            time.sleep(_PAUSE_S)
        else:
            return
