"""Whatever the cameras deliver, the tracker answers with a status and a reason, never with an exception."""

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from common.cameras.camera import Frame
from common.messages import TrackingStatus
from local_site.simulation.cameras import exact_rig
from local_site.simulation.config import StereoConfig
from local_site.tracking.annotate import annotate
from local_site.tracking.silhouette.silhouette_tracker import SilhouetteTracker
from local_site.tracking.tracker import View, Views

RIG = exact_rig(StereoConfig())


def picture(kind, height, width, colour, seed):
    random = np.random.default_rng(seed)
    shape = (height, width, 3) if colour else (height, width)
    if kind == "noise":
        return random.integers(0, 256, shape, dtype=np.uint8)
    image = np.full(shape, 255 if kind == "white" else 8, dtype=np.uint8)
    if kind == "blobs":
        for _ in range(4):
            y, x = random.integers(0, max(height - 8, 1)), random.integers(0, max(width - 8, 1))
            image[y : y + height // 3, x : x + random.integers(4, width + 5)] = random.integers(60, 255)
    return image


def tracked(tracker, images, t_ns=0, seq=0):
    return tracker.track(Views(t_ns, tuple(View(Frame(image, t_ns, seq)) for image in images)))


@settings(max_examples=25, deadline=None, derandomize=True)
@given(
    st.sampled_from(["noise", "white", "black", "blobs"]),
    st.integers(1, 300),
    st.integers(1, 300),
    st.booleans(),
    st.integers(0, 99),
)
def test_any_picture_gives_a_status(kind, height, width, colour, seed):
    tracker = SilhouetteTracker(RIG)
    for k in range(3):
        images = [picture(kind, height, width, colour, seed + k + camera) for camera in (0, 50)]
        estimate = tracked(tracker, images, k * 33_000_000, k)
        assert estimate.reason or estimate.status is TrackingStatus.TRACKED
        assert (estimate.wrist is None) == (estimate.status is TrackingStatus.LOST)
        assert annotate(images[0], estimate, 0).shape == (height, width, 3)


@pytest.mark.parametrize("image", [np.empty((0, 0), np.uint8), np.zeros((480, 640)), np.zeros((480, 640, 1), np.uint8)])
def test_pictures_of_a_wrong_kind_are_lost_with_a_reason(image):
    estimate = tracked(SilhouetteTracker(RIG), [image, image])
    assert estimate.status is TrackingStatus.LOST
    assert "left:" in estimate.reason
    assert "right:" in estimate.reason


def test_a_wrong_number_of_views_is_lost():
    image = np.zeros((480, 640), np.uint8)
    estimate = tracked(SilhouetteTracker(RIG), [image])
    assert estimate.status is TrackingStatus.LOST
    assert "1 views for 2 calibrated cameras" in estimate.reason
