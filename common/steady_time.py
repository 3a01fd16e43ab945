"""Steady time, which is neither slewed nor stands still in a suspend, and two hosts' offset by it; pure."""

from collections import deque
from itertools import pairwise
from typing import NamedTuple

from common.clock import NS_PER_MS, ClockEstimate, ClockOffset, OffsetEstimator, RoundTrip

APART_NS, OWN_READINGS = 10 * NS_PER_MS, 128  # longer than a sample or a picture waits


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


class OwnReadings:
    """Readings of this host's clocks in the last seconds, in their order; the first is to come before any stamp."""

    def __init__(self) -> None:
        self._readings: deque[HostTime] = deque(maxlen=OWN_READINGS)

    def note(self, reading: HostTime) -> None:
        """Keep a reading, in the place of one that came just before."""
        if len(self._readings) > 1 and reading.now_ns - self._readings[-2].now_ns < APART_NS:
            self._readings.pop()
        self._readings.append(reading)

    def least_ahead_ns(self, since_ns: int) -> int:
        """By how much steady time was ahead, at least, from a time of the monotonic clock to the newest reading.

        With the least of them a stamp of that time is never taken for younger than it is.
        """
        ordered = list(self._readings)
        during = [after for after in ordered if after.now_ns >= since_ns]
        during += [before for before, after in pairwise(ordered) if before.now_ns < since_ns <= after.now_ns]
        return min(reading.ahead_ns for reading in during or ordered[-1:])


class SteadyEstimator:
    """The other host's monotonic clock minus ours, however either of them is slewed or suspended; pure."""

    def __init__(self) -> None:
        self._offsets = OffsetEstimator()
        self._ours, self._theirs = OwnReadings(), HostTime(0, 0)

    def add(self, asked: HostTime, received_ns: int, answered: HostTime, reply: HostTime) -> RoundTrip:
        """Add a question of our time `asked` that came at `received_ns`, and was answered at `answered`, by theirs."""
        received_steady_ns = received_ns + answered.ahead_ns
        trip = RoundTrip(asked.steady_ns, received_steady_ns, answered.steady_ns, reply.steady_ns)
        if trip.possible:
            self._offsets.add(trip)
            self._theirs = answered
        self._ours.note(reply)
        return trip

    def estimate(self, now: HostTime, since_ns: int | None = None) -> ClockEstimate | None:
        """The other clock minus ours; None without a round trip in the last four seconds.

        It is that of now or, for a stamp that our clock gave at `since_ns`, the one that makes it the oldest.
        """
        self._ours.note(now)
        steady = self._offsets.estimate(now.steady_ns)
        if steady is None:
            return None
        theirs = self._theirs
        ours_ns = now.ahead_ns if since_ns is None else self._ours.least_ahead_ns(since_ns)
        offset_ns = steady.offset.offset_ns - theirs.ahead_ns + ours_ns
        return ClockEstimate(ClockOffset(offset_ns, steady.offset.uncertainty_ns), theirs.now_ns, theirs.ahead_ns)
