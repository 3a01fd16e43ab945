"""Lanes: connections beside a link's own, so that no hand sample waits for a congestion window, and few are lost.

Where packets are lost, QUIC's congestion control falls back to two packets in flight, and sends nothing before the
first of them is acknowledged: less than hand samples need over a long way. Each lane has a window of its own.
"""

from collections import deque
from collections.abc import Sequence

import zenoh

LANES = 4  # with two copies of 30 samples a second of 210 bytes: within 1200 in flight over 380 ms of round trip
COPIES = 2  # each on a lane of its own
REMEMBERED = 64  # messages, two seconds of samples: longer than a lane has to wait


class LanePublisher:
    """One key's publishers, one for each lane; each message goes on the next ones in turn."""

    def __init__(self, publishers: Sequence[zenoh.Publisher]) -> None:
        self._publishers, self._next = publishers, 0

    def put(self, payload: bytes) -> None:
        """Send copies of a message."""
        for _ in range(COPIES):
            self._publishers[self._next].put(payload)
            self._next = (self._next + 1) % len(self._publishers)


class Copies:
    """Tells which messages have come before, byte for byte."""

    def __init__(self) -> None:
        self._known: deque[bytes] = deque(maxlen=REMEMBERED)

    def is_copy(self, payload: bytes) -> bool:
        """Whether this one has come lately; it counts as come now."""
        if payload in self._known:
            return True
        self._known.append(payload)
        return False
