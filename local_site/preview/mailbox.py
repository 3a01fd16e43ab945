"""A box in shared memory for one message at a time, from one process to another that inherits it by fork."""

import mmap
import os
import select
import weakref
from collections.abc import Sequence
from typing import Any

import numpy as np
from numpy.typing import NDArray

from common.clock import NS_PER_MS

MAX_PARTS = 8
EMPTY = 0
HEADER_BYTES = 8 * (1 + MAX_PARTS)

Part = bytes | NDArray[Any]


class Mailbox:
    """`put` never waits: while the last message has not been taken, there is no room for another.

    No `SharedRecord`: every message is read once, its size varies, and a checksum of pictures would cost milliseconds.

    Memory that is never written costs nothing, so the capacity may be generous.
    """

    def __init__(self, capacity_bytes: int) -> None:
        memory = mmap.mmap(-1, HEADER_BYTES + capacity_bytes)
        header = np.frombuffer(memory, np.int64, 1 + MAX_PARTS)
        self._count, self._sizes = header[:1], header[1:]
        self._data = np.frombuffer(memory, np.uint8, offset=HEADER_BYTES)
        self._wake_fd = os.eventfd(0, os.EFD_NONBLOCK | os.EFD_CLOEXEC)
        weakref.finalize(self, os.close, self._wake_fd)
        self._poll = select.poll()
        self._poll.register(self._wake_fd, select.POLLIN)

    @property
    def is_free(self) -> bool:
        """Return whether the last message was taken."""
        return int(self._count[0]) == EMPTY

    def put(self, parts: Sequence[Part]) -> bool:
        """Leave a message of one to eight parts; False when there is no room for it."""
        flat = [np.frombuffer(part, np.uint8) if isinstance(part, bytes) else part.reshape(-1) for part in parts]
        if not self.is_free or len(flat) > MAX_PARTS or sum(part.size for part in flat) > self._data.size:
            return False
        start = 0
        for k, part in enumerate(flat):
            self._data[start : start + part.size] = part
            self._sizes[k] = part.size
            start += part.size
        self._count[0] = len(flat)
        os.eventfd_write(self._wake_fd, 1)
        return True

    def take(self) -> list[NDArray[np.uint8]] | None:
        """Copies of the parts of the message, bytes as they were put; None when there is none."""
        if self.is_free:
            return None
        ends = np.cumsum(self._sizes[: int(self._count[0])]).tolist()
        parts = [self._data[start:end].copy() for start, end in zip([0, *ends], ends, strict=False)]
        self._count[0] = EMPTY
        return parts

    def wait(self, timeout_ns: int) -> None:
        """Wait for a message, at most this long."""
        if self._poll.poll(timeout_ns / NS_PER_MS):
            os.eventfd_read(self._wake_fd)
