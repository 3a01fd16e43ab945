"""From the echoes of a sequence of probes to the link's figures: round trip, jitter and loss each way; pure."""

from collections.abc import Sequence
from dataclasses import dataclass
from itertools import pairwise

import numpy as np

from common.clock import NS_PER_MS
from common.messages.robot import HandLink

STALL_OF_ROUND_TRIP, LEAST_STALL_MS = 0.8, 25.0


@dataclass(frozen=True, slots=True)
class Echoed:
    """One probe that came back: its number, four times in ns, and how many probes had come.

    Sent and arrived are by our clock, received and answered by the remote site's.
    """

    seq: int
    sent_ns: int
    received_ns: int
    answered_ns: int
    arrived_ns: int
    received: int


@dataclass(frozen=True, slots=True)
class WayFigures:
    """One way: jitter in ms (RFC 3550, section 6.4.1, not smoothed), and what 1 % take longer than the quickest.

    `loss` is the fraction of probes that never came, `stalls` that of those that waited for a packet lost before
    them: a loss that TCP hides. `mbit_s` is None where it was not measured.
    """

    jitter_ms: float
    excess_p99_ms: float
    loss: float
    stalls: float
    mbit_s: float | None = None


@dataclass(frozen=True, slots=True)
class LinkFigures:
    """A link as it was measured at an endpoint: round trips, both ways; `hand` is what the cell itself measured."""

    endpoint: str
    least_ms: float
    median_ms: float
    p99_ms: float
    there: WayFigures
    back: WayFigures
    engaged: bool = False
    hand: HandLink | None = None

    @property
    def protocol(self) -> str:
        """tcp, tls or quic."""
        return self.endpoint.partition("/")[0]

    @property
    def loss(self) -> float:
        """The greater loss of both ways; of TCP by its stalls."""
        return max(self.there.loss, self.back.loss, self.there.stalls, self.back.stalls)


def round_trips_ms(echoes: Sequence[Echoed]) -> list[float]:
    """The time that each probe and its echo spent on the way, ms."""
    return [((e.arrived_ns - e.sent_ns) - (e.answered_ns - e.received_ns)) / NS_PER_MS for e in echoes]


def link_figures(endpoint: str, sent: int, echoes: Sequence[Echoed]) -> LinkFigures:
    """The figures of a sequence of `sent` probes, numbered from 0, with at least two echoes."""
    trips = np.array(round_trips_ms(echoes))
    there_ms = [(e.received_ns - e.sent_ns) / NS_PER_MS for e in echoes]
    back_ms = [(e.arrived_ns - e.answered_ns) / NS_PER_MS for e in echoes]
    come = max(e.received for e in echoes)
    median, p99 = np.percentile(trips, (50, 99)).tolist()
    least = float(trips.min())
    return LinkFigures(
        endpoint,
        least,
        median,
        p99,
        _way(there_ms, 1.0 - come / max(sent, come), least),
        _way(back_ms, 1.0 - len({e.seq for e in echoes}) / come, least),
    )


def _way(transit_ms: Sequence[float], loss: float, least_ms: float) -> WayFigures:
    """One way's figures from the times in transit by two clocks, ms: only their differences mean anything."""
    excess = np.array(transit_ms) - min(transit_ms)
    jitter = float(np.mean(np.abs(np.diff(excess))))
    return WayFigures(jitter, float(np.percentile(excess, 99)), loss, _stalls(excess.tolist(), least_ms))


def _stalls(excess_ms: Sequence[float], round_trip_ms: float) -> float:
    """The fraction of packets whose loss held up those after them, among the probes that could begin such a stall.

    TCP learns of a lost packet from the next one's receipt, sends it again, and holds back what came meanwhile.
    """
    limit = LEAST_STALL_MS + STALL_OF_ROUND_TRIP * round_trip_ms
    begun = sum(before < limit <= after for before, after in pairwise(excess_ms))
    at_risk = begun + sum(excess < limit for excess in excess_ms)
    return begun / at_risk if at_risk else 0.0
