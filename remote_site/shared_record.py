"""Records that processes of one site share without locks: one writer, any number of readers, never torn."""

import mmap
import zlib

import numpy as np
from numpy.typing import NDArray

from common.errors import DriverError

COUNTER_BYTES = 64
READ_ATTEMPTS = 1000

Record = NDArray[np.void]


class SharedRecord:
    """One record in anonymous memory that a fork inherits, with its predecessors in the other slots.

    The writer fills a slot that no reader uses, then increments the counter; a writer killed midway leaves the last
    complete record in force. A reader accepts a slot only if the counter has not changed meanwhile and the checksum
    matches, which also holds on processors that reorder writes.
    """

    def __init__(self, dtype: np.dtype[np.void], slots: int = 2) -> None:
        self.dtype = dtype
        self._slots = slots
        self._slot_bytes = dtype.itemsize + 4
        self._memory = mmap.mmap(-1, COUNTER_BYTES + slots * self._slot_bytes)
        self._counter = memoryview(self._memory)[:8].cast("Q")
        self.write(np.zeros((), dtype=dtype))

    @property
    def count(self) -> int:
        """The number of records written so far."""
        return self._counter[0]

    def write(self, record: Record) -> None:
        """Publish a record of this dtype (0-d array); only one process may write."""
        data, count = record.tobytes(), self._counter[0] + 1
        start = self._start(count)
        self._memory[start : start + self._slot_bytes] = data + zlib.crc32(data).to_bytes(4, "little")
        self._counter[0] = count

    def read(self) -> Record:
        """A copy of the newest record (0-d array); DriverError when none is complete after READ_ATTEMPTS tries."""
        for _ in range(READ_ATTEMPTS):
            record = self._slot(self._counter[0], 0)
            if record is not None:
                return record
        raise DriverError(f"shared memory: no complete record in {READ_ATTEMPTS} tries; restart the remote site")

    def at(self, count: int) -> Record | None:
        """A copy of record number `count`, None once another has overwritten its slot."""
        return self._slot(count, self._slots - 2)

    def _slot(self, count: int, behind: int) -> Record | None:
        """The content of the slot of record `count`, if at most `behind` records have been written since."""
        start = self._start(count)
        slot = self._memory[start : start + self._slot_bytes]
        if self._counter[0] - count > behind:
            return None
        data = slot[:-4]
        if zlib.crc32(data) != int.from_bytes(slot[-4:], "little"):
            return None
        return np.frombuffer(data, dtype=self.dtype).reshape(())

    def _start(self, count: int) -> int:
        return COUNTER_BYTES + (count % self._slots) * self._slot_bytes
