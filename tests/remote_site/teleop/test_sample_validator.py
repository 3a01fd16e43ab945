"""The sample validator: what is late, duplicated, reordered or wild is refused with its reason, and nothing else."""

import itertools
from typing import Any

import msgspec
import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from common.clock import NS_PER_MS, NS_PER_S
from common.geometry import hand_rotation
from common.messages.hand import (
    ClockSync,
    HandPoint,
    Intent,
    PointCovariances,
    TrackingStatus,
)
from remote_site.reasons import Code
from remote_site.safety.config import SafetyConfig
from remote_site.session.lease import Holder, Lease
from remote_site.session.samples import Accepted, NamedSample, Rejected
from remote_site.teleop.sample_receiver import SampleReceiver
from remote_site.teleop.sample_validator import SampleValidator
from tests.present import present
from tests.remote_site.remote_loop import FOR_EVER_NS, LEASE, hand

NOW = 1_000 * NS_PER_MS
PERIOD = 33 * NS_PER_MS
SOFT_NS = 100 * NS_PER_MS
SURE = (1e-6, 0.0, 0.0, 1e-6, 0.0, 1e-6)  # 1 mm along each axis


@pytest.fixture
def intake():
    return SampleValidator(SafetyConfig())


def copying(point):
    """A validator for a tool that copies this point of the hand."""
    return SampleValidator(SafetyConfig(), point)


def code(result):
    return result.reason.code if isinstance(result, Rejected) else Code.OK


def accept(intake, sample, now_ns=None):
    return intake.accept(sample, SOFT_NS, sample.capture_ns + 10 * NS_PER_MS if now_ns is None else now_ns)


def sync(measured_ns, remote_minus_local_ms=0, uncertainty_ms=0):
    return ClockSync(
        remote_minus_local_ns=remote_minus_local_ms * NS_PER_MS,
        uncertainty_ns=uncertainty_ms * NS_PER_MS,
        measured_ns=measured_ns,
    )


def test_a_good_sample_is_accepted_with_wrist_orientation_and_time_of_birth(intake):
    for seq in range(1, 11):
        sample = hand(seq, NOW + seq * 33 * NS_PER_MS)
        result = accept(intake, sample)
    assert isinstance(result, Accepted)
    assert result.born_ns == sample.capture_ns
    assert result.position.tolist() == list(present(sample.wrist))
    assert np.array_equal(
        present(result.operator_R_hand),
        present(hand_rotation(*map(np.array, (sample.wrist, sample.index, sample.thumb)))),
    )
    assert not result.new_session


def test_duplicates_and_older_samples_are_refused(intake):
    accept(intake, hand(5, NOW))
    assert code(accept(intake, hand(5, NOW))) is Code.DUPLICATE
    assert code(accept(intake, hand(4, NOW - PERIOD), NOW + NS_PER_MS)) is Code.OLD
    assert code(accept(intake, hand(6, NOW + PERIOD))) is Code.OK
    assert intake.rejected == {Code.DUPLICATE: 1, Code.OLD: 1}


@pytest.mark.parametrize(("seq", "repeats"), [(5, Code.DUPLICATE), (4, Code.OLD)])
def test_a_copy_that_comes_beyond_the_age_limit_is_a_repeat_and_says_nothing_about_the_newest(intake, seq, repeats):
    accept(intake, hand(5, NOW))
    assert code(accept(intake, hand(seq, NOW - (5 - seq) * PERIOD), NOW + 300 * NS_PER_MS)) is repeats


def test_a_later_number_on_the_same_picture_is_refused(intake):
    accept(intake, hand(5, NOW))
    assert code(accept(intake, hand(6, NOW))) is Code.OLD


def test_age_counts_from_capture_with_the_offset_and_its_uncertainty(intake):
    sample = hand(1, NOW, clock=sync(NOW - 600 * NS_PER_MS, remote_minus_local_ms=-500, uncertainty_ms=20))
    born_ns = NOW - 500 * NS_PER_MS - 20 * NS_PER_MS
    assert code(accept(intake, sample, born_ns + 100 * NS_PER_MS + 1)) is Code.STALE
    late = accept(intake, sample, born_ns + 101 * NS_PER_MS)
    assert late.reason.sentence == "newest hand sample is 101 ms old (limit 100 ms)"
    result = accept(intake, sample, born_ns + 100 * NS_PER_MS)
    assert isinstance(result, Accepted)
    assert result.born_ns == born_ns


