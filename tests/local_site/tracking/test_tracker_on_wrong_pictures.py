"""Pictures that cannot come from the calibrated cameras: exchanged, mirrored, upside down, of one camera."""

import numpy as np
import pytest

from common.messages.hand import TrackingStatus
from local_site.simulation.config import MotionConfig
from local_site.tracking.silhouette.silhouette_tracker import SilhouetteTracker
from tests.local_site.tracking.rendered_arm import render_sequence, rig_of

FRAMES = 14
ASIDE = MotionConfig(name="figure_of_eight", still_s=0.2, wrist=(0.38, 0.40, 0.60), shoulder=(0.76, 0.24, 0.40))

REACHING = MotionConfig(name="pick_and_place", still_s=0.0)
SINCE_S = 1.0
# Of the tangents to both silhouettes: measured at most 0.31 px, and of wrong pictures at least 2.0 px in the middle.
RIGHT_PX, WRONG_PX = 0.5, 1.4


@pytest.fixture(scope="module", params=[REACHING, ASIDE], ids=["reaching", "aside"])
def sequence(request):
    """The arm in the middle of the volume and beside it."""
    return render_sequence(request.param, FRAMES, since_s=SINCE_S)


def mirrored(picture):
    return np.ascontiguousarray(picture[:, ::-1])


def upside_down(picture):
    return np.ascontiguousarray(picture[::-1])


WRONG = {
    "exchanged": lambda p: (p[1], p[0]),
    "both mirrored": lambda p: (mirrored(p[0]), mirrored(p[1])),
    "right mirrored": lambda p: (p[0], mirrored(p[1])),
    "both upside down": lambda p: (upside_down(p[0]), upside_down(p[1])),
    "left upside down": lambda p: (upside_down(p[0]), p[1]),
    "left mirrored": lambda p: (mirrored(p[0]), p[1]),
    "left twice": lambda p: (p[0], p[0]),
    "right twice": lambda p: (p[1], p[1]),
}


@pytest.mark.slow
@pytest.mark.parametrize("wrong", list(WRONG))
def test_wrong_pictures_are_never_tracked(sequence, wrong):
    estimates = sequence.tracked(SilhouetteTracker(rig_of(sequence.projections, 3.0)), WRONG[wrong])
    assert all(e.status is not TrackingStatus.TRACKED for e in estimates)
    assert all(e.reason for e in estimates)
    assert np.median([e.residual_px for e in estimates if e.residual_px is not None]) > WRONG_PX


def test_the_same_pictures_put_right_are_tracked(sequence):
    tracker = SilhouetteTracker(rig_of(sequence.projections, 3.0))
    sequence.tracked(tracker, WRONG["left upside down"])
    estimates = sequence.tracked(tracker)
    assert estimates[-1].status is TrackingStatus.TRACKED
    assert max(e.residual_px for e in estimates) < RIGHT_PX
