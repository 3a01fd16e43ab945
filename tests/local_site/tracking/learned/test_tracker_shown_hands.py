"""The tracker before a dark wall with faultless landmarks: tracked when all agrees, and never on a hand that is not the
operator's."""

from dataclasses import replace

import numpy as np
import pytest

from common.messages.hand import TrackingStatus
from local_site.tracking.config import LearnedConfig
from local_site.tracking.landmarks.side_evidence import ENOUGH
from local_site.tracking.learned.followed_hand import FollowedHand
from local_site.tracking.silhouette.hand_model.habits import Belief, Habits
from local_site.tracking.silhouette.operator_profile import make_profile
from local_site.tracking.tracker import TrackingReason, Views
from tests.local_site.tracking.landmarks.scripted_hands import show
from tests.local_site.tracking.landmarks.seen_hands import seen_by_all
from tests.local_site.tracking.learned.simulated_landmarks import shown_tracker, simulated_landmarks
from tests.local_site.tracking.rendered_arm import (
    BRISK_S,
    MOVING,
    PERIOD_S,
    POINTS,
    apart_m,
    errors_m,
    render_sequence,
)

LEARNING = 10
# A third more than the largest errors measured; the simulated hand differs from the model.
LARGEST_MM = {"elbow": 10.0, "wrist": 8.0, "index": 8.0, "thumb": 8.0}
FOUR_MM = {"elbow": 16.0, "wrist": 8.0, "index": 8.0, "thumb": 10.0}
ELSEWHERE = np.array([0.05, 0.1, -0.3])
OUT_OF_PHASE_M = 0.002
LEFT = 0.05
OTHER_HABITS = np.array([0.3, 0.3, 0.1, 0.05, -0.3, -0.3, 0.3, 0.1, -0.1, 0.1])


def black(pictures, level=24):
    """A dark wall without an arm."""
    return [np.full_like(picture, level) for picture in pictures]


def capped(pictures):
    return black(pictures, level=9)


def later(views, instants):
    return replace(views, t_ns=views.t_ns + round(1e9 * PERIOD_S * instants))


@pytest.fixture
def shown(monkeypatch, moving):
    return shown_tracker(monkeypatch, moving.projections)


def follow(shown, sequence, instants, **kind):
    return [shown.track(sequence.views(k), simulated_landmarks(sequence, k), **kind) for k in instants]


def largest_mm(estimates, sequence, instants, name):
    truths = [sequence.truths[k] for k in instants]
    return 1e3 * np.linalg.norm(errors_m(estimates, truths, name), axis=1).max()


def test_an_arm_is_learned_and_tracked(shown, moving):
    estimates = follow(shown, moving, range(45))
    assert estimates[0].status is TrackingStatus.INITIALISING
    assert all(estimate.status is not TrackingStatus.LOST for estimate in estimates)
    assert all(estimate.status is TrackingStatus.TRACKED for estimate in estimates[LEARNING:])
    for name, limit_mm in LARGEST_MM.items():
        assert largest_mm(estimates[LEARNING:], moving, range(LEARNING, 45), name) < limit_mm
    assert not any(estimate.thumb_inferred for estimate in estimates)
    assert all(len(estimate.overlays) == 2 for estimate in estimates)


def test_every_point_has_a_covariance_and_is_as_sure_as_it_says(shown, moving):
    for k, estimate in enumerate(follow(shown, moving, range(25))):
        for name, covariance in estimate.covariances.items():
            np.testing.assert_allclose(covariance, covariance.T, atol=1e-12)
            assert np.linalg.eigvalsh(covariance)[0] > 0
            off = getattr(estimate, name) - getattr(moving.truths[k], name)
            assert off @ np.linalg.solve(covariance, off) < 40.0
        assert set(estimate.covariances) >= {"wrist", "index", "thumb"}


