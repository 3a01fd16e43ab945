"""Lanes: connections beside a link's own, so that no hand sample waits for a congestion window, and few are lost.

Where packets are lost, QUIC's congestion control falls back to two packets in flight, and sends none while the first is
not acknowledged: less than hand samples need over a long way. Each lane has a window of its own, and the first copy
of a sample that comes by any of them counts.

A lost packet also holds up what the link's own connection carries for two or three samples. With one copy of each in
lanes, 5 % of lost packets took two samples running about every four minutes, which holds the arm; so there are two.
"""

from collections import deque
from collections.abc import Sequence

import zenoh

# So fifteen samples a second of 210 bytes in a lane stay below 1200 in flight over 0.35 s. A listener takes connections
# one by one: each lane more is one more whose lost packet keeps the link's own waiting.
LANES, COPIES = 4, 2
REMEMBERED = 64  # messages, two seconds of samples: longer than one waits for a window


class LanePublisher:
    """One key's publishers, one for each lane; so many as send a copy take turns."""

    def __init__(self, publishers: Sequence[zenoh.Publisher]) -> None:
        self._publishers, self._next = publishers, 0

    def put(self, payload: bytes) -> None:
        """Send the copies of a message, on lanes of their own."""
        for _ in range(COPIES):
            self._publishers[self._next].put(payload)
            self._next = (self._next + 1) % len(self._publishers)


class Copies:
    """Tells which messages have come before, byte for byte."""

    def __init__(self) -> None:
        self._known: deque[bytes] = deque(maxlen=REMEMBERED)

    def is_copy(self, payload: bytes) -> bool:
        """Return whether this payload came lately, and remember it."""
        if payload in self._known:
            return True
        self._known.append(payload)
        return False
