"""The operator is got to know by agreeing pairs; what is not an operator's arm never counts as tracked."""

import math
from dataclasses import replace
from types import SimpleNamespace

import numpy as np
import pytest

from common.clock import NS_PER_MS
from common.messages.hand import TrackingStatus
from local_site.tracking.config import LearnedConfig
from local_site.tracking.landmarks.hand_finder import SHORT_LOSS_NS
from local_site.tracking.landmarks.hand_pairing import HandPairing
from local_site.tracking.learned.acquaintance import Acquaintance
from local_site.tracking.learned.shown_hand import BEGUN
from local_site.tracking.silhouette.hand_model.habits import Habits
from local_site.tracking.silhouette.hand_model.skeleton import Person
from local_site.tracking.silhouette.operator_profile import MOST_PAIRS, make_profile
from local_site.tracking.tracker import TrackingReason
from tests.local_site.tracking.landmarks.seen_hands import PAIR_RIG, landmarks_of, seen_by_all
from tests.local_site.tracking.silhouette.hand_model.posed_hands import TO_ELBOW, pose_of

PAIRS = 10
FOREARM_M = 0.27
WRIST = np.array([0.5, 0.45, 0.6])
PERIOD_NS = 33 * NS_PER_MS
CONFIG = LearnedConfig(initial_pairs=PAIRS)
DOUBT = [TrackingReason.LEFT_OPEN]


def hand(scale=1.0, right=0.95, right_arm=True):
    landmarks = landmarks_of(pose_of(), Person(scale, right_arm, TO_ELBOW))
    seen = HandPairing(PAIR_RIG).meet(dict(enumerate(seen_by_all(PAIR_RIG, landmarks, right))))
    assert seen is not None
    return seen


HAND, LEFT_HAND = hand(), hand(right=0.05, right_arm=False)
ELSEWHERE = replace(HAND, points=np.add(HAND.points, (0.0, 0.05, 0.25)))


def arm(forearm_m=FOREARM_M):
    return SimpleNamespace(joints=SimpleNamespace(elbow=WRIST + forearm_m * TO_ELBOW))


def meet(operator, pairs, forearm_m=FOREARM_M, scale=1.0, reasons=(), since=0):
    """Pairs with a hand at an arm; the status of the last."""
    seen, status = hand(scale), (TrackingStatus.INITIALISING, "")
    for k in range(pairs):
        t_ns = (since + k) * PERIOD_NS
        operator.has_side(t_ns, seen)
        operator.learn(arm(forearm_m), WRIST, None, list(reasons))
        status = operator.status([], "")
    return status


def known():
    operator = Acquaintance(CONFIG, None)
    meet(operator, PAIRS)
    assert operator.is_known
    return operator


def profile(forearm_m=FOREARM_M, pairs=30):
    return make_profile(1.0, Habits().own, forearm_m, pairs)


def test_an_operator_is_initialising_then_learned_then_tracked():
    operator, statuses = Acquaintance(CONFIG, None), []
    for k in range(PAIRS):
        statuses.append(meet(operator, 1, since=k)[0])
    assert statuses[: BEGUN - 1] == [TrackingStatus.INITIALISING] * (BEGUN - 1)
    assert set(statuses[BEGUN:-1]) == {TrackingStatus.DEGRADED}
    assert statuses[-1] is TrackingStatus.TRACKED
    assert operator.body.forearm_length == pytest.approx(FOREARM_M)


def test_learning_says_how_far_it_is():
    operator = Acquaintance(CONFIG, None)
    _, reason = meet(operator, 6)
    assert "6 of 10 pairs" in reason
    assert TrackingReason.LEARNING in reason


def test_a_hand_on_a_poster_has_no_arm_and_is_never_more_than_initialising():
    operator = Acquaintance(CONFIG, None)
    for k in range(200):
        assert operator.has_side(k * PERIOD_NS, HAND)
        status, reason = operator.status([], TrackingReason.NO_ARM)
        assert status is TrackingStatus.INITIALISING
        assert reason == TrackingReason.NO_ARM
    assert not operator.is_known


def test_a_left_hand_is_refused_and_a_right_one_of_a_left_arm():
    for right_arm, other in ((True, LEFT_HAND), (False, HAND)):
        operator = Acquaintance(LearnedConfig(initial_pairs=PAIRS, right_arm=right_arm), None)
        assert [operator.has_side(k * PERIOD_NS, other) for k in range(5)][2:] == [False] * 3