def test_the_age_limit_learns_how_old_samples_are_when_they_arrive():
    receiver = SampleReceiver(SafetyConfig(t_soft_ms="auto"), HandPoint.WRIST)
    lease = Lease(LEASE, Holder(7, "anna"), FOR_EVER_NS)
    for seq in range(1, 201):
        sample = NamedSample("anna", hand(seq, NOW + seq * PERIOD))
        result = receiver.receive(sample, lease, NOW + seq * PERIOD + 150 * NS_PER_MS)
        limit = receiver.settle(0.0)
    assert isinstance(result, Accepted)
    assert limit.soft_ns == 200 * NS_PER_MS


def test_a_sample_from_the_future_is_refused_and_does_not_block_the_next(intake):
    assert code(accept(intake, hand(900, NOW, clock=sync(NOW - 2)), NOW - 1)) is Code.FUTURE
    assert code(accept(intake, hand(1, NOW))) is Code.OK


def test_without_a_clock_offset_nothing_is_accepted(intake):
    assert code(accept(intake, hand(1, NOW, clock=None))) is Code.NO_OFFSET
    assert intake.clock is None


def test_a_clock_offset_from_the_future_of_our_clock_is_none(intake):
    assert code(accept(intake, hand(1, NOW, clock=sync(NOW + NS_PER_MS)), NOW)) is Code.NO_OFFSET


def test_a_clock_offset_counts_for_five_seconds(intake):
    assert code(accept(intake, hand(1, NOW, clock=sync(NOW - 5 * NS_PER_S)), NOW)) is Code.OK
    result = accept(intake, hand(2, NOW + 1, clock=sync(NOW - 5 * NS_PER_S)), NOW + 1)
    assert code(result) is Code.OLD_OFFSET
    result = accept(intake, hand(3, NOW, clock=sync(NOW - 6 * NS_PER_S)), NOW)
    told = "the clock offset of the local site was measured 6000 ms ago (limit 5000 ms)"
    assert result.reason.sentence == told


@pytest.mark.parametrize("held", [True, False])
def test_the_intent_in_a_sample_that_is_in_time_is_believed_even_if_the_hand_is_lost(intake, held):
    intent = Intent(hold=held)
    assert accept(intake, hand(1, NOW, status=TrackingStatus.LOST, intent=intent)).sample.intent == intent
    assert accept(intake, hand(1, NOW, intent=intent)).sample is None


@pytest.mark.parametrize(
    ("changes", "expected"),
    [
        ({"status": TrackingStatus.LOST}, Code.LOST),
        ({"status": TrackingStatus.INITIALISING}, Code.INITIALISING),
        ({"wrist": None}, Code.NO_WRIST),
    ],
)
def test_a_hand_that_is_not_tracked_is_refused_with_the_trackers_reason(intake, changes, expected):
    result = accept(intake, hand(1, NOW, reason="the arm left view 2", **changes))
    assert code(result) is expected
    assert result.hand_lost
    assert "the arm left view 2" in result.reason.sentence


@pytest.mark.parametrize("value", [np.nan, np.inf, -np.inf])
def test_a_wrist_that_is_not_finite_is_refused(intake, value):
    assert code(accept(intake, hand(1, NOW, wrist=(0.0, value, 0.3)))) is Code.NOT_FINITE


@pytest.mark.parametrize(
    "changes",
    [
        {"index": None},
        {"thumb": None},
        {"thumb_inferred": True},
        {"thumb_inferred": True, "covariance": PointCovariances(wrist=SURE, index=SURE)},
        {"hand_open": True},
        {"index": (0.0, np.nan, 0.0)},
        {"thumb": (0.0, 0.0, 0.3)},
    ],
)
def test_no_orientation_while_a_tip_is_missing_or_inferred_blindly_or_the_hand_is_open(intake, changes):
    def result(seq, **changes):
        return accept(intake, hand(seq, NOW + seq * 33 * NS_PER_MS, **changes))

    calm = [result(seq) for seq in range(1, 21)]
    assert calm[-1].operator_R_hand is not None
    changed = [result(seq, **changes) for seq in range(21, 24)]
    assert all(isinstance(r, Accepted) for r in changed)
    assert [r.operator_R_hand for r in changed] == [None] * 3


