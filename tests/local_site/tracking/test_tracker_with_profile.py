"""A tracker that knows the operator from an earlier run: what it keeps, and that it notices another body."""

import numpy as np
import pytest

from local_site.tracking.silhouette.operator_profile import make_profile
from local_site.tracking.silhouette.silhouette_tracker import SilhouetteTracker
from local_site.tracking.tracker import TrackingReason
from tests.local_site.tracking.rendered_arm import POINTS, errors_m, rig_of

COUNT = 20
WORSE_M = 0.0015


@pytest.fixture(scope="module")
def first(moving):
    """A run that knew nothing: the tracker and its estimates."""
    tracker = SilhouetteTracker(rig_of(moving.projections))
    return tracker, moving.tracked(tracker)


def with_profile(sequence, profile):
    tracker = SilhouetteTracker(rig_of(sequence.projections), profile=profile)
    return tracker, sequence.tracked(tracker)


def test_there_is_no_profile_before_the_arm_is_known(moving):
    tracker = SilhouetteTracker(rig_of(moving.projections))
    assert tracker.profile is None
    tracker.track(moving.views(0))
    assert tracker.profile is None


def test_a_second_run_goes_on_learning(moving, first):
    profile = first[0].profile
    tracker, estimates = with_profile(moving, profile)
    later = tracker.profile
    assert later.pairs == 2 * profile.pairs
    assert later.forearm_length_m == pytest.approx(profile.forearm_length_m, rel=0.01)
    assert later.scale == profile.scale
    assert np.trace(later.habits.information) > np.trace(profile.habits.information)
    for name in POINTS:
        known, unknown = (
            np.linalg.norm(errors_m(run[1:COUNT], moving.truths[1:COUNT], name), axis=1).mean()
            for run in (estimates, first[1])
        )
        assert known < unknown + WORSE_M


def test_another_body_under_the_name_is_learned_anew(moving, first):
    own = first[0].profile
    other = make_profile(1.3 * own.scale, own.habits, 1.3 * own.forearm_length_m, 50)
    tracker, estimates = with_profile(moving, other)
    assert any(estimate.reason == TrackingReason.OTHER_BODY for estimate in estimates)
    later = tracker.profile
    assert later.pairs == own.pairs
    assert later.forearm_length_m == pytest.approx(own.forearm_length_m, rel=0.05)
    assert later.scale == pytest.approx(own.scale, rel=0.1)