def test_a_hand_without_an_arm_is_doubted_after_a_while_and_another_is_not():
    operator = Acquaintance(CONFIG, None)
    doubted = []
    for k in range(35):
        operator.has_side(k * PERIOD_NS, HAND)
        doubted.append(operator.lacks_arm(HAND))
    assert not any(doubted[:30])
    assert doubted[-1]
    assert operator.doubt(HAND) > operator.doubt(ELSEWHERE) == 0


def test_only_a_hand_of_a_clear_side_is_tried_instead_of_one_that_is_doubted():
    operator, unclear = Acquaintance(CONFIG, None), replace(hand(right=0.65), points=ELSEWHERE.points)
    assert operator.doubt(unclear) == 0
    for k in range(35):
        operator.has_side(k * PERIOD_NS, HAND)
        operator.lacks_arm(HAND)
    assert operator.doubt(ELSEWHERE) < operator.doubt(HAND) < operator.doubt(unclear) < math.inf


def test_of_two_doubted_hands_the_one_doubted_longer_ago_is_preferred():
    operator = Acquaintance(CONFIG, None)
    for since, seen in ((0, HAND), (100, ELSEWHERE)):
        for k in range(since, since + 35):
            operator.has_side(k * PERIOD_NS, seen)
            operator.lacks_arm(seen)
    assert 0 < operator.doubt(HAND) < operator.doubt(ELSEWHERE)


def test_a_hand_that_shows_its_arm_at_last_is_no_longer_doubted():
    operator = Acquaintance(CONFIG, None)
    for k in range(35):
        operator.has_side(k * PERIOD_NS, HAND)
        operator.lacks_arm(HAND)
    meet(operator, BEGUN, since=35)
    assert operator.doubt(HAND) == 0
    assert not operator.lacks_arm(HAND)


def test_a_hand_of_the_other_side_is_doubted_so_that_the_operators_beside_it_is_taken():
    operator = Acquaintance(CONFIG, None)
    for k in range(5):
        operator.has_side(k * PERIOD_NS, LEFT_HAND)
    assert operator.doubt(LEFT_HAND) > operator.doubt(ELSEWHERE) == 0
    assert operator.has_side(5 * PERIOD_NS, ELSEWHERE)


def test_the_arm_of_an_operator_who_is_known_may_be_hidden_for_long():
    operator = known()
    for k in range(PAIRS, PAIRS + 60):
        operator.has_side(k * PERIOD_NS, HAND)
        assert not operator.lacks_arm(HAND)
    assert operator.status([], "")[0] is TrackingStatus.DEGRADED


def test_arms_that_are_found_now_and_then_teach_nothing():
    operator = Acquaintance(CONFIG, None)
    for k in range(5 * PAIRS):
        operator.has_side(k * PERIOD_NS, HAND)
        if k % 4 == 0:
            operator.learn(arm(), WRIST, None, [])
    assert not operator.is_known
    meet(operator, PAIRS, since=5 * PAIRS)
    assert operator.is_known


def test_an_arm_whose_elbow_is_doubted_teaches_no_length():
    operator = Acquaintance(CONFIG, None)
    status, _ = meet(operator, 50, reasons=DOUBT)
    assert not operator.is_known
    assert operator.body.forearm_length is None
    assert status is TrackingStatus.DEGRADED


def test_lengths_that_scatter_teach_nothing_until_they_agree():
    operator = Acquaintance(CONFIG, None)
    for k in range(60):
        meet(operator, 1, FOREARM_M * (0.8 if k % 2 else 1.2), since=k)
    assert not operator.is_known
    meet(operator, PAIRS, since=60)
    assert operator.body.forearm_length == pytest.approx(FOREARM_M)


def test_single_wrong_lengths_do_not_count():
    operator = Acquaintance(CONFIG, None)
    for k in range(PAIRS):
        meet(operator, 1, 2 * FOREARM_M if k in (3, 7) else FOREARM_M, since=k)
    assert operator.body.forearm_length == pytest.approx(FOREARM_M)


@pytest.mark.parametrize(("scale", "fits"), [(0.7, False), (0.9, True), (1.0, True), (1.1, True), (1.3, False)])
def test_hands_of_another_size_are_refused_once_the_operators_is_known(scale, fits):
    assert Acquaintance(CONFIG, None).doubt(hand(scale)) == 0
    assert known().doubt(hand(scale)) == (0 if fits else math.inf)


