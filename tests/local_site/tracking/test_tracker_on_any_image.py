"""Whatever the cameras deliver, the tracker answers with a status and a reason, never with an exception."""

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from common.cameras.camera import Frame
from common.messages.hand import TrackingStatus
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
    if kind == "salt":
        return np.where(random.random(shape) < 0.02, 255, 9).astype(np.uint8)
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
    st.sampled_from(["noise", "salt", "white", "black", "blobs"]),
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


@pytest.mark.parametrize(
    "image",
    [
        np.empty((0, 0), np.uint8),
        np.empty((0, 640), np.uint8),
        np.zeros((1, 1), np.uint8),
        np.zeros((480, 640)),
        np.full((480, 640), np.nan, np.float32),
        np.zeros((480, 640), np.uint16),
        np.zeros((480, 640), bool),
        np.zeros(640, np.uint8),
        np.zeros((480, 640, 1), np.uint8),
        np.zeros((480, 640, 4), np.uint8),
        np.zeros((2, 480, 640, 3), np.uint8),
    ],
    ids=lambda image: f"{image.dtype}-{image.shape}",
)
def test_pictures_of_a_wrong_kind_are_lost_with_a_reason(image):
    estimate = tracked(SilhouetteTracker(RIG), [image, image])
    assert estimate.status is TrackingStatus.LOST
    assert "left:" in estimate.reason
    assert "right:" in estimate.reason


def spoilt(picture, kind, random):
    """An arm's picture made hard to read."""
    if kind == "huge noise":
        return np.clip(picture + random.normal(0, 120, picture.shape), 0, 255).astype(np.uint8)
    if kind == "negative":
        return 255 - picture
    if kind == "cut":
        return np.ascontiguousarray(picture[: random.integers(40, 480), : random.integers(40, 640)])
    if kind == "torn":
        rows = random.integers(1, 470)
        return np.vstack([picture[rows:], picture[:rows]])
    if kind == "scaled":
        return np.ascontiguousarray(picture[::3, ::3])
    colours = np.repeat(picture[..., None], 3, axis=2)
    return colours if kind == "colours" else np.asfortranarray(colours)[:, ::-1]


@pytest.mark.slow
@settings(max_examples=8, deadline=None, derandomize=True)
@given(
    st.sampled_from(["huge noise", "negative", "cut", "torn", "scaled", "colours", "strided"]),
    st.sampled_from([(0,), (1,), (0, 1)]),
    st.integers(0, 99),
)
def test_any_spoilt_picture_of_an_arm_gives_a_status(moving, kind, cameras, seed):
    tracker, random = SilhouetteTracker(RIG), np.random.default_rng(seed)
    for k in range(14):
        pictures = list(moving.pictures[k])
        if k in (0, 2, 12, 13):
            for camera in cameras:
                pictures[camera] = spoilt(pictures[camera], kind, random)
        estimate = tracked(tracker, pictures, k * 33_000_000, k)
        assert estimate.reason or estimate.status is TrackingStatus.TRACKED
        assert (estimate.wrist is None) == (estimate.status is TrackingStatus.LOST)
        points = [getattr(estimate, name) for name in ("elbow", "wrist", "index", "thumb")]
        assert all(point is None or np.isfinite(point).all() for point in points)
        assert all(np.isfinite(covariance).all() for covariance in estimate.covariances.values())


def test_clocks_that_stand_still_or_run_back_give_a_status(moving):
    tracker = SilhouetteTracker(RIG)
    for k, t_ns in enumerate([0, 33, 33, 33, 10, 5_000_000_000, 33, -7]):
        views = moving.views(k)
        estimate = tracker.track(Views(t_ns * 1_000_000, views.views))
        assert estimate.status in (TrackingStatus.INITIALISING, TrackingStatus.TRACKED, TrackingStatus.DEGRADED)


def test_a_wrong_number_of_views_is_lost():
    image = np.zeros((480, 640), np.uint8)
    estimate = tracked(SilhouetteTracker(RIG), [image])
    assert estimate.status is TrackingStatus.LOST
    assert "1 views for 2 calibrated cameras" in estimate.reason
