"""The samples of a run in one sentence: how many, how many tracked, and the oldest of these."""

from common.clock import NS_PER_MS
from common.messages.hand import TrackingStatus
from local_site.runtime.loop import SampleTally


def test_a_sample_without_a_hand_counts_as_sent_and_says_nothing_of_ages():
    tally = SampleTally()
    for status, age_ms in (("tracked", 20), ("degraded", 45), ("initialising", 300), ("lost", 900)):
        tally.note(TrackingStatus(status), age_ms * NS_PER_MS)
    assert str(tally) == "4 sent, 50% tracked, the oldest 45 ms from exposure to sending"


def test_a_run_without_samples_divides_by_nothing():
    assert str(SampleTally()).startswith("0 sent, none tracked")