def test_the_orientation_of_tips_that_are_poorly_known_never_acts_however_calm(intake):
    poor = (0.0036, 0.0, 0.0, 0.0036, 0.0, 0.0036)  # 60 mm along each axis
    covariance = PointCovariances(wrist=SURE, index=poor, thumb=poor)
    results = [accept(intake, hand(k, NOW + k * PERIOD, covariance=covariance)) for k in range(1, 31)]
    assert all(isinstance(result, Accepted) for result in results)
    assert {result.operator_R_hand is None for result in results} == {True}


def test_an_inferred_thumb_that_is_known_well_enough_turns_the_tool_but_never_fast(intake):
    known = PointCovariances(wrist=SURE, index=SURE, thumb=SURE)
    results = [accept(intake, hand(k, NOW + k * PERIOD, thumb_inferred=True, covariance=known)) for k in range(1, 10)]
    assert results[-1].operator_R_hand is not None
    assert np.degrees(results[-1].turn_rad_s) == pytest.approx([45.0] * 3)


def test_where_only_the_roll_is_poorly_known_the_hand_still_points(intake):
    known = PointCovariances(wrist=SURE, index=SURE, thumb=(4e-4, 0.0, 0.0, 4e-4, 0.0, 4e-4))  # 20 mm along each axis
    results = [accept(intake, hand(k, NOW + k * PERIOD, covariance=known)) for k in range(1, 10)]
    assert results[-1].operator_R_hand is not None
    assert results[-1].turn_rad_s == (0.0, np.inf, np.inf)


def test_a_wrist_that_is_poorly_known_counts_as_a_lost_hand(intake):
    poor = PointCovariances(wrist=(0.0036, 0.0, 0.0, 0.0, 0.0, 0.0))
    result = accept(intake, hand(1, NOW, covariance=poor))
    assert (code(result), result.hand_lost) == (Code.UNCERTAIN, True)
    assert result.reason.sentence == "the wrist is known to 60 mm only (limit 40 mm)"


@pytest.mark.parametrize("point", list(HandPoint))
def test_the_point_that_the_tool_copies_is_judged_by_its_own_covariance(point):
    """A palm that nobody knows is not commanded because the wrist is sure, nor a sure palm held by a poor wrist."""
    other = HandPoint.WRIST if point is HandPoint.PALM else HandPoint.PALM
    poor = (0.03, 0.0, 0.0, 0.03, 0.0, 0.03)  # 300 mm
    intake = copying(point)
    shown: dict[str, Any] = {"palm": (0.0, -0.06, 0.3)}
    sure = accept(intake, hand(1, NOW, covariance=PointCovariances(**{point: SURE, other: poor}), **shown))
    unsure = accept(intake, hand(2, NOW + PERIOD, covariance=PointCovariances(**{point: poor, other: SURE}), **shown))
    assert (code(sure), sure.speed) == (Code.OK, 1.0)
    assert (code(unsure), unsure.hand_lost) == (Code.UNCERTAIN, True)
    assert unsure.reason.sentence == f"the {point} is known to 300 mm only (limit 40 mm)"


@pytest.mark.parametrize("point", list(HandPoint))
def test_a_sample_that_tells_how_well_other_points_are_known_is_not_believed_about_this_one(point):
    other = HandPoint.WRIST if point is HandPoint.PALM else HandPoint.PALM
    known = PointCovariances(**{other: SURE})
    result = accept(copying(point), hand(1, NOW, palm=(0.0, -0.06, 0.3), covariance=known))
    assert (code(result), result.hand_lost) == (Code.NO_COVARIANCE, True)
    assert str(point) in result.reason.sentence


@pytest.mark.parametrize("poor", ["elbow", "wrist"])
def test_an_elbow_whose_direction_is_poorly_known_is_not_commanded(poor):
    sure = dict.fromkeys(("elbow", "wrist", "palm"), SURE)
    unsure = sure | {poor: (0.03, 0.0, 0.0, 0.03, 0.0, 0.03)}
    intake = copying(HandPoint.PALM)
    results = [
        accept(intake, hand(k, NOW + k * PERIOD, palm=(0.0, -0.06, 0.3), covariance=covariance))
        for k, covariance in enumerate((None, PointCovariances(**sure), PointCovariances(**unsure)))
    ]
    assert [code(result) for result in results] == [Code.OK] * 3
    assert [result.elbow is None for result in results] == [False, False, True]
    assert results[1].elbow == hand(1, NOW).elbow


