"""The local site's figures for Prometheus, from the hand samples that it publishes."""

from collections.abc import Iterator

from prometheus_client import Histogram
from prometheus_client.core import CounterMetricFamily, Metric

from common.cameras.lost_pictures import LostPictures
from common.clock import NS_PER_S
from common.messages.hand import HandArm, TrackingStatus
from common.process.metrics import gauge, lost_pictures

AGE_BUCKETS_S = (0.01, 0.02, 0.03, 0.04, 0.05, 0.06, 0.08, 0.1, 0.15, 0.2, 0.3, 0.5)


class LocalFigures:
    """Counts every hand sample of this site; one thread calls `observe`, another `families`.

    `lost` is what the operator's cameras have lost.
    """

    def __init__(self, lost: LostPictures) -> None:
        self._lost = lost
        self._sample: HandArm | None = None
        self._received_ns = 0
        self._samples = dict.fromkeys(TrackingStatus, 0)
        self._age = Histogram(
            "farhand_capture_to_publish_seconds",
            "From the exposure of a hand sample to its publication, tracking included",
            registry=None,
            buckets=AGE_BUCKETS_S,
        )

    def observe(self, sample: HandArm, now_ns: int) -> None:
        """Take a sample received at this time."""
        self._samples[sample.status] += 1
        self._age.observe((now_ns - sample.capture_ns) / NS_PER_S)
        self._sample, self._received_ns = sample, now_ns

    def families(self, now_ns: int) -> Iterator[Metric]:
        """All figures at this time; before the first sample, those of the cameras only."""
        yield lost_pictures(self._lost.read())
        sample = self._sample
        if sample is None:
            return
        samples = CounterMetricFamily("farhand_hand_samples", "Hand samples published", labels=["status"])
        for status, count in self._samples.items():
            samples.add_metric([status.value], count)
        yield samples
        yield from self._age.collect()
        since_s = (now_ns - self._received_ns) / NS_PER_S
        yield gauge("farhand_hand_age_seconds", "Since the newest hand sample was published", since_s)
        toggles = sample.gripper_toggles
        yield CounterMetricFamily("farhand_gripper_toggles", "Openings of the hand that counted", value=toggles)
        yield gauge("farhand_lease_held", "1 while this site holds the lease", float(sample.lease > 0))
        if sample.clock is not None:
            uncertainty_s = sample.clock.uncertainty_ns / NS_PER_S
            yield gauge("farhand_clock_uncertainty_seconds", "Of the two hosts' clocks", uncertainty_s)
