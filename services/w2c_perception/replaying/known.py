"""Which views were made of states that are not in the recording, so that nobody can judge them.

A view names the states that were taken for it, and another subscriber recorded them: each of the
two loses some of its own. One that is missing matters to the pictures taken near it, and to all
that come later where the feet changed meanwhile.
"""

from bisect import bisect_left
from collections import deque
from collections.abc import Iterable

from w2c.stance import SETTLED_NS, Stance
from w2c_perception.buffer import NEIGHBOURS

MOST_KEPT = 2000
"""States before the newest: twenty seconds of those that perception takes"""


class Known:
    """Follows which states of one robot were taken again, and where some are missing."""

    def __init__(self) -> None:
        self._stamps: deque[int] = deque(maxlen=MOST_KEPT)
        """Of those that were taken [ns]"""
        self._count = 0
        """Of all that were taken, kept here or not"""
        self._missing: deque[int] = deque(maxlen=MOST_KEPT)
        """For each that is missing: how many had been taken before it"""
        self._settles_ns = -1
        """Until then the feet may change later than they did [ns]"""
        self._unsure_world = -1
        """Number of the world in which the feet may stand elsewhere; -1 = none"""

    def lose(self) -> None:
        """Note that a state comes next that is missing."""
        self._missing.append(self._count)

    def take(self, stamp_ns: int, before: Stance | None, after: Stance | None) -> None:
        """Note a state [ns], and the stance before and after it was taken."""
        if self._missing and self._missing[-1] == self._count:
            self._settles_ns = stamp_ns + SETTLED_NS
        self._stamps.append(stamp_ns)
        self._count += 1
        if stamp_ns > self._settles_ns or after is None:
            return
        if before is None or before.standing != after.standing:
            self._unsure_world = after.world

    def why_not(self, instants_ns: Iterable[int], world: int) -> str:
        """Return why a view cannot be judged; "" = all that it was made of is there.

        Args:
            instants_ns: At which its colours and its depth were taken [ns].
            world: Number of the present one.
        """
        stamps, first = list(self._stamps), self._count - len(self._stamps)
        near: set[int] = set()
        for instant_ns in instants_ns:
            after = first + bisect_left(stamps, instant_ns)
            near.update(
                k
                for k, before in enumerate(self._missing)
                if after - NEIGHBOURS < before < after + NEIGHBOURS
            )
        if near:
            return f"{len(near)} of the states that it was made of are not in the recording"
        if world == self._unsure_world:
            return "where the feet stand was found with states that are not in the recording"
        return ""