def test_a_left_hand_is_lost_with_the_reason_and_never_tracked(shown, moving):
    estimates = follow(shown, moving, range(30), right=LEFT)
    assert {estimate.status for estimate in estimates} <= {TrackingStatus.LOST, TrackingStatus.INITIALISING}
    refused = [estimate for estimate in estimates if estimate.status is TrackingStatus.LOST]
    assert len(refused) > 20
    assert refused[-1].reason == TrackingReason.OTHER_SIDE


def test_a_run_in_which_the_hand_is_taken_for_its_mirror_image_is_survived(shown, moving):
    follow(shown, moving, range(20))
    estimates = follow(shown, moving, range(20, 24), right=LEFT)
    assert all(estimate.status is not TrackingStatus.LOST for estimate in estimates)
    assert all(estimate.status is TrackingStatus.TRACKED for estimate in follow(shown, moving, range(24, 30)))


def test_nothing_but_mirror_images_gives_a_status(shown, moving):
    follow(shown, moving, range(20))
    for k in range(20, 24):
        views = moving.views(k, black)
        estimate = shown.track(views, simulated_landmarks(moving, k), right=LEFT)
        assert estimate.status is not TrackingStatus.TRACKED


def test_a_hand_without_an_arm_is_never_more_than_initialising(shown, moving):
    for k in range(40):
        estimate = shown.track(moving.views(k, black), simulated_landmarks(moving, 3))
        assert estimate.status is TrackingStatus.INITIALISING
        assert estimate.elbow is None


def test_a_hand_beside_the_arm_does_not_belong_to_it(shown, moving):
    for k in range(40):
        estimate = shown.track(moving.views(k), simulated_landmarks(moving, k) + ELSEWHERE)
        assert estimate.status is TrackingStatus.INITIALISING


def test_a_second_hand_is_never_jumped_to(shown, moving):
    follow(shown, moving, range(3))
    for k in range(3, 45):
        hands = [simulated_landmarks(moving, k), simulated_landmarks(moving, k) + (1 - k / 50) * ELSEWHERE]
        estimate = shown.track(moving.views(k), *(hands if k % 2 else hands[::-1]))
        assert np.linalg.norm(estimate.wrist - moving.truths[k].wrist) < 0.02


@pytest.mark.slow
def test_a_hand_without_an_arm_does_not_keep_the_operator_out(shown, moving):
    poster = simulated_landmarks(moving, 0) + ELSEWHERE
    for k in range(10):
        shown.track(moving.views(k, black), poster)
    moments = [later(moving.views(k % 45), k - k % 45) for k in range(10, 130)]
    estimates = [shown.track(v, poster, simulated_landmarks(moving, k % 45)) for k, v in enumerate(moments, 10)]
    assert estimates[-1].status is TrackingStatus.TRACKED


def test_after_a_short_loss_a_hand_elsewhere_must_show_its_arm(shown, moving):
    follow(shown, moving, range(20))
    shown.track(moving.views(20, black))
    for k in range(21, 25):
        estimate = shown.track(moving.views(k), simulated_landmarks(moving, k) + ELSEWHERE)
        assert estimate.status is not TrackingStatus.TRACKED


def test_outlines_before_a_dark_wall_bridge_half_a_second_without_landmarks(shown, moving):
    follow(shown, moving, range(20))
    bridged = [shown.track(moving.views(k)) for k in range(20, 32)]
    assert all(estimate.status is TrackingStatus.TRACKED for estimate in bridged)
    for name, limit_mm in LARGEST_MM.items():
        assert largest_mm(bridged, moving, range(20, 32), name) < 2 * limit_mm
    later = [shown.track(moving.views(k)) for k in range(36, 45)]
    assert all(estimate.status is TrackingStatus.LOST for estimate in later)
    assert {estimate.reason for estimate in later} == {TrackingReason.NO_HAND}


def test_outlines_bridge_nothing_before_the_operator_is_known(shown, moving):
    follow(shown, moving, range(5))
    assert shown.track(moving.views(5)).wrist is None


def test_outlines_that_are_gone_or_jump_bridge_nothing(shown, moving):
    follow(shown, moving, range(20))
    assert shown.track(moving.views(20, black)).status is TrackingStatus.LOST
    assert shown.track(moving.views(21)).status is TrackingStatus.LOST


