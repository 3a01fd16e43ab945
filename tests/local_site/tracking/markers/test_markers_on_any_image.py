"""Whatever the cameras deliver, the marker tracker answers with a status and a reason, never with an exception."""

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from common.cameras.camera import Frame
from common.messages.hand import TrackingStatus
from local_site.tracking.annotate import annotate
from local_site.tracking.markers.marker_tracker import MarkerTracker
from local_site.tracking.tracker import View, Views
from tests.local_site.tracking.markers.marker_scene import (
    Scene,
    four_cameras,
    hand_at,
    rig_of,
)

RIG = rig_of(four_cameras()[:2])


def picture(kind, height, width, colour, seed):
    random = np.random.default_rng(seed)
    shape = (height, width, 3) if colour else (height, width)
    if kind == "noise":
        return random.integers(0, 256, shape, dtype=np.uint8)
    image = np.full(shape, 255 if kind == "white" else 8, dtype=np.uint8)
    if kind == "spots":
        for _ in range(random.integers(1, 20)):
            y, x = random.integers(0, max(height - 3, 1)), random.integers(0, max(width - 3, 1))
            image[y : y + random.integers(1, 12), x : x + random.integers(1, 12)] = random.integers(60, 255)
    return image


def tracked(tracker, images, t_ns=0, seq=0):
    return tracker.track(Views(t_ns, tuple(View(Frame(image, t_ns, seq)) for image in images)))


@settings(max_examples=60, deadline=None, derandomize=True)
@given(
    st.sampled_from(["noise", "white", "black", "spots", "spots", "spots"]),
    st.integers(1, 300),
    st.integers(1, 400),
    st.booleans(),
    st.integers(0, 999),
    st.integers(2, 4),
)
def test_any_picture_gives_a_status(kind, height, width, colour, seed, views):
    tracker = MarkerTracker(rig_of(four_cameras()[:views]))
    for k in range(3):
        images = [picture(kind, height, width, colour, seed + k + 50 * camera) for camera in range(views)]
        estimate = tracked(tracker, images, k * 33_000_000, k)
        assert estimate.reason or estimate.status is TrackingStatus.TRACKED
        assert annotate(images[0], estimate, 0).shape == (height, width, 3)


@pytest.mark.slow
@settings(max_examples=15, deadline=None, derandomize=True)
@given(st.integers(0, 999))
def test_any_lights_after_a_hand_was_learned_give_a_status(seed):
    scene = Scene()
    scene.learn()
    for k in range(3):
        estimate = tracked(
            scene.tracker,
            [picture("spots", 480, 640, False, seed + k + c) for c in (0, 50)],
            (20 + k) * 33_000_000,
            20 + k,
        )
        assert estimate.reason or estimate.status is TrackingStatus.TRACKED
    assert scene.step(hand_at()) is not None


@pytest.mark.parametrize(
    "image",
    [np.empty((0, 0), np.uint8), np.zeros((480, 640)), np.zeros((480, 640, 1), np.uint8), np.zeros(5, np.uint8)],
)
def test_pictures_of_a_wrong_kind_are_lost_with_a_reason(image):
    estimate = tracked(MarkerTracker(RIG), [image, image])
    assert estimate.status is TrackingStatus.LOST
    assert "camera 0:" in estimate.reason
    assert "camera 1:" in estimate.reason


def test_a_wrong_number_of_views_is_lost():
    estimate = tracked(MarkerTracker(RIG), [np.zeros((480, 640), np.uint8)])
    assert estimate.status is TrackingStatus.LOST
    assert "1 views for 2 calibrated cameras" in estimate.reason
