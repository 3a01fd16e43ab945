"""A ring of records of any length in shared memory: one writer that never waits, readers that count what they lost."""

import zlib
from typing import NamedTuple

HEADER_BYTES = 64  # three counters of 64 bits in a cache line of their own
RECORD_HEADER_BYTES = 16
RESERVED, HEAD, NUMBER = range(3)
LARGEST_FRACTION = 4  # a record takes at most this part of the ring
FILLER = 0xFFFFFFFF
COUNTER = 2**64 - 1  # a counter's bits: whoever shares the memory may have written anything there
STANDING_ATTEMPTS = 1000
STEPS_PER_LOOK = 16  # to the next record: an end that is filled, and places that are overwritten meanwhile


class SharedRing:
    """The writer's side: it overwrites the oldest records, and is done in the time of two copies.

    The bytes are reserved before they are written and published afterwards: a reader that finds its record reserved
    again knows that it was overwritten, and a writer that is killed half way has published nothing. A checksum proves
    each record, on processors that reorder writes too.
    """

    def __init__(self, memory: memoryview) -> None:
        """Use this memory: zeros for a new ring, or a ring that another process writes; its size a multiple of 8."""
        self.size = len(memory) - HEADER_BYTES
        self._words = memory[:HEADER_BYTES].cast("Q")
        self._bytes = memory[HEADER_BYTES:]

    @property
    def count(self) -> int:
        """The number of records written, with those that were too large."""
        return self._words[NUMBER]

    def write(self, data: bytes) -> bool:
        """Append a record; False for one that takes more than a quarter of the ring: it counts as lost."""
        number = self._words[NUMBER]
        needed = RECORD_HEADER_BYTES + _padded(len(data))
        if needed > self.size // LARGEST_FRACTION:
            self._words[NUMBER] = number + 1 & COUNTER
            return False
        head = self._words[HEAD]
        at = head % self.size
        start = head if at + needed <= self.size else head + self.size - at
        self._words[RESERVED] = start + needed & COUNTER
        if start != head and self.size - at >= RECORD_HEADER_BYTES:
            self._bytes[at : at + RECORD_HEADER_BYTES] = _header(FILLER, 0, 0)
        at = start % self.size
        header = _header(len(data), zlib.crc32(data), number)
        self._bytes[at : at + RECORD_HEADER_BYTES + len(data)] = header + data
        self._words[NUMBER] = number + 1 & COUNTER
        self._words[HEAD] = start + needed & COUNTER
        return True

    @property
    def head(self) -> int:
        """The place where the next record begins, in bytes since the ring's beginning."""
        return self._words[HEAD]

    def standing(self) -> tuple[int, int]:
        """Return where the next record begins and its number, as they belong together."""
        for _ in range(STANDING_ATTEMPTS):
            reserved, number, head = self._words[RESERVED], self._words[NUMBER], self._words[HEAD]
            if reserved == head == self._words[RESERVED]:
                break
        return head, number

    def record_at(self, position: int) -> "RingRecord | None":
        """A copy of the record that begins there; None for one that was overwritten, or is being."""
        at = position % self.size
        if self.size - at < RECORD_HEADER_BYTES:
            return RingRecord(None, 0, position + self.size - at)
        header = bytes(self._bytes[at : at + RECORD_HEADER_BYTES])
        length, crc, number = (int.from_bytes(header[a:b], "little") for a, b in ((0, 4), (4, 8), (8, 16)))
        data = b"" if length == FILLER else bytes(self._bytes[at + RECORD_HEADER_BYTES :][:length])
        if self._words[RESERVED] - position > self.size:
            return None
        if length == FILLER:
            return RingRecord(None, 0, position + self.size - at)
        whole = len(data) == length and zlib.crc32(data) == crc
        return RingRecord(data, number, position + RECORD_HEADER_BYTES + _padded(length)) if whole else None


class RingRecord(NamedTuple):
    """A record with its number, and where the next one begins; without data it only fills the ring's end."""

    data: bytes | None
    number: int
    next: int


class RingReader:
    """Takes each record of a ring once; `lost` counts what was overwritten.

    It begins with the records written after it was made, or with all since the ring's beginning (`from_first`).
    """

    def __init__(self, ring: SharedRing, *, from_first: bool = False) -> None:
        self._ring = ring
        self._position, self._number = (0, 0) if from_first else ring.standing()
        self.lost = 0

    def take(self) -> bytes | None:
        """The oldest record that was not taken yet, None without one, or where the ring is damaged."""
        for _ in range(STEPS_PER_LOOK):
            if self._position >= self._ring.head:
                return None
            record = self._ring.record_at(self._position)
            if record is None:
                self._catch_up()
                continue
            self._position = record.next
            if record.data is not None:
                self.lost += record.number - self._number
                self._number = record.number + 1
                return record.data
        return None

    def _catch_up(self) -> None:
        """Go on with the next record: so far behind, all before it is about to be overwritten, too."""
        self._position, number = self._ring.standing()
        self.lost += number - self._number
        self._number = number


def _header(length: int, crc: int, number: int) -> bytes:
    return length.to_bytes(4, "little") + crc.to_bytes(4, "little") + number.to_bytes(8, "little")


def _padded(length: int) -> int:
    return (length + 7) & ~7
