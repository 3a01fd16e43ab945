"""A left arm where a right one is expected, as exchanged and mirrored pictures show it, is reported, never tracked."""

import numpy as np
import pytest

from common.messages.hand import TrackingStatus
from local_site.simulation.config import MotionConfig
from local_site.tracking.config import SilhouetteConfig
from local_site.tracking.silhouette.silhouette_tracker import SilhouetteTracker
from local_site.tracking.tracker import TrackingReason
from tests.local_site.tracking.rendered_arm import render_sequence, rig_of

FRAMES = 14


@pytest.fixture(scope="module", params=["pick_and_place", "rotate_x"])
def sequence(request):
    return render_sequence(MotionConfig(name=request.param, still_s=0.0), FRAMES, since_s=1.0)


def exchanged_and_mirrored(pictures):
    """The pictures of a mirrored world: before two cameras alike on both sides, all of them fits together."""
    left, right = pictures
    return np.ascontiguousarray(right[:, ::-1]), np.ascontiguousarray(left[:, ::-1])


def as_they_are(pictures):
    return pictures


@pytest.mark.slow
@pytest.mark.parametrize(
    ("shown", "right_arm"),
    [(exchanged_and_mirrored, True), (as_they_are, False)],
    ids=["mirrored world", "wrongly set"],
)
def test_the_other_arm_is_told_and_never_tracked(sequence, shown, right_arm):
    tracker = SilhouetteTracker(rig_of(sequence.projections, 3.0), SilhouetteConfig(right_arm=right_arm))
    estimates = sequence.tracked(tracker, shown)
    assert {e.status for e in estimates} == {TrackingStatus.INITIALISING}
    assert not any(e.reason.startswith(TrackingReason.OTHER_ARM) for e in estimates[:9])
    assert all(e.reason.startswith(TrackingReason.OTHER_ARM) for e in estimates[9:])
    assert max(e.residual_px for e in estimates) < 0.5


@pytest.mark.parametrize(
    ("shown", "right_arm"), [(as_they_are, True), (exchanged_and_mirrored, False)], ids=["right arm", "left arm"]
)
def test_the_arm_that_is_expected_is_tracked(sequence, shown, right_arm):
    tracker = SilhouetteTracker(rig_of(sequence.projections, 3.0), SilhouetteConfig(right_arm=right_arm))
    estimates = sequence.tracked(tracker, shown)
    assert estimates[-1].status is TrackingStatus.TRACKED
    assert not any(TrackingReason.OTHER_ARM in e.reason for e in estimates)
