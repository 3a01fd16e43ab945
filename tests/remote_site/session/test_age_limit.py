"""The age limit follows the link: as short as it may be, never beyond 400 ms, and never grown under a fast arm."""

from collections.abc import Iterable
from typing import Any

import pytest

from common.clock import NS_PER_MS
from common.messages.hand import TrackingStatus
from remote_site.reasons import Code
from remote_site.safety.config import SafetyConfig
from remote_site.session.age_limit import AgeLimit, AgeLimitChoice
from remote_site.session.link_ages import LinkAges
from tests.remote_site.remote_loop import hand

PERIOD_MS = 33
AT_REST, FAST = 0.0, 1.0


class Link:
    """Samples that arrive at an age limit over a link, numbered and timed."""

    def __init__(self, **safety: Any) -> None:
        self.choice = AgeLimitChoice(SafetyConfig(**safety))
        self.seq, self.now_ms = 0, 1_000_000.0

    def bring(self, ages_ms: Iterable[float | None], pace: float = AT_REST, session: int = 7, **changes: Any) -> "Link":
        """One sample per period; its age at arrival in ms, None where it is lost."""
        for age_ms in ages_ms:
            self.seq += 1
            self.now_ms += PERIOD_MS
            if age_ms is not None:
                capture_ns, arrival_ns = self.ns(self.now_ms), self.ns(self.now_ms + age_ms)
                self.choice.see(hand(self.seq, capture_ns, session=session, **changes), capture_ns, arrival_ns)
            self.choice.settle(pace)
        return self

    @staticmethod
    def ns(milliseconds: float) -> int:
        return round(milliseconds * NS_PER_MS)

    @property
    def limit(self) -> AgeLimit:
        """The limit in force."""
        return self.choice.limit

    @property
    def ms(self) -> float:
        """Its age in ms."""
        return self.limit.soft_ns / NS_PER_MS


def test_on_a_near_link_it_is_100_ms_and_the_speed_is_full() -> None:
    link = Link().bring([15.0, 25.0] * 100)
    assert (link.ms, link.limit.speed_scale, link.limit.stretch) == (100, 1.0, 1.0)


@pytest.mark.parametrize(("age_ms", "limit_ms"), [(40, 100), (62, 100), (63, 125), (150, 200), (260, 300), (360, 400)])
def test_it_covers_the_age_that_samples_reach_before_the_next_one_comes(age_ms: float, limit_ms: float) -> None:
    link = Link().bring([age_ms] * 60)
    assert link.ms == limit_ms
    assert link.limit.speed_scale == 100 / limit_ms


def test_how_long_a_tracker_takes_while_it_learns_the_arm_slows_no_arm_afterwards() -> None:
    link = Link().bring([165.0] * 12, status=TrackingStatus.INITIALISING).bring([20.0])
    assert (link.ms, link.limit.speed_scale, link.limit.too_slow) == (100, 1.0, None)
    assert Link().bring([165.0] * 12).bring([20.0]).ms > 100


def test_it_never_exceeds_400_ms() -> None:
    assert Link().bring([390.0] * 60).ms == 400


@pytest.mark.parametrize(("age_ms", "limit_ms"), [(500, 400), (501, 100)])
def test_only_an_age_beyond_the_latch_time_is_an_outage(age_ms: float, limit_ms: float) -> None:
    assert Link(t_latch_ms=500).bring([age_ms] * 60).ms == limit_ms


def test_a_short_latch_keeps_it_shorter_still() -> None:
    assert Link(t_latch_ms=300).bring([250.0] * 60).ms == 240


def test_where_samples_are_lost_one_more_may_be_lost_in_a_row() -> None:
    steady = Link().bring([150.0] * 300)
    lossy = Link().bring(([150.0] * 9 + [None]) * 30)
    assert steady.ms == 200
    assert lossy.ms == 275  # 150 + 2 periods until the sample after a lost one + 1 period + the spare


def test_one_late_sample_in_half_a_minute_is_no_property_of_the_link_but_two_are() -> None:
    link = Link().bring([30.0] * 100 + [250.0] + [30.0] * 100)
    assert link.ms == 100
    assert link.bring([250.0]).ms == 300


def test_it_shrinks_by_itself_once_the_link_has_been_better_for_half_a_minute() -> None:
    link = Link().bring([250.0] * 30)
    assert link.bring([30.0] * 800).ms == 300
    assert link.bring([30.0] * 200).ms == 100


