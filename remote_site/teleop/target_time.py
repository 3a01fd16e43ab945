"""The time for which the target of a hand sample is taken, on our clock; pure."""

from common.clock import NS_PER_MS
from remote_site.session.samples import Accepted

MOST_PREDICTED_NS = 100 * NS_PER_MS  # of the way from exposure to arrival: a longer prediction overshoots
AGE_MEMORY = 1 / 30  # weight of the newest sample in the mean age
OFFSET_MEMORY = 1 / 300  # the same in the mean offset of the clocks
OFFSET_TRUST = 0.25  # of a measured offset's uncertainty: as far as the mean may be from it


class TargetTime:
    """Feed it every sample that is followed, in order."""

    def __init__(self) -> None:
        self._mean_age_ns: float | None = None
        self._mean_offset_ns: float | None = None

    def of(self, sample: Accepted, now_ns: int) -> int:
        """The time of the exposure, or later where a prediction from it would overshoot, ns."""
        captured_ns = self._captured_ns(sample)
        age_ns = now_ns - captured_ns
        mean_ns = age_ns if self._mean_age_ns is None else self._mean_age_ns
        self._mean_age_ns = mean_ns + AGE_MEMORY * (age_ns - mean_ns)
        return captured_ns + max(round(self._mean_age_ns) - MOST_PREDICTED_NS, 0)

    def _captured_ns(self, sample: Accepted) -> int:
        """The time of the exposure by the mean offset of the clocks.

        Where a link's delay varies, a measured offset is wrong by half of what the two ways differed: up to 20 ms at
        120 ms each way and a jitter of 20 %. With each measurement the hand would seem to jump in time.
        """
        stated_ns = sample.captured_ns - sample.sample.capture_ns
        mean_ns = stated_ns if self._mean_offset_ns is None else self._mean_offset_ns
        mean_ns += OFFSET_MEMORY * (stated_ns - mean_ns)
        trusted_ns = OFFSET_TRUST * (sample.captured_ns - sample.born_ns)
        self._mean_offset_ns = min(max(mean_ns, stated_ns - trusted_ns), stated_ns + trusted_ns)
        return sample.sample.capture_ns + round(self._mean_offset_ns)