def test_after_a_short_loss_the_operators_hand_is_tracked_at_once(shown, moving):
    follow(shown, moving, range(20))
    lost = shown.track(moving.views(20, black))
    assert lost.status is TrackingStatus.LOST
    assert lost.reason == TrackingReason.NO_HAND
    assert lost.wrist is None
    assert follow(shown, moving, [21])[0].status is TrackingStatus.TRACKED


def test_covered_cameras_are_lost_and_the_arm_is_found_again(shown, moving):
    follow(shown, moving, range(15))
    for k in range(15, 30):
        lost = shown.track(moving.views(k, black))
        assert lost.status is TrackingStatus.LOST
        assert lost.reason
    back = follow(shown, moving, range(30, 36))
    assert back[0].status is TrackingStatus.INITIALISING
    assert back[-1].status is TrackingStatus.TRACKED


def test_frames_may_be_dropped(shown, moving):
    instants = [*range(15), *range(17, 45, 4)]
    estimates = follow(shown, moving, instants)
    assert all(estimate.status is TrackingStatus.TRACKED for estimate in estimates[LEARNING:])
    assert largest_mm(estimates[LEARNING:], moving, instants[LEARNING:], "index") < LARGEST_MM["index"]


def test_an_empty_room_is_learned_before_the_arm_comes_in(shown, moving):
    statuses = [shown.track(moving.views(k, black)).status for k in range(45)]
    assert statuses[:38] == [TrackingStatus.INITIALISING] * 38 or TrackingStatus.LOST in statuses[30:]
    assert statuses[0] is TrackingStatus.INITIALISING
    assert statuses[-1] is TrackingStatus.LOST


def test_a_poster_that_one_view_sees_does_not_keep_the_room_from_being_learned(shown, moving):
    poster = seen_by_all(shown.rig, simulated_landmarks(moving, 0))
    reasons = []
    for k in range(90):
        show(shown.views, poster)
        shown.views[1].shown = []
        reasons.append(shown.tracker.track(later(moving.views(0, black), k)).reason)
    assert TrackingReason.LEARNING_ROOM not in reasons[:20]
    assert TrackingReason.LEARNING_ROOM in reasons
    assert reasons[-1] == f"{shown.rig.cameras[1].name}: {TrackingReason.NO_HAND}"


def test_a_hand_that_one_view_sees_moving_keeps_the_room_from_being_learned(shown, moving):
    for k in range(45):
        show(shown.views, seen_by_all(shown.rig, simulated_landmarks(moving, k)))
        shown.views[1].shown = []
        estimate = shown.tracker.track(moving.views(k, black))
        assert estimate.reason == f"{shown.rig.cameras[1].name}: {TrackingReason.NO_HAND}"


def test_hands_on_which_two_views_do_not_agree_are_said_to_differ(shown, moving):
    hands = simulated_landmarks(moving, 0)
    here, there = seen_by_all(shown.rig, hands), seen_by_all(shown.rig, hands + ELSEWHERE)
    show(shown.views, [here[0], there[1]])
    assert shown.tracker.track(moving.views(0)).reason == TrackingReason.HANDS_DIFFER


@pytest.mark.parametrize("capped_views", [(0,), (1,), (0, 1)])
def test_dark_pictures_are_named_instead_of_the_room_or_the_hand(shown, moving, capped_views):
    def cover(pictures):
        return [capped([p])[0] if k in capped_views else black([p])[0] for k, p in enumerate(pictures)]

    told = "; ".join(f"{shown.rig.cameras[k].name}: {TrackingReason.DARK}" for k in capped_views)
    estimates = [shown.track(moving.views(k, cover)) for k in range(45)]
    assert {estimate.reason for estimate in estimates} == {told}
    assert estimates[-1].status is TrackingStatus.LOST


def test_another_number_of_views_is_lost(shown, moving):
    views = moving.views(0)
    estimate = shown.tracker.track(Views(views.t_ns, views.views[:1]))
    assert "1 views for 2 calibrated cameras" in estimate.reason
    assert estimate.status is not TrackingStatus.TRACKED


