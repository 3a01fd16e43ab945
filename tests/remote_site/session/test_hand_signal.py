"""The hand signal: good samples in a row, their age against both limits, and what was wrong with the newest."""

import pytest

from common.clock import NS_PER_MS, NS_PER_S
from remote_site.reasons import Code, reason
from remote_site.safety.config import SafetyConfig
from remote_site.session.age_limit import AgeLimitChoice
from remote_site.session.hand_signal import AGAIN_FRAMES, HandSignal
from remote_site.session.samples import Rejected
from tests.remote_site.session.session_rig import JUMPS, LOST, NO_OFFSET, OLD_OFFSET, PERIOD, good

SOFT, LATCH = 100 * NS_PER_MS, 500 * NS_PER_MS
FRAMES = 30
BORN = 10_000 * NS_PER_MS
FUTURE = Rejected(reason(Code.FUTURE, ahead_ms=20))
TWICE = Rejected(reason(Code.DUPLICATE, seq=3))
STALE = Rejected(reason(Code.STALE, age_ms=130, limit_ms=100))
OLD = Rejected(reason(Code.OLD, seq=3, newest=4))


def signal(count=3):
    """A signal whose last of `count` good samples was born at `BORN`."""
    safety = SafetyConfig(t_soft_ms=100.0, t_latch_ms=500.0)
    hand = HandSignal(safety, AgeLimitChoice(safety).limit, FRAMES)
    for k in reversed(range(count)):
        hand.observe(good(BORN - k * SOFT))
    return hand


def code(why):
    return why.code if why is not None else None


def test_samples_count_in_a_row_up_to_a_gap_beyond_the_soft_limit():
    hand = signal(3)
    assert hand.good == 3
    hand.observe(good(BORN + SOFT))
    assert hand.good == 4
    hand.observe(good(BORN + 2 * SOFT + 1))
    assert hand.good == 1


def test_collecting_names_what_is_missing_until_enough_came():
    hand = signal(3)
    assert hand.collecting(4) == reason(Code.COLLECTING, count=3, needed=4)
    assert hand.collecting(3) is None


@pytest.mark.parametrize("repeat", [TWICE, OLD])
def test_a_repeat_says_nothing_about_the_hand(repeat):
    hand = signal(3)
    hand.observe(repeat)
    assert (hand.good, hand.unfit(BORN)) == (3, None)
    hand.observe(LOST)
    hand.observe(repeat)
    assert hand.unfit(BORN) is LOST.reason


@pytest.mark.parametrize("trouble", [LOST, NO_OFFSET, OLD_OFFSET, FUTURE])
def test_a_lost_hand_or_an_unknown_age_is_trouble_until_the_next_good_sample(trouble):
    hand = signal(3)
    hand.observe(trouble)
    assert (hand.good, hand.unfit(BORN)) == (0, trouble.reason)
    hand.observe(good(BORN + SOFT))
    assert (hand.good, hand.unfit(BORN + SOFT)) == (1, None)


def test_a_jump_counts_from_nothing_but_the_sample_before_it_may_still_be_followed():
    hand = signal(3)
    hand.observe(JUMPS)
    assert (hand.good, hand.unfit(BORN)) == (0, None)


def test_a_sample_is_unfit_beyond_the_soft_limit_and_too_old_beyond_the_latch_limit():
    hand = signal()
    assert hand.unfit(BORN + SOFT) is None
    assert hand.unfit(BORN + SOFT + 1) == reason(Code.STALE, age_ms=100, limit_ms=100)
    assert hand.too_old(BORN + LATCH) is None
    assert hand.too_old(BORN + LATCH + 1) == reason(Code.STALE, age_ms=500, limit_ms=500)


def test_what_was_wrong_is_why_it_is_too_old_but_ends_nothing_before():
    hand = signal()
    hand.observe(LOST)
    assert hand.too_old(BORN + LATCH) is None
    assert hand.too_old(BORN + LATCH + 1) is LOST.reason


def test_without_any_sample_there_is_no_hand():
    hand = signal(0)
    assert code(hand.unfit(BORN)) is Code.NO_HAND
    assert code(hand.too_old(BORN)) is Code.STALE


def test_a_restart_forgets_the_samples_and_a_new_lease_what_was_wrong_too():
    hand = signal(3)
    hand.observe(LOST)
    hand.restart()
    assert (hand.good, code(hand.unfit(BORN)), hand.too_old(BORN)) == (0, Code.LOST, LOST.reason)
    hand.forget()
    assert code(hand.unfit(BORN)) is Code.NO_HAND
    restarted = signal(3)
    restarted.restart()
    assert (restarted.good, code(restarted.unfit(BORN))) == (0, Code.NO_HAND)


def after(hand, gap_ns, count):
    """Good samples, a period apart, after a gap."""
    begin_ns = BORN + gap_ns
    for k in range(count):
        hand.observe(good(begin_ns + k * PERIOD))


@pytest.mark.parametrize("between", [(), (STALE,), (TWICE,)], ids=["silence", "late", "doubled"])
def test_after_a_cut_fewer_samples_are_enough_where_there_were_enough_before(between):
    hand = signal(FRAMES)
    for rejected in between:
        hand.observe(rejected)
    after(hand, 10 * NS_PER_S, AGAIN_FRAMES - 1)
    assert hand.collecting(hand.frames) == reason(Code.COLLECTING, count=AGAIN_FRAMES - 1, needed=AGAIN_FRAMES)
    hand.observe(good(BORN + 10 * NS_PER_S + AGAIN_FRAMES * PERIOD))
    assert hand.collecting(hand.frames) is None


@pytest.mark.parametrize("between", [LOST, NO_OFFSET, JUMPS], ids=lambda what: str(what.reason.code))
def test_after_anything_else_than_late_samples_all_are_needed_again(between):
    hand = signal(FRAMES)
    hand.observe(between)
    after(hand, NS_PER_S, AGAIN_FRAMES)
    assert hand.frames == FRAMES


@pytest.mark.parametrize("forget", [HandSignal.restart, HandSignal.distrust])
def test_for_another_session_holder_or_page_all_are_needed_again(forget):
    hand = signal(FRAMES)
    forget(hand)
    after(hand, NS_PER_S, AGAIN_FRAMES)
    assert hand.frames == FRAMES


def test_what_was_seen_more_than_half_a_minute_ago_proves_nothing():
    hand = signal(FRAMES)
    after(hand, 31 * NS_PER_S, AGAIN_FRAMES)
    assert hand.frames == FRAMES


def test_a_hand_that_was_never_seen_for_long_enough_needs_all():
    hand = signal(FRAMES - 1)
    after(hand, NS_PER_S, AGAIN_FRAMES)
    assert hand.frames == FRAMES
