"""Pace at which the state is sent over a long link; pure."""

from common.clock import NS_PER_MS
from common.messages.robot import SessionState
from remote_site.reasons import Code

HEADER_BYTES = 100  # of Zenoh, QUIC, UDP and IP
LEAST_WINDOW_BYTES = 2 * 1200
UNKNOWN_MS = 120.0  # half a round trip, as long as no sample under a lease has shown it: a long way
SHARE = 0.65  # of the window; the rest is for answers, and for samples that take longer than most


class StatePace:
    """Keeps the states within what always passes, so that none waits behind others.

    Where packets get lost, the congestion control of QUIC falls back to two packets per round trip (RFC 9002, section
    7.2), of at least 1200 bytes (RFC 9000, section 14). States go before answers there: more of them would leave none
    for the clock, the description and the lease. A change of the session's state or its code, and a halt, are never
    held back.
    """

    def __init__(self) -> None:
        self._sent_ns, self._bytes = 0, 0
        self._said: tuple[SessionState, Code, int] | None = None

    def is_due(self, now_ns: int, says: tuple[SessionState, Code, int], network_ms: float | None) -> bool:
        """Return whether to send the state now, which then counts as sent.

        `says` is the session's state with its code and its newest halt, `network_ms` half a round trip, None while it
        is not known.
        """
        way_ms = UNKNOWN_MS if network_ms is None else network_ms
        period_ns = 2 * way_ms * NS_PER_MS * self._bytes / (SHARE * LEAST_WINDOW_BYTES)
        if says == self._said and now_ns - self._sent_ns < period_ns:
            return False
        self._sent_ns, self._said = now_ns, says
        return True

    def sent(self, payload_bytes: int) -> None:
        """The state that was due had this size; the next one waits as long as that takes."""
        self._bytes = payload_bytes + HEADER_BYTES
