"""Steady time, which is neither slewed nor stands still in a suspend, and the offset of two hosts' clocks by it."""

import time
from collections import deque
from collections.abc import Iterable
from itertools import pairwise
from typing import NamedTuple

from common.clock import ClockEstimate, ClockOffset, OffsetEstimator, RoundTrip

READINGS, QUICK_NS = 5, 20_000
MOST_SLEW = 12  # a clock is slewed by at most one nanosecond in so many: chrony does up to 8.3 %
OWN_READINGS = 64  # a second or two, longer than a sample waits
THEIR_READINGS = 6  # a second of answers


class HostTime(NamedTuple):
    """One reading of a host's clocks, ns: the monotonic one, and by how much steady time is ahead of it.

    Steady time has the hardware's own rate (CLOCK_MONOTONIC_RAW) and goes on in a suspend (CLOCK_BOOTTIME). All stamps
    are by the monotonic clock, which is slewed while the wall clock is corrected, and stands still in a suspend.
    """

    now_ns: int
    ahead_ns: int

    @property
    def steady_ns(self) -> int:
        """The steady time of this reading."""
        return self.now_ns + self.ahead_ns


def host_time() -> HostTime:
    """This host's clocks at one instant: of a few readings a quick one, since a process may be paused within any."""
    readings = []
    for _ in range(READINGS):
        before_ns = time.monotonic_ns()
        raw_ns, boot_ns = time.clock_gettime_ns(time.CLOCK_MONOTONIC_RAW), time.clock_gettime_ns(time.CLOCK_BOOTTIME)
        after_ns = time.monotonic_ns()
        readings.append((after_ns - before_ns, HostTime(after_ns, raw_ns + boot_ns - before_ns - after_ns)))
        if after_ns - before_ns < QUICK_NS:
            break
    return min(readings)[1]


def least_ahead_ns(readings: Iterable[HostTime], since_ns: int) -> int:
    """By how much steady time was ahead, at least, from a time of the monotonic clock to the newest of the readings.

    With the least of them a stamp of that time is never taken for younger than it is.
    """
    ordered = list(readings)
    during = [after for after in ordered if after.now_ns >= since_ns]
    during += [before for before, after in pairwise(ordered) if before.now_ns < since_ns <= after.now_ns]
    return min(reading.ahead_ns for reading in during or ordered[-1:])


class SteadyEstimator:
    """The other host's monotonic clock minus ours, however either of them is slewed or suspended; pure."""

    def __init__(self) -> None:
        self._offsets = OffsetEstimator()
        self._ours: deque[HostTime] = deque(maxlen=OWN_READINGS)
        self._theirs: deque[HostTime] = deque(maxlen=THEIR_READINGS)
        self._asked_ns = 0

    def add(self, asked: HostTime, received_ns: int, answered: HostTime, reply: HostTime) -> RoundTrip:
        """Add a question of our time `asked` that came at `received_ns`, and was answered at `answered`, by theirs."""
        received_steady_ns = received_ns + answered.ahead_ns
        trip = RoundTrip(asked.steady_ns, received_steady_ns, answered.steady_ns, reply.steady_ns)
        if trip.possible:
            self._offsets.add(trip)
            self._theirs.append(answered)
            self._asked_ns = asked.steady_ns
        self._ours.append(reply)
        return trip

    def estimate(self, now: HostTime, since_ns: int | None = None) -> ClockEstimate | None:
        """The other clock minus ours; None without a round trip in the last four seconds.

        It is that of now or, for a stamp that our clock gave at `since_ns`, the one that makes it the oldest.
        """
        self._ours.append(now)
        steady = self._offsets.estimate(now.steady_ns)
        if steady is None:
            return None
        theirs = self._theirs[-1]
        ours_ns = now.ahead_ns if since_ns is None else least_ahead_ns(self._ours, since_ns)
        offset_ns = steady.offset.offset_ns - theirs.ahead_ns + ours_ns
        offset = ClockOffset(offset_ns, steady.offset.uncertainty_ns)
        return ClockEstimate(offset, theirs.now_ns, theirs.ahead_ns, self._unseen_ns(now))

    def _unseen_ns(self, now: HostTime) -> int:
        """What the other clock may have been slewed by between a stamp of the last second and now."""
        seen = [theirs.ahead_ns for theirs in self._theirs]
        return max(seen) - min(seen) + (now.steady_ns - self._asked_ns) // MOST_SLEW + 1
