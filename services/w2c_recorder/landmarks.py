"""Where the index of a closed file says that its records begin: a way on behind torn bytes.

A torn length leads into the middle of a chunk, where noise reads as records of any kind and length.
They are told from the file's own by the places that the index names.
"""

from bisect import bisect_right

from mcap.records import Chunk, Footer, McapRecord, Message
from mcap.stream_reader import breakup_chunk
from mcap.summary import Summary

CHUNK_HEAD = 1 + 8 + 8 + 8 + 8 + 4 + 4 + 8
"""Of a chunk, without the name of its compression and its data [B]"""


class Landmarks:
    """The first bytes of chunks and metadata; none where a file has no index."""

    def __init__(self, summary: Summary | None) -> None:
        chunks = summary.chunk_indexes if summary else []
        self._chunks = {one.chunk_start_offset for one in chunks}
        metadata = summary.metadata_indexes if summary else []
        self._places = sorted({*self._chunks, *(one.offset for one in metadata)})

    def next_after(self, position: int) -> int | None:
        """Return the first landmark behind a byte; None where there is none."""
        place = bisect_right(self._places, position)
        return self._places[place] if place < len(self._places) else None

    def chunks_between(self, start: int, end: int) -> int:
        """Return how many chunks begin from `start` to before `end`."""
        return sum(start <= one < end for one in self._chunks)

    def first_byte(self, record: McapRecord | None, start: int, end: int) -> int:
        """Return where a record begins that was read from `start` to `end`.

        The reader passes over records of unknown kinds, and goes on to the next one that it knows.
        """
        if isinstance(record, Chunk):
            first = end - CHUNK_HEAD - len(record.compression) - len(record.data)
            if first in self._chunks:
                return first
        return start

    def check(self, record: McapRecord | None, start: int, end: int) -> None:
        """Refuse a record that was read from torn bytes.

        A chunk whose sum is right is believed before an index that says otherwise.

        Args:
            record: What was read; None for the end of the file.
            start: Its first byte.
            end: Behind its last byte.

        Raises:
            ValueError: it cannot be one of this file.
            Exception: of the decompressors, for a chunk that is none.
        """
        following = self.next_after(start)
        reaches_over = following is not None and (following < end or isinstance(record, Footer))
        if isinstance(record, Chunk):
            if reaches_over:
                breakup_chunk(record, validate_crc=True)
        elif reaches_over:
            raise ValueError(f"what stands at byte {start} reaches over byte {following}")
        elif start in self._chunks:
            raise ValueError(f"what stands at byte {start} is no chunk")
        elif isinstance(record, Message) and self._chunks:
            raise ValueError(f"the message at byte {start} is in no chunk")