def test_after_a_gap_beyond_the_latch_time_a_hand_may_be_anywhere(intake):
    accept(intake, hand(1, NOW))
    assert code(accept(intake, hand(2, NOW + 501 * NS_PER_MS, wrist=(9.0, 0.0, 0.3)))) is Code.OK


@pytest.mark.parametrize("gap_ms", [40, 99, 101, 130, 250, 499, 500])
def test_after_any_shorter_gap_it_may_be_as_far_away_as_a_hand_gets_and_no_farther(intake, gap_ms):
    for beyond_m, expected in ((0.02, Code.OK), (0.04, Code.JUMP)):  # the noise is 0.03 m
        accept(intake, hand(1, NOW))
        way_m = 3.0 * gap_ms / 1000 + beyond_m
        assert code(accept(intake, hand(2, NOW + gap_ms * NS_PER_MS, wrist=(way_m, 0.0, 0.3)))) is expected
        intake = copying(HandPoint.WRIST)


def test_a_jump_is_refused_and_three_in_a_row_latch(intake):
    accept(intake, hand(1, NOW))
    results = [accept(intake, hand(1 + k, NOW + k * PERIOD, wrist=(1.5, 0.0, 0.3))) for k in (1, 2, 3)]
    assert [code(r) for r in results] == [Code.JUMP, Code.JUMP, Code.JUMPS]
    assert [r.latch for r in results] == [False, False, True]
    assert results[0].reason.sentence == "the wrist jumped 1500 mm in 33 ms"


def test_a_clock_that_is_known_less_well_is_no_jump(intake):
    for seq in range(1, 12):
        capture_ns = NOW + seq * PERIOD
        clock = sync(capture_ns, uncertainty_ms=5 if seq < 10 else 60)
        assert code(accept(intake, hand(seq, capture_ns, wrist=(0.0, 0.04 * seq, 0.3), clock=clock))) is Code.OK


def test_a_good_sample_between_jumps_counts_them_anew(intake):
    for k in range(12):
        wrist = (0.0, 0.0, 0.3) if k % 3 == 0 else (1.5, 0.0, 0.3)
        result = accept(intake, hand(k, NOW + k * PERIOD, wrist=wrist))
        assert code(result) is (Code.OK if k % 3 == 0 else Code.JUMP)


def test_a_hand_may_move_at_its_fastest(intake):
    for k in range(20):
        sample = hand(k, NOW + k * PERIOD, wrist=(0.0, 3.0 * k * PERIOD * 1e-9, 0.3))
        assert code(accept(intake, sample)) is Code.OK


def test_a_new_session_is_noticed(intake):
    accept(intake, hand(500, NOW))
    fresh = accept(intake, hand(1, NOW + PERIOD, session=8))
    assert isinstance(fresh, Accepted)
    assert fresh.new_session
    assert not accept(intake, hand(2, NOW + 3 * PERIOD, session=8)).new_session


def test_a_new_session_is_noticed_even_if_its_first_sample_is_lost(intake):
    accept(intake, hand(500, NOW))
    assert accept(intake, hand(1, NOW + PERIOD, session=8, status=TrackingStatus.LOST)).new_session


samples = st.lists(
    st.tuples(st.integers(0, 12), st.integers(-5, 12), st.integers(0, 1), st.integers(-30, 160)), max_size=40
)


@settings(max_examples=200, deadline=None, derandomize=True)
@given(samples)
def test_accepted_samples_always_rise_in_time_and_are_young(sequence):
    intake = SampleValidator(SafetyConfig())
    accepted, now_ns = [], NOW
    for seq, capture, session, delay_ms in sequence:
        now_ns += 5 * NS_PER_MS
        capture_ns = now_ns + capture * NS_PER_MS - delay_ms * NS_PER_MS
        sample = hand(seq, capture_ns, session=session, clock=sync(now_ns - NS_PER_MS))
        result = intake.accept(sample, SOFT_NS, now_ns)
        assert isinstance(result, (Accepted, Rejected))
        if isinstance(result, Accepted):
            assert 0 <= now_ns - sample.capture_ns <= 100 * NS_PER_MS
            accepted.append(sample)
    for before, after in itertools.pairwise(accepted):
        if before.session == after.session:
            assert after.capture_ns > before.capture_ns
    assert sum(intake.rejected.values()) == len(sequence) - len(accepted)


def test_soft_must_stay_below_latch():
    with pytest.raises(ValueError, match="t_latch_ms"):
        msgspec.convert({"t_soft_ms": 300, "t_latch_ms": 250}, SafetyConfig)
