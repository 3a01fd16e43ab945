"""Judges whether a driver's time stamps are exposures on this host's monotonic clock; pure."""

from common.clock import NS_PER_MS

FRAMES_TO_TRUST = 5
OLDEST_NS = 500 * NS_PER_MS  # a few buffers of a slow camera; another clock is hours or decades away


class DriverStamps:
    """Trusts the stamps after FRAMES_TO_TRUST good ones in a row, and never again after a bad one.

    A stamp is good if it is later than the last, not later than the frame's arrival, and at most half a second
    older than it. Times are ns on this host's monotonic clock.
    """

    def __init__(self) -> None:
        self._last_ns = 0
        self._good = 0
        self._broken = False

    @property
    def trusted(self) -> bool:
        """Whether frames may take their capture time from the driver."""
        return self._good >= FRAMES_TO_TRUST and not self._broken

    @property
    def undecided(self) -> bool:
        """Whether more frames are needed to judge."""
        return self._good < FRAMES_TO_TRUST and not self._broken

    def add(self, stamp_ns: int, arrival_ns: int) -> None:
        """Take the stamp of the next frame, and when the frame arrived."""
        if self._last_ns < stamp_ns <= arrival_ns and arrival_ns - stamp_ns <= OLDEST_NS:
            self._good += 1
        else:
            self._broken = True
        self._last_ns = stamp_ns
