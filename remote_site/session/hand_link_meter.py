"""Measures the way of the hand samples over the last seconds: the age at arrival and its parts, jitter, loss; pure."""

import statistics
from collections import deque
from dataclasses import dataclass
from itertools import pairwise
from typing import NamedTuple

from common.clock import NS_PER_MS, NS_PER_S, ClockOffset
from common.messages.hand import HandArm, TrackingStatus
from common.messages.robot import HandLink

WINDOW_NS = 5 * NS_PER_S
MEASURED_EVERY_NS = 200 * NS_PER_MS
LEAST_ARRIVALS, MOST_ARRIVALS = 10, 1024  # at 120 Hz 600 come in the window; more would be work for control
EXCEEDED_BY = 0.05  # of the samples: the age that is reported


@dataclass(frozen=True, slots=True)
class SampleAge:
    """The parts of a sample's greatest possible age, ns: capture to sending, on the way, the offset's uncertainty."""

    tracking_ns: int
    network_ns: int
    clock_ns: int

    @classmethod
    def of(cls, sample: HandArm, offset: ClockOffset, now_ns: int) -> "SampleAge":
        """The age now; what a sender that does not tell when it sent took for tracking counts as network.

        While the arm is still being learned nothing can be followed, and tracking takes longer: then it counts as none.
        """
        sent_ns = sample.capture_ns if sample.sent_ns is None else max(sample.sent_ns, sample.capture_ns)
        age_ns = offset.age_ns(sample.capture_ns, now_ns)
        tracking_ns = sent_ns - sample.capture_ns
        counted_ns = 0 if sample.status is TrackingStatus.INITIALISING else tracking_ns
        return cls(counted_ns, age_ns - tracking_ns - offset.uncertainty_ns, offset.uncertainty_ns)

    @property
    def total_ns(self) -> int:
        """The sum of the parts, by which a sample is judged."""
        return self.tracking_ns + self.network_ns + self.clock_ns


class MeteredSample(NamedTuple):
    """One sample that arrived: when, its number, its time in transit by the two clocks' difference, its age.

    It is `superseded` where it, or a later one, had come before: then nothing waits for it, and it counts as no loss
    but tells nothing about the time that the link takes.
    """

    arrived_ns: int
    seq: int
    transit_ns: int
    age: SampleAge | None
    superseded: bool


class HandLinkMeter:
    """Fed with every sample under the lease in force as it arrives, also with those that are too old to be followed.

    `network_ms` is half a round trip as most samples show it, None while that is not known.
    """

    def __init__(self) -> None:
        self.network_ms: float | None = None
        self._session: int | None = None
        self._newest_ns = -1
        self._arrivals: deque[MeteredSample] = deque(maxlen=MOST_ARRIVALS)
        self._measured: HandLink | None = None
        self._measured_ns: int | None = None

    def arrive(self, sample: HandArm, offset: ClockOffset | None, now_ns: int) -> None:
        """A sample has come; `offset` is the local clock minus ours, None while it cannot be used."""
        if sample.session != self._session:
            self._session, self._measured_ns, self._newest_ns = sample.session, None, -1
            self._arrivals.clear()
        age = SampleAge.of(sample, offset, now_ns) if offset is not None else None
        sent_ns = sample.capture_ns if sample.sent_ns is None else sample.sent_ns
        superseded = sample.capture_ns <= self._newest_ns
        self._arrivals.append(MeteredSample(now_ns, sample.seq, now_ns - sent_ns, age, superseded))
        self._newest_ns = max(self._newest_ns, sample.capture_ns)

    def figures(self, now_ns: int) -> HandLink | None:
        """The figures of the last seconds, measured five times a second; None before LEAST_ARRIVALS samples."""
        if self._measured_ns is None or now_ns - self._measured_ns >= MEASURED_EVERY_NS:
            self._forget(now_ns)
            in_order = [arrival for arrival in self._arrivals if not arrival.superseded]
            self._measured, self._measured_ns = _measure(in_order, [each.seq for each in self._arrivals]), now_ns
            networks_ns = [age.network_ns for age in _ages(in_order)]
            self.network_ms = statistics.median(networks_ns) / NS_PER_MS if networks_ns else None
        return self._measured

    def _forget(self, now_ns: int) -> None:
        while self._arrivals and now_ns - self._arrivals[0].arrived_ns > WINDOW_NS:
            self._arrivals.popleft()


def _ages(arrivals: list[MeteredSample]) -> list[SampleAge]:
    return [arrival.age for arrival in arrivals if arrival.age is not None]


def _measure(arrivals: list[MeteredSample], seqs: list[int]) -> HandLink | None:
    if len(arrivals) < LEAST_ARRIVALS:
        return None
    age = _reported(arrivals)
    jitter_ns = statistics.fmean(abs(b.transit_ns - a.transit_ns) for a, b in pairwise(arrivals))
    interval_ns = statistics.median(b.arrived_ns - a.arrived_ns for a, b in pairwise(arrivals))
    return HandLink(
        age_ms=age.total_ns / NS_PER_MS if age is not None else None,
        network_ms=age.network_ns / NS_PER_MS if age is not None else None,
        clock_ms=age.clock_ns / NS_PER_MS if age is not None else None,
        tracking_ms=age.tracking_ns / NS_PER_MS if age is not None else None,
        interval_ms=interval_ns / NS_PER_MS,
        jitter_ms=jitter_ns / NS_PER_MS,
        loss=_loss(seqs, arrivals[-1].seq),
    )


def _reported(arrivals: list[MeteredSample]) -> SampleAge | None:
    """The age of which EXCEEDED_BY are older; None while those that came last have none."""
    if arrivals[-1].age is None:
        return None
    ages = sorted(_ages(arrivals), key=lambda age: age.total_ns)
    return ages[int(len(ages) * (1.0 - EXCEEDED_BY))]


def _loss(seqs: list[int], newest: int) -> float:
    """The fraction of numbers up to the newest that never came; reordered and doubled ones are none.

    Counted from the window's first arrival: what was overtaken by it belongs to the window before. A greater number
    than that of the newest capture is a damaged one.
    """
    come = {seq for seq in seqs if seqs[0] <= seq <= newest}
    return 1.0 - len(come) / max(newest - seqs[0] + 1, 1)
