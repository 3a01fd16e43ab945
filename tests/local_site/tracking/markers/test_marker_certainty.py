"""The certainty that the marker tracker reports: a covariance for each point it gives, and the views' residual."""

from dataclasses import replace

import numpy as np
import pytest
from scipy.spatial.transform import Rotation

from common.messages.hand import TrackingStatus
from local_site.tracking.drift import DriftConfig, DriftWatch
from local_site.tracking.markers.marker_tracker import MarkerTracker
from tests.local_site.tracking.markers.marker_scene import (
    Scene,
    error_mm,
    four_cameras,
    hand_at,
    moving_hand,
    rig_of,
    without,
)
from tests.present import present


def nodding(camera, degrees):
    """A camera that was bumped after calibration."""
    nod = Rotation.from_euler("x", degrees, degrees=True).as_matrix()
    return replace(camera, camera_R_operator=nod @ camera.camera_R_operator)


def scene_with_bump(degrees):
    """A scene whose right camera nods after the hand was learned."""
    left, right = four_cameras()[:2]
    scene = Scene((left, right), MarkerTracker(rig_of((left, right))))
    scene.learn()
    scene.cameras = (left, nodding(right, degrees))
    return scene


def test_every_point_that_is_there_has_a_covariance_of_the_size_of_its_error():
    scene = Scene()
    scene.learn()
    squares = []
    for k in range(30):
        points = moving_hand(4 * k)
        estimate = scene.step(points, noise=2.0, seed=k)
        assert list(estimate.covariances) == ["wrist", "index", "thumb"]
        sigmas = [1e3 * np.sqrt(np.trace(covariance)) for covariance in estimate.covariances.values()]
        squares.append((error_mm(estimate, points) / sigmas) ** 2)
    # Drawn by an exact rig, so that the calibration's part of sigma has no counterpart in the error.
    assert 0.05 < np.mean(squares) < 1.5


def test_a_hidden_marker_has_none():
    scene = Scene()
    scene.learn()
    estimate = scene.step(without(hand_at(), "index"))
    assert sorted(estimate.covariances) == ["thumb", "wrist"]


def test_the_residual_is_small_while_the_cameras_stand_and_grows_with_a_bump():
    assert present(Scene().learn()[-1].residual_px) < 0.2
    degrees, px_per_degree = 0.15, np.pi / 180 * four_cameras()[0].focal_px
    estimate = scene_with_bump(degrees).step(hand_at())
    assert estimate.status is not TrackingStatus.LOST
    # The Sampson distance splits a vertical offset of one view between both: about 1/sqrt(2) of it.
    assert estimate.residual_px == pytest.approx(degrees * px_per_degree / np.sqrt(2), rel=0.15)


def test_a_residual_for_which_the_arm_is_refused_is_told_too():
    estimate = scene_with_bump(0.45).step(hand_at())
    assert (estimate.status, estimate.wrist) == (TrackingStatus.LOST, None)
    assert estimate.residual_px > 2.0


def test_there_is_no_residual_without_markers():
    scene = Scene()
    scene.learn()
    assert scene.step(without(hand_at(), "wrist", "index", "thumb")).residual_px is None


def test_a_bumped_camera_rings_the_drift_alarm():
    config = DriftConfig(learn_s=1.0, window_s=1.0, min_residuals=10)
    scene = Scene((cameras := four_cameras()[:2]), MarkerTracker(rig := rig_of(cameras)))
    told: list[str] = []
    watch = DriftWatch(rig, config, told.append)
    judged = [watch.judge(scene.step(moving_hand(k))) for k in range(70)]
    assert told == []
    scene.cameras = (cameras[0], nodding(cameras[1], 0.3))
    after = [watch.judge(scene.step(moving_hand(k))) for k in range(70, 130)]
    assert not any("calibrate again" in estimate.reason for estimate in judged)
    assert after[-1].reason.endswith("calibrate again")
    assert len(told) == 1