@pytest.mark.parametrize(("share", "fits"), [(0.85, False), (0.95, True), (1.05, True), (1.2, False)])
def test_an_arm_of_another_length_is_doubted_once_it_is_known(share, fits):
    assert Acquaintance(CONFIG, None).has_length(arm(share * FOREARM_M), WRIST)
    assert known().has_length(arm(share * FOREARM_M), WRIST) == fits


def test_the_distance_to_the_sleeve_is_the_median_of_those_seen():
    operator, elbow = Acquaintance(CONFIG, None), arm().joints.elbow
    for k in range(PAIRS):
        operator.has_side(k * PERIOD_NS, HAND)
        operator.learn(arm(), WRIST, None if k % 2 else np.add(elbow, (0.0, 0.0, -0.1)), [])
    assert operator.body.sleeve_distance == pytest.approx(0.1)


def test_a_short_loss_changes_nothing_and_after_a_long_one_the_arm_must_be_seen_again():
    operator = known()
    last_ns = (PAIRS - 1) * PERIOD_NS
    operator.lose(last_ns + SHORT_LOSS_NS // 2)
    assert operator.status([], "")[0] is TrackingStatus.TRACKED
    operator.lose(last_ns + 2 * SHORT_LOSS_NS)
    assert operator.status([], "")[0] is TrackingStatus.INITIALISING
    assert operator.is_known
    assert meet(operator, 1, since=100)[0] is TrackingStatus.INITIALISING
    assert meet(operator, BEGUN, since=101)[0] is TrackingStatus.TRACKED


def test_after_a_long_loss_a_left_hand_is_refused_within_a_few_instants():
    operator = known()
    operator.lose(10**12)
    supported = [operator.has_side(10**12 + k * PERIOD_NS, LEFT_HAND) for k in range(6)]
    assert supported[-1] is False


def test_doubts_about_the_hand_degrade_and_those_about_the_elbow_are_told():
    operator = known()
    doubtful = operator.status([TrackingReason.HAND_UNCLEAR], "")
    assert doubtful == (TrackingStatus.DEGRADED, TrackingReason.HAND_UNCLEAR)
    assert operator.status([], TrackingReason.NO_UPPER_ARM) == (
        TrackingStatus.TRACKED,
        TrackingReason.NO_UPPER_ARM,
    )


def test_every_status_but_tracked_has_a_reason():
    fresh, learning, ready = Acquaintance(CONFIG, None), Acquaintance(CONFIG, None), known()
    meet(learning, BEGUN + 1)
    for operator in (fresh, learning, ready):
        for reasons in ([], [TrackingReason.OUTSIDE_VOLUME]):
            status, reason = operator.status(reasons, "")
            assert reason or status is TrackingStatus.TRACKED


def test_a_profile_gives_the_length_at_once_and_its_pairs_add_up():
    operator = Acquaintance(CONFIG, profile())
    assert operator.body.forearm_length == pytest.approx(FOREARM_M)
    assert not operator.is_known
    meet(operator, PAIRS)
    assert operator.pairs == 30 + PAIRS
    assert Acquaintance(CONFIG, profile(pairs=MOST_PAIRS)).pairs == MOST_PAIRS


def test_a_profile_of_another_body_is_dropped():
    operator = Acquaintance(CONFIG, profile(1.3 * FOREARM_M))
    meet(operator, PAIRS)
    assert operator.body.forearm_length == pytest.approx(FOREARM_M)
    assert operator.pairs == PAIRS


def test_a_profile_of_another_hands_size_is_dropped():
    operator = Acquaintance(CONFIG, make_profile(1.4, Habits().own, FOREARM_M, 30))
    meet(operator, PAIRS)
    assert operator.is_known
    assert operator.profile is None


def test_a_profile_whose_hand_is_unclear_for_long_is_dropped_with_its_length():
    operator = Acquaintance(CONFIG, profile())
    for k in range(2 * PAIRS):
        operator.has_side(k * PERIOD_NS, HAND)
        operator.doubt_profile()
    assert operator.profile is not None
    operator.doubt_profile()
    assert operator.profile is None
    assert operator.body.forearm_length is None
    _, reason = meet(operator, 5, since=100)
    assert TrackingReason.OTHER_BODY in reason


def test_a_profile_that_fitted_is_kept_though_the_hand_is_unclear_later():
    operator = Acquaintance(CONFIG, profile())
    meet(operator, PAIRS)
    for _ in range(5 * PAIRS):
        operator.doubt_profile()
    assert operator.profile is not None