def test_it_does_not_grow_under_an_arm_that_is_too_fast_for_it_which_is_slowed_first() -> None:
    link = Link().bring([30.0] * 60).bring([160.0] * 60, pace=FAST)
    assert link.ms == 100
    assert link.limit.speed_scale == 0.5
    link.choice.settle(0.51)
    assert link.ms == 100
    link.choice.settle(0.5)
    assert link.ms == 200


def test_a_gap_of_the_latch_time_and_the_backlog_after_it_are_an_outage_and_no_property_of_the_link() -> None:
    link = Link().bring([30.0] * 60 + [None] * 60)
    assert link.bring([900.0, 700.0, 550.0] + [30.0] * 60).ms == 100


def test_slow_cameras_are_no_reason_to_obey_older_samples() -> None:
    slow = Link()
    for _ in range(60):
        slow.now_ms += 250
        slow.bring([30.0])
    assert slow.ms == 100


def test_samples_that_were_overtaken_or_doubled_say_nothing() -> None:
    link = Link().bring([30.0] * 60)
    old = hand(link.seq - 3, link.ns(link.now_ms - 3 * PERIOD_MS))
    for _ in range(30):
        link.choice.see(old, old.capture_ns, link.ns(link.now_ms + 300))
    assert link.bring([30.0]).ms == 100


def test_another_local_site_is_measured_from_the_beginning() -> None:
    link = Link().bring([250.0] * 60)
    assert link.bring([30.0] * 3, session=8).ms == 100


@pytest.mark.parametrize("fixed_ms", [50.0, 100.0, 250.0])
def test_a_limit_that_was_set_stays_whatever_the_link_does(fixed_ms: float) -> None:
    link = Link(t_soft_ms=fixed_ms).bring([10.0] * 60 + [390.0] * 60)
    assert link.ms == fixed_ms
    assert link.limit.too_slow is None


def test_a_link_that_takes_too_long_is_refused_with_both_figures() -> None:
    link = Link().bring([420.0] * 30)
    refusal = link.limit.too_slow
    assert refusal is not None
    assert refusal.code is Code.LINK_TOO_SLOW
    assert refusal.sentence == "the link takes 420 ms, which is too slow: at most 367 ms can be operated"
    assert link.bring([360.0] * 30).limit.too_slow is None


def test_after_an_outage_only_the_samples_since_tell_how_slow_the_link_is_now() -> None:
    link = Link().bring([30.0] * 60 + [None] * 60).bring([440.0] * 10)
    assert link.limit.too_slow is None  # nine intervals: not known yet, nor are they enough to engage
    refusal = link.bring([440.0]).limit.too_slow
    assert refusal is not None
    assert refusal.code is Code.LINK_TOO_SLOW


def test_a_few_late_samples_refuse_nothing() -> None:
    assert Link().bring(([30.0] * 3 + [450.0]) * 30).limit.too_slow is None


def spaced(period_ms: float, count: int, age_ms: float = 60.0, **safety: Any) -> Link:
    """Samples of cameras this far apart."""
    link = Link(**safety)
    for _ in range(count):
        link.now_ms += period_ms - PERIOD_MS
        link.bring([age_ms])
    return link


@pytest.mark.parametrize("safety", [{}, {"t_soft_ms": 125.0}])
def test_cameras_slower_than_the_limit_are_named_with_the_rate_and_the_limit(safety: dict[str, Any]) -> None:
    refusal = spaced(140, 40, **safety).limit.too_slow
    assert refusal is not None
    assert refusal.code is Code.SAMPLES_RARE
    assert refusal.sentence.startswith("a hand sample comes only each 140 ms, but is obeyed for 125 ms at most. Cure:")
    assert "more pictures a second" in refusal.sentence


@pytest.mark.parametrize(("period_ms", "rare"), [(124, False), (125, True)])
def test_a_sample_that_comes_as_rarely_as_one_is_obeyed_is_too_rare(period_ms: float, rare: bool) -> None:
    assert (spaced(period_ms, 40, t_soft_ms=125.0).limit.too_slow is not None) is rare


def test_of_a_link_that_has_brought_nothing_nothing_is_known() -> None:
    ages = LinkAges(500 * NS_PER_MS)
    assert (ages.usual_ns(), ages.spacing_ns(), ages.needed_ns(0)) == ((0, 0), 0, 0)


def test_a_longer_limit_serves_slower_cameras_and_lost_samples_are_none_of_theirs() -> None:
    assert spaced(140, 40, t_soft_ms=250.0).limit.too_slow is None
    assert spaced(140, 10).limit.too_slow is None  # nine intervals: not known yet
    assert Link().bring([30.0] * 20 + [None] * 8 + [30.0]).limit.too_slow is None
    assert spaced(140, 40).bring([30.0] * 9).limit.too_slow is None
