"""Records that processes of one site share without locks: one writer, any number of readers, no torn reads."""

import mmap
import zlib

import numpy as np
from numpy.typing import NDArray

from common.errors import DriverError

COUNTER_BYTES = 64  # the counter (uint64) has a cache line of its own
CRC_BYTES = 4
WHOLE = zlib.crc32(bytes(CRC_BYTES))  # of no data and its checksum, 0; that of any data with its own is the same
READ_ATTEMPTS = 1000

Record = NDArray[np.void]


class SharedRecord:
    """A ring of the newest records in anonymous memory that a fork inherits: a sequence lock with checksums.

    The writer fills the oldest slot, then increments the counter: if it is killed half way, the last complete record
    stays the newest. A reader accepts a copy only if the counter shows that its slot has not been reused meanwhile,
    and if the checksum matches: on a processor that reorders writes, the counter alone proves nothing.
    """

    def __init__(self, dtype: np.dtype[np.void], slots: int = 2) -> None:
        self.dtype = dtype
        self._slots = slots
        self._slot_bytes = dtype.itemsize + CRC_BYTES
        self._memory = mmap.mmap(-1, COUNTER_BYTES + slots * self._slot_bytes)
        self._counter = memoryview(self._memory)[:8].cast("Q")
        self.write(np.zeros((), dtype=dtype))

    @property
    def count(self) -> int:
        """The number of records written so far, with the zeros that the constructor writes."""
        return self._counter[0]

    def write(self, record: Record) -> None:
        """Publish a record of this dtype (0-d array); only one process may write."""
        data, number = record.tobytes(), self._counter[0] + 1
        start = self._offset(number)
        self._memory[start : start + self._slot_bytes] = data + zlib.crc32(data).to_bytes(CRC_BYTES, "little")
        self._counter[0] = number

    def read(self) -> Record:
        """A copy of the newest record (0-d array); DriverError when none is complete after READ_ATTEMPTS tries."""
        for _ in range(READ_ATTEMPTS):
            record = self._slot(self._counter[0], 0)
            if record is not None:
                return record
        raise DriverError(f"shared memory: no complete record in {READ_ATTEMPTS} tries; restart the remote site")

    def read_number(self, number: int) -> Record | None:
        """A copy of the record with this number, the first being 1; None once its slot may be overwritten."""
        return self._slot(number, self._slots - 2)  # after one more, the writer may be filling the slot

    def _slot(self, number: int, max_newer: int) -> Record | None:
        """The record with this number if it is whole and at most `max_newer` records are newer."""
        start = self._offset(number)
        slot = self._memory[start : start + self._slot_bytes]
        if self._counter[0] - number > max_newer:
            return None
        if zlib.crc32(slot) != WHOLE:
            return None
        return np.ndarray((), self.dtype, slot)

    def _offset(self, number: int) -> int:
        return COUNTER_BYTES + (number % self._slots) * self._slot_bytes
