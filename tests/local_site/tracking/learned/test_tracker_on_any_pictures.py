"""Whatever the cameras deliver, the tracker for ordinary rooms answers with a status and a reason."""

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from common.cameras.camera import Frame
from common.errors import CalibrationError
from common.messages.hand import TrackingStatus
from local_site.tracking.annotate import annotate
from local_site.tracking.landmarks.view_hands import ViewHands
from local_site.tracking.learned import learned_tracker
from local_site.tracking.learned.learned_tracker import LearnedTracker
from local_site.tracking.tracker import View, Views
from tests.local_site.tracking.landmarks.fake_networks import fake_follower, middle_palm, palm_outputs, upright_hand
from tests.local_site.tracking.landmarks.seen_hands import PAIR_RIG
from tests.local_site.tracking.rendered_arm import ABOVE, ASIDE, PAIR, rig_of
from tests.local_site.tracking.test_tracker_on_any_image import picture

PERIOD_NS = 33_000_000


def tracker_with(monkeypatch, palms, rig=PAIR_RIG):
    """A tracker whose networks see the same palms and hands in every picture."""

    def view_hands(rig, right_arm):
        return [ViewHands(camera, fake_follower(palms, upright_hand), right_arm) for camera in rig.cameras]

    monkeypatch.setattr(learned_tracker, "view_hands", view_hands)
    return LearnedTracker(rig)


def no_palm(_):
    return palm_outputs([])


def tracked(tracker, images, k=0):
    return tracker.track(Views(k * PERIOD_NS, tuple(View(Frame(image, k * PERIOD_NS, k)) for image in images)))


def is_answered(estimate):
    points = [getattr(estimate, name) for name in ("elbow", "wrist", "index", "thumb")]
    return (
        (bool(estimate.reason) or estimate.status is TrackingStatus.TRACKED)
        and all(point is None or bool(np.isfinite(point).all()) for point in points)
        and all(bool(np.isfinite(covariance).all()) for covariance in estimate.covariances.values())
    )


@settings(max_examples=12, deadline=None, derandomize=True)
@given(
    st.sampled_from(["noise", "salt", "white", "black", "blobs"]),
    st.integers(8, 300),
    st.integers(8, 300),
    st.booleans(),
    st.booleans(),
    st.integers(0, 99),
)
def test_any_picture_gives_a_status(kind, height, width, colour, sees_palms, seed):
    with pytest.MonkeyPatch.context() as patch:
        tracker = tracker_with(patch, middle_palm if sees_palms else no_palm)
        for k in range(3):
            images = [picture(kind, height, width, colour, seed + k + camera) for camera in (0, 50)]
            estimate = tracked(tracker, images, k)
            assert is_answered(estimate)
            assert annotate(images[0], estimate, 0).shape == (height, width, 3)


@pytest.mark.slow
@pytest.mark.parametrize("palms", [no_palm, middle_palm])
@pytest.mark.parametrize(
    "image",
    [
        np.zeros((480, 640), np.uint8),
        np.zeros((480, 640, 1), np.uint8),
        np.zeros((480, 640, 4), np.uint8),
        np.asfortranarray(np.full((480, 640, 3), 90, np.uint8)),
        np.full((480, 640, 3), 90, np.uint8)[::2, ::-2],
    ],
    ids=lambda image: f"{image.dtype}-{image.shape}",
)
def test_grey_and_strided_pictures_are_read(monkeypatch, image, palms):
    tracker = tracker_with(monkeypatch, palms)
    assert all(is_answered(tracked(tracker, [image, image], k)) for k in range(12))


@pytest.mark.parametrize(
    "image",
    [
        np.zeros((1, 1), np.uint8),
        np.zeros((480, 640), np.uint16),
        np.zeros(640, np.uint8),
        np.empty((0, 0), np.uint8),
        np.empty((0, 640), np.uint8),
        np.zeros((480, 1), np.uint8),
        np.zeros((480, 640)),
        np.zeros((480, 640, 3)),
        np.full((480, 640), np.nan, np.float32),
        np.zeros((480, 640), bool),
        np.zeros((2, 480, 640, 3), np.uint8),
    ],
    ids=lambda image: f"{image.dtype}-{image.shape}",
)
def test_pictures_of_a_wrong_kind_are_answered(monkeypatch, image):
    for palms in (no_palm, middle_palm):
        tracker = tracker_with(monkeypatch, palms)
        for k in range(12):
            estimate = tracked(tracker, [image, image], k)
            assert is_answered(estimate)
            assert estimate.status is not TrackingStatus.TRACKED


@pytest.mark.parametrize("palms", [no_palm, middle_palm])
def test_pictures_may_change_their_size_on_the_way(monkeypatch, palms):
    tracker = tracker_with(monkeypatch, palms)
    for k, size in enumerate([(480, 640), (480, 640), (240, 320), (720, 1280), (480, 640), (99, 33)] * 4):
        assert is_answered(tracked(tracker, [np.full((*size, 3), 90, np.uint8)] * 2, k))


@pytest.mark.parametrize("count", [0, 1, 3])
def test_another_number_of_views_is_answered(monkeypatch, count):
    tracker = tracker_with(monkeypatch, middle_palm)
    for k in range(3):
        estimate = tracked(tracker, [np.full((480, 640, 3), 90, np.uint8)] * count, k)
        assert is_answered(estimate)
        assert f"{count} views for 2 calibrated cameras" in estimate.reason


def test_clocks_that_stand_still_or_run_back_give_a_status(monkeypatch):
    tracker = tracker_with(monkeypatch, middle_palm)
    image = np.full((480, 640, 3), 90, np.uint8)
    for k in (0, 1, 1, 1, 0, 150, 2, -7):
        assert is_answered(tracked(tracker, [image, image], k))


def test_five_cameras_are_refused(monkeypatch):
    with pytest.raises(CalibrationError, match="4 cameras at most"):
        tracker_with(monkeypatch, no_palm, rig_of([c.projection for c in (*PAIR, ABOVE, ASIDE, ABOVE)]))