def test_a_mirrored_rig_is_a_left_arm(monkeypatch, moving):
    shown = shown_tracker(monkeypatch, moving.projections, LearnedConfig(right_arm=False))
    estimates = follow(shown, moving, range(30))
    assert estimates[-1].reason == TrackingReason.OTHER_SIDE
    assert all(estimate.status is not TrackingStatus.TRACKED for estimate in estimates)


def test_four_cameras_track(monkeypatch, surrounded):
    shown = shown_tracker(monkeypatch, surrounded.projections)
    estimates = follow(shown, surrounded, range(20))
    assert all(estimate.status is TrackingStatus.TRACKED for estimate in estimates[LEARNING:])
    for name, limit_mm in FOUR_MM.items():
        assert largest_mm(estimates[LEARNING:], surrounded, range(LEARNING, 20), name) < limit_mm


def test_cameras_out_of_phase_are_brought_to_one_instant(monkeypatch):
    late_s, count = 0.5 * PERIOD_S, 24
    late = render_sequence(MOVING, count, late_s=late_s, since_s=BRISK_S)
    shown = shown_tracker(monkeypatch, late.projections)
    brought = []
    for k in range(1, count):
        views = Views(late.views(k).t_ns, (late.views(k).views[0], late.between(k, 1, late_s)))
        brought.append(shown.track(views, simulated_landmarks(late, k)))
    together = render_sequence(MOVING, count, since_s=BRISK_S)
    exact = follow(shown_tracker(monkeypatch, together.projections), together, range(1, count))
    settled = slice(LEARNING + 1, None)
    assert all(estimate.status is TrackingStatus.TRACKED for estimate in brought[settled])
    for name in ("elbow", "wrist", "index"):
        assert apart_m(brought[settled], exact[settled], name) < OUT_OF_PHASE_M


def test_a_hand_gives_no_signal_before_its_side_is_sure(shown, moving, monkeypatch):
    monkeypatch.setattr(FollowedHand, "_is_open", lambda *_: True)
    opened = [estimate.hand_open for estimate in follow(shown, moving, range(20), right=0.7)]
    assert opened == [False] * (ENOUGH - 1) + [True] * (20 - ENOUGH + 1)


def test_an_operator_who_was_known_before_is_tracked_after_as_many_pairs(monkeypatch, moving):
    known = make_profile(1.0, Habits().own, 0.27, 20)
    shown = shown_tracker(monkeypatch, moving.projections, profile=known)
    assert shown.tracker.profile is None
    estimates = follow(shown, moving, range(20))
    assert all(estimate.status is TrackingStatus.TRACKED for estimate in estimates[LEARNING:])


@pytest.mark.slow
@pytest.mark.parametrize(("scale", "forearm_m"), [(1.0, 0.24), (1.0, 0.35), (1.4, 0.27)])
def test_of_a_profile_of_another_body_the_habits_are_forgotten_too(monkeypatch, moving, scale, forearm_m):
    habits = Habits().own
    stranger = Belief(habits.posture + OTHER_HABITS, 100.0 * habits.information)
    shown = shown_tracker(monkeypatch, moving.projections, profile=make_profile(scale, stranger, forearm_m, 20))
    follow(shown, moving, range(45))
    again = [shown.track(later(moving.views(k), 45), simulated_landmarks(moving, k)) for k in range(45)]
    assert all(estimate.status is TrackingStatus.TRACKED for estimate in again)
    for name, limit_mm in LARGEST_MM.items():
        assert largest_mm(again, moving, range(45), name) < limit_mm
    learned = shown.tracker.profile
    assert learned is not None
    assert learned.scale < 1.0  # the simulated hand's, by its landmarks


@pytest.mark.parametrize("name", POINTS)
def test_no_point_is_ever_without_a_number(shown, moving, name):
    for estimate in follow(shown, moving, range(0, 30, 3)):
        point = getattr(estimate, name)
        assert point is None or np.isfinite(point).all()
