"""The tracker with its networks in a simulated office: the operator's right arm is tracked, and nothing else."""

import numpy as np
import pytest

from common.messages.hand import TrackingStatus
from local_site.simulation.room.config import RoomConfig
from local_site.tracking.tracker import TrackingReason
from tests.local_site.tracking.learned.office_films import EMPTY_S, filmed, mirrored, office, track
from tests.local_site.tracking.rendered_arm import PERIOD_S, rig_of

ENTERED = round(EMPTY_S / PERIOD_S)
KNOWN = ENTERED + 35  # when the arm has come in and is learned
SHARE = 0.9
WITHIN_SIGMAS, SURE_SHARE = 3.0, 0.9
# About half more than the mean and the largest error measured.
MEAN_MM = {"elbow": 12.5, "wrist": 7.0, "index": 21.0, "thumb": 8.0}
LARGEST_MM = {"elbow": 16.0, "wrist": 12.0, "index": 32.0, "thumb": 12.0}
EVERYTHING = ("second_arm", "face", "hand_poster", "fan", "shadows")
UNTRACKED = {TrackingStatus.LOST, TrackingStatus.INITIALISING}


@pytest.fixture(scope="module")
def carried(make_tracker, carrying):
    """The film of the operator who comes in, tracked."""
    return track(make_tracker, carrying)


def black(pictures):
    return [np.full_like(picture, 6) for picture in pictures]


def test_the_arm_is_learned_and_tracked(carried):
    assert carried.share(KNOWN) >= SHARE
    assert TrackingStatus.TRACKED not in {estimate.status for estimate in carried.estimates[: ENTERED + 10]}
    for name, limit_mm in MEAN_MM.items():
        errors = carried.errors_mm(name)
        assert errors.mean() < limit_mm
        assert errors.max() < LARGEST_MM[name]


def test_every_instant_says_what_it_is(carried):
    assert carried.estimates[0].reason == TrackingReason.LEARNING_ROOM
    for estimate in carried.estimates:
        assert estimate.reason or estimate.status is TrackingStatus.TRACKED
        assert (estimate.wrist is not None) or estimate.status in UNTRACKED
        assert all(np.linalg.eigvalsh(covariance)[0] > 0 for covariance in estimate.covariances.values())


@pytest.mark.parametrize(
    "name",
    ["elbow", "wrist", "index", "thumb"],
)
def test_points_are_as_sure_as_is_said(carried, name):
    sigmas = [
        1e3 * np.sqrt(np.trace(estimate.covariances[name]))
        for estimate in carried.estimates
        if estimate.status is TrackingStatus.TRACKED and name in estimate.covariances
    ]
    assert np.mean(carried.errors_mm(name) < WITHIN_SIGMAS * np.array(sigmas)) >= SURE_SHARE


@pytest.mark.slow
@pytest.mark.parametrize("disturbances", [(), EVERYTHING], ids=["nothing else", "everything else"])
def test_a_room_without_the_operator_is_never_tracked(make_tracker, disturbances):
    room = RoomConfig(scene="office", empty_s=60.0, disturbances=disturbances)
    seen = track(make_tracker, filmed(office(room), 75))
    assert seen.statuses <= UNTRACKED
    assert all(estimate.reason for estimate in seen.estimates)


@pytest.mark.slow
def test_a_left_arm_is_never_tracked(make_tracker, carrying):
    tracker = make_tracker(rig_of(carrying.projections))
    estimates = carrying.tracked(tracker, mirrored)
    assert {estimate.status for estimate in estimates} <= UNTRACKED
    assert TrackingReason.OTHER_SIDE in {estimate.reason for estimate in estimates}


@pytest.mark.slow
def test_exchanged_pictures_are_never_tracked(make_tracker, carrying):
    estimates = carrying.tracked(make_tracker(rig_of(carrying.projections)), lambda pictures: pictures[::-1])
    assert {estimate.status for estimate in estimates} <= UNTRACKED


@pytest.mark.slow
@pytest.mark.parametrize("change", [black, lambda pictures: [pictures[0], *black(pictures[1:])]], ids=["both", "one"])
def test_covered_cameras_are_lost_and_the_arm_is_found_again(make_tracker, carrying, change):
    tracker = make_tracker(rig_of(carrying.projections))
    for k in range(KNOWN):
        tracker.track(carrying.views(k))
    for k in range(KNOWN, KNOWN + 5):
        lost = tracker.track(carrying.views(k, change))
        assert lost.status is TrackingStatus.LOST
        assert TrackingReason.DARK in lost.reason
        assert lost.wrist is None
    back = [tracker.track(carrying.views(k)) for k in range(KNOWN + 5, len(carrying.times_s))]
    assert back[-1].status is TrackingStatus.TRACKED
    assert 1e3 * np.linalg.norm(back[-1].wrist - carrying.truths[-1].wrist) < LARGEST_MM["wrist"]


@pytest.mark.slow
def test_dropped_frames_do_not_matter(make_tracker, carrying):
    tracker = make_tracker(rig_of(carrying.projections))
    instants = [*range(KNOWN), *range(KNOWN, len(carrying.times_s), 3)]
    estimates = [tracker.track(carrying.views(k)) for k in instants]
    assert np.mean([estimate.status is TrackingStatus.TRACKED for estimate in estimates[KNOWN:]]) >= SHARE
    for k, estimate in zip(instants[KNOWN:], estimates[KNOWN:], strict=True):
        if estimate.status is TrackingStatus.TRACKED:
            assert 1e3 * np.linalg.norm(estimate.wrist - carrying.truths[k].wrist) < LARGEST_MM["wrist"]
