"""How many messages did not arrive, from gaps in the senders' sequence numbers. Pure."""

from dataclasses import dataclass, field

MAX_MISSING = 10_000
"""Numbers remembered per stream, to recognise a message that comes after its successor."""


@dataclass
class _Stream:
    """What is known of one sender's messages on one key."""

    next_sequence: int
    lost: int = 0
    """Too long ago to be waited for."""
    missing: set[int] = field(default_factory=set)


class LossCounter:
    """Counts the messages of each key that a receiver never saw.

    A stream is a key and a boot id: a sender that restarts counts from zero again, and two replicas
    may write the same key. What a sender sent before its first message was seen is not counted:
    nobody can tell a loss from a late start. A number that is missing may still come, because two
    threads of one sender can overtake each other; then it is no longer counted.
    """

    def __init__(self) -> None:
        self._streams: dict[tuple[str, str], _Stream] = {}
        self.repeated = 0
        """Messages that were seen before."""

    def observe(self, key: str, boot_id: str, sequence: int) -> int:
        """Note one message. Returns how many are newly missing because of it."""
        stream = self._streams.get((key, boot_id))
        if stream is None:
            self._streams[key, boot_id] = _Stream(next_sequence=sequence + 1)
            return 0
        gap = sequence - stream.next_sequence
        if gap < 0:
            self._observe_late(stream, sequence)
            return 0
        if gap > 0:
            self._add_gap(stream, sequence)
        stream.next_sequence = sequence + 1
        return gap

    def lost(self) -> dict[str, int]:
        """Return key -> messages that did not arrive, keys without loss left out."""
        totals: dict[str, int] = {}
        for (key, _), stream in self._streams.items():
            count = stream.lost + len(stream.missing)
            if count:
                totals[key] = totals.get(key, 0) + count
        return totals

    def _observe_late(self, stream: _Stream, sequence: int) -> None:
        """Take back a number that was missed, or count a repetition."""
        if sequence in stream.missing:
            stream.missing.remove(sequence)
        else:
            self.repeated += 1

    @staticmethod
    def _add_gap(stream: _Stream, sequence: int) -> None:
        """Remember the newest missing numbers; count older ones as lost for good."""
        first = max(stream.next_sequence, sequence - MAX_MISSING)
        stream.lost += first - stream.next_sequence
        stream.missing.update(range(first, sequence))
        if len(stream.missing) > MAX_MISSING:
            # Down to half, so that a stream that keeps losing is not sorted at every message.
            surplus = len(stream.missing) - MAX_MISSING // 2
            stream.missing.difference_update(sorted(stream.missing)[:surplus])
            stream.lost += surplus
