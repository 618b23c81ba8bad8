"""Depth of the pictures that were asked about last, unpacked."""

import threading
from collections import OrderedDict

from w2c_perception.buffer import View
from w2c_perception.window import DepthPicture


class DepthMemory:
    """Unpacks a depth once. Thread-safe.

    A picture is asked about many times in a row: candidates for a target, a target and its
    corrections, heights, the allowed area. Unpacked it is ten times as large as it came, so only
    the last few are kept.
    """

    def __init__(self, kept: int) -> None:
        """Prepare.

        Args:
            kept: How many; those asked for last stay.
        """
        self._kept = kept
        self._lock = threading.Lock()
        self._depths: OrderedDict[View, DepthPicture] = OrderedDict()

    def of(self, view: View) -> DepthPicture:
        """Return the depth (h, w) of a view [m], 0 = unknown.

        Raises:
            MessageError: the camera sent something else.
        """
        with self._lock:
            depth = self._depths.get(view)
            if depth is not None:
                self._depths.move_to_end(view)
                return depth
        # Without the lock: who asks about another picture need not wait, and one that is unpacked
        # twice does no harm.
        depth = view.unpack_depth()
        with self._lock:
            self._depths[view] = depth
            while len(self._depths) > self._kept:
                self._depths.popitem(last=False)
        return depth

    def clear(self) -> None:
        """Forget everything."""
        with self._lock:
            self._depths.clear()
