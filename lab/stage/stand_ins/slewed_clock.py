"""A monotonic clock of this process that is slewed, as chrony slews a host's: for Python's readings of it alone."""

import time
from collections.abc import Iterator
from contextlib import contextmanager
from unittest.mock import patch


class SlewedClock:
    """Gains `rate` of the time; the kernel's CLOCK_BOOTTIME does too, and CLOCK_MONOTONIC_RAW does not."""

    def __init__(self) -> None:
        self._monotonic_ns, self._clock_ns = time.monotonic_ns, time.clock_gettime_ns
        self._rate, self._since_ns, self._gained_ns = 0.0, self._monotonic_ns(), 0.0

    def slew(self, rate: float) -> None:
        """Gain at this rate from now on, or lose where it is negative; what was gained stays."""
        now_ns = self._monotonic_ns()
        self._gained_ns += self._rate * (now_ns - self._since_ns)
        self._rate, self._since_ns = rate, now_ns

    def now_ns(self) -> int:
        """As `time.monotonic_ns`."""
        now_ns = self._monotonic_ns()
        return now_ns + round(self._gained_ns + self._rate * (now_ns - self._since_ns))

    def read_ns(self, clock: int) -> int:
        """As `time.clock_gettime_ns`."""
        read_ns = self._clock_ns(clock)
        is_slewed = clock in (time.CLOCK_MONOTONIC, time.CLOCK_BOOTTIME)
        return read_ns + self.now_ns() - self._monotonic_ns() if is_slewed else read_ns


@contextmanager
def slewed_clock() -> Iterator[SlewedClock]:
    """Have this process read such a clock, which is not slewed yet."""
    clock = SlewedClock()
    with patch.object(time, "monotonic_ns", clock.now_ns), patch.object(time, "clock_gettime_ns", clock.read_ns):
        yield clock
