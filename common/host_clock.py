"""This host's clocks: the monotonic one, which all its processes share, and steady time beside it."""

import time

from common.clock import NS_PER_S
from common.steady_time import HostTime

READINGS, QUICK_NS = 5, 20_000


class MonotonicClock:
    """CLOCK_MONOTONIC, shared by every process of a host and unaffected by wall-clock steps."""

    def now_ns(self) -> int:
        return time.monotonic_ns()

    def sleep_until_ns(self, deadline_ns: int) -> None:
        delay_ns = deadline_ns - time.monotonic_ns()
        if delay_ns > 0:
            time.sleep(delay_ns / NS_PER_S)


def host_time() -> HostTime:
    """Read this host's clocks at one instant: of a few readings a quick one, since a process may be paused in any."""
    readings = []
    for _ in range(READINGS):
        before_ns = time.monotonic_ns()
        raw_ns, boot_ns = time.clock_gettime_ns(time.CLOCK_MONOTONIC_RAW), time.clock_gettime_ns(time.CLOCK_BOOTTIME)
        after_ns = time.monotonic_ns()
        # Steady time is raw + (boot - monotonic): the raw clock's rate, and the time in suspends. It is ahead of the
        # monotonic clock by raw + boot - 2 monotonic; twice the middle of this reading is before + after.
        readings.append((after_ns - before_ns, HostTime(after_ns, raw_ns + boot_ns - before_ns - after_ns)))
        if after_ns - before_ns < QUICK_NS:
            break
    return min(readings)[1]
