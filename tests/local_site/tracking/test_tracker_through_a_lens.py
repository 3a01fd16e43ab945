"""A bent lens changes neither what is tracked nor where it is drawn."""

import numpy as np
import pytest

from common.cameras.camera import Frame
from local_site.simulation.cameras import calibrate_simulated
from local_site.simulation.config import MotionConfig, SimulationConfig, StereoConfig
from local_site.simulation.operator import SimulatedOperator
from local_site.tracking.config import SilhouetteConfig
from local_site.tracking.silhouette.silhouette_tracker import SilhouetteTracker
from local_site.tracking.tracker import View, Views

BENT_K1 = -0.2
PAIRS, PERIOD_NS = 6, 33_333_333
SAME_M, DRAWN_PX = 0.006, 3.0


def last_estimate(k1):
    config = SimulationConfig(stereo=StereoConfig(k1=k1), motion=MotionConfig(name="hold"))
    operator, rig = SimulatedOperator(config), calibrate_simulated(config)
    tracker = SilhouetteTracker(rig, SilhouetteConfig(initial_pairs=1))
    for k in range(PAIRS):
        images = operator.render(k * PERIOD_NS / 1e9)
        frames = tuple(View(Frame(image, k * PERIOD_NS, k)) for image in images)
        estimate = tracker.track(Views(k * PERIOD_NS, frames))
    return estimate, rig, images


@pytest.fixture(scope="module")
def bent():
    return last_estimate(BENT_K1)


def test_the_arm_is_where_a_straight_lens_sees_it(bent):
    straight, _, _ = last_estimate(0.0)
    for name in ("elbow", "wrist", "index", "thumb"):
        assert np.linalg.norm(getattr(bent[0], name) - getattr(straight, name)) < SAME_M


def test_the_overlay_lies_on_the_picture_as_taken(bent):
    estimate, rig, images = bent
    for camera, overlay, image in zip(rig.cameras, estimate.overlays, images, strict=True):
        assert camera.lens is not None
        columns = np.flatnonzero((image > 60).any(axis=0))
        assert abs(overlay.contour[:, 0].min() - columns[0]) < DRAWN_PX
        assert abs(overlay.contour[:, 0].max() - columns[-1]) < DRAWN_PX
