"""The monocular tracker on films whose truth is known: how well it follows, and that it reports when it does not."""

import numpy as np
import pytest

from common.errors import CalibrationError
from common.messages.hand import TrackingStatus
from local_site.simulation.hazel import Swing
from local_site.tracking.config import MonocularConfig, StartConfig
from local_site.tracking.monocular.monocular_tracker import MonocularTracker
from local_site.tracking.tracker import Views
from tests.local_site.tracking.monocular.hazel_scene import (
    PERIOD_NS,
    RIG,
    arms,
    pictures,
    tracker_for,
    views,
)
from tests.present import present

FRAMES, FASTER = 24, 2.0


@pytest.fixture(scope="module")
def film():
    """Twice as fast as HAZEL-S, so that few frames show much motion."""
    shown = arms(FRAMES, Swing(speed=FASTER))
    return shown, pictures(shown)


def off_mm(estimate, arm):
    return [1e3 * np.linalg.norm(estimate.elbow - arm.elbow), 1e3 * np.linalg.norm(estimate.wrist - arm.wrist)]


@pytest.mark.slow
@pytest.mark.parametrize(("setting", "most_mm"), [("live", 1.3), ("accurate", 0.8)])
def test_a_swinging_arm_is_followed(film, setting, most_mm):
    shown, images = film
    tracker = tracker_for(shown[0], setting)
    found = [tracker.track(views(image, k)) for k, image in enumerate(images)]
    assert {e.status for e in found} <= {TrackingStatus.TRACKED, TrackingStatus.DEGRADED}
    errors = np.array([off_mm(e, arm) for e, arm in zip(found, shown, strict=True)])
    assert errors.mean(axis=0).max() < most_mm
    last = found[-1]
    assert last.index is None
    assert last.thumb is None
    assert "index and thumb are not measured" in last.reason
    elbow, wrist, palm = (present(getattr(last, name)) for name in ("elbow", "wrist", "palm"))
    along = (wrist - elbow) / np.linalg.norm(wrist - elbow)
    np.testing.assert_allclose(palm - wrist, 0.06 * along, atol=1e-9)
    for name in ("elbow", "wrist", "palm"):
        assert np.linalg.eigvalsh(last.covariances[name]).min() > 0
        assert np.sqrt(np.trace(last.covariances[name])) < 0.004


def test_a_changing_light_does_not_matter(film):
    shown, images = film
    tracker = tracker_for(shown[0])
    darker = [(image * (1.0 - 0.02 * k)).astype(np.uint8) for k, image in enumerate(images)]
    found = [tracker.track(views(image, k)) for k, image in enumerate(darker)]
    assert np.mean([off_mm(e, arm) for e, arm in zip(found, shown, strict=True)]) < 1.5


def test_a_loss_is_told_and_the_arm_found_again_where_it_was(film):
    shown, images = film
    tracker = tracker_for(shown[0])
    random = np.random.default_rng(1)
    for k in range(8):
        assert tracker.track(views(images[k], k)).status is TrackingStatus.TRACKED
    for k in range(8, 11):
        lost = tracker.track(views(random.integers(0, 255, images[0].shape).astype(np.uint8), k))
        assert lost.status is TrackingStatus.LOST
        assert lost.reason
        assert lost.wrist is None
        assert tracker.pose is None
    again = [tracker.track(views(images[7], k)) for k in range(11, 14)]
    assert again[-1].status is TrackingStatus.TRACKED
    assert max(off_mm(again[-1], shown[7])) < 2.0


def test_what_is_far_off_is_never_called_tracked(film):
    """Frames are left out until the arm cannot be followed any more."""
    shown, images = film
    for leap in (4, 8, 12):
        tracker = tracker_for(shown[0])
        for k in range(0, FRAMES, leap):
            estimate = tracker.track(views(images[k], k))
            if estimate.status is TrackingStatus.TRACKED:
                assert max(off_mm(estimate, shown[k])) < 50.0


def test_an_even_picture_has_too_few_points(film):
    shown, images = film
    tracker = tracker_for(shown[0])
    assert "fewer than 100 points" in tracker.track(views(np.full_like(images[0], 90), 0)).reason


def test_a_start_that_cannot_be_right_is_refused_with_its_cure(film):
    shown, images = film
    bare = MonocularTracker(RIG).track(views(images[0], 0))
    assert bare.status is TrackingStatus.LOST
    assert "--joints" in bare.reason
    start = StartConfig(shoulder_px=(100.0, 100.0), elbow_px=(300.0, 100.0), wrist_px=(340.0, 100.0))
    unequal = MonocularTracker(RIG, MonocularConfig(start=start)).track(views(images[0], 0))
    assert "parallel to the picture" in unequal.reason
    outside = StartConfig(shoulder_px=(2000.0, 100.0), elbow_px=(2140.0, 100.0), wrist_px=(2259.0, 100.0))
    beside = MonocularTracker(RIG, MonocularConfig(start=outside)).track(views(images[0], 0))
    assert "out of the picture" in beside.reason
    assert "2 views" in tracker_for(shown[0]).track(Views(PERIOD_NS, views(images[0], 0).views * 2)).reason
    with pytest.raises(CalibrationError, match="there is no camera 2"):
        MonocularTracker(RIG, MonocularConfig(camera=2))
