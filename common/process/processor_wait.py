"""For how long a thread waits for a processor, as the kernel counts it: what else makes a turn late is not in it."""

import os
import weakref
from collections import deque
from pathlib import Path

from common.clock import NS_PER_MS

LATELY_NS = 500 * NS_PER_MS
QUEUED = Path("/proc/thread-self/schedstat")
MOST_BYTES = 128


class QueuedTime:
    """The time that the creating thread has waited so far; for ever 0 where the kernel does not count it."""

    def __init__(self, counts: Path = QUEUED) -> None:
        self._counts: int | None = None
        try:
            self._counts = os.open(counts, os.O_RDONLY | os.O_CLOEXEC)
        except OSError:
            return
        weakref.finalize(self, os.close, self._counts)

    def read_ns(self) -> int:
        """The total until now."""
        return 0 if self._counts is None else int(os.pread(self._counts, MOST_BYTES, 0).split()[1])


class ProcessorWait:
    """The longest that one turn of a loop has waited in the last half second."""

    def __init__(self) -> None:
        self._waits: deque[tuple[int, int]] = deque()
        self._queued_ns: int | None = None

    def turn(self, queued_ns: int, now_ns: int) -> None:
        """A turn has begun, by when the loop's thread had waited for so long in all."""
        before_ns, self._queued_ns = self._queued_ns, queued_ns
        if before_ns is not None:
            self._waits.append((now_ns, queued_ns - before_ns))
        while self._waits and self._waits[0][0] <= now_ns - LATELY_NS:
            self._waits.popleft()

    def longest_ms(self, now_ns: int) -> float:
        """The longest wait of a turn lately, ms."""
        return max((wait_ns for t_ns, wait_ns in self._waits if t_ns > now_ns - LATELY_NS), default=0) / NS_PER_MS
