"""The marker tracker on drawn hands: learning, hidden markers, stray lights, views that do not fit, more cameras."""

import numpy as np
import pytest

from common.cameras.camera import Frame
from common.geometry import rotation_from_vector, transform
from common.messages.hand import TrackingStatus
from local_site.tracking.config import MarkersConfig
from local_site.tracking.markers.marker_tracker import MarkerTracker
from local_site.tracking.tracker import View, Views
from tests.local_site.tracking.markers.marker_scene import (
    HAND,
    NAMES,
    PERIOD_NS,
    Scene,
    draw,
    error_mm,
    four_cameras,
    hand_at,
    moving_hand,
    rig_of,
    without,
)
from tests.present import present

DEGRADED, INITIALISING, LOST, TRACKED = (
    TrackingStatus.DEGRADED,
    TrackingStatus.INITIALISING,
    TrackingStatus.LOST,
    TrackingStatus.TRACKED,
)


def raised(points, metres):
    """The points raised by this much."""
    return points + np.array([0.0, 0.0, metres])


@pytest.fixture
def learned():
    scene = Scene()
    scene.learn()
    return scene


@pytest.mark.slow
def test_the_hand_is_learned_and_then_tracked_with_all_cameras():
    for views in (2, 3, 4):
        scene = Scene(four_cameras()[:views])
        assert [e.status for e in scene.learn()] == [INITIALISING] * 10
        for k in range(12):
            points = moving_hand(6 * k)
            estimate = scene.step(points, noise=2.0, seed=k)
            assert (estimate.status, estimate.reason, estimate.elbow) == (TRACKED, "", None)
            assert error_mm(estimate, points).max() < 0.5
            assert len(estimate.overlays) == views


def test_overlays_show_the_spots_where_the_picture_has_them(learned):
    estimate = learned.step(hand_at())
    for overlay, camera in zip(estimate.overlays, learned.cameras, strict=True):
        for name, point in zip(NAMES, hand_at(), strict=True):
            assert getattr(overlay, name) == pytest.approx(camera.pixels(camera.to_camera(point)), abs=0.1)


def test_learning_waits_for_a_hand_that_keeps_its_shape():
    scene = Scene()
    for k in range(15):
        estimate = scene.step(hand_at(shape=HAND * (1.0 + 0.02 * (k % 8))))
        assert estimate.status is INITIALISING
    assert "U shape" in estimate.reason
    scene.learn()
    assert scene.step(hand_at()).status is TRACKED


def test_two_markers_do_not_start_it():
    scene = Scene()
    estimate = scene.step(without(hand_at(), "thumb"))
    assert estimate.status is INITIALISING
    assert estimate.wrist is None
    assert "wrist, index and thumb" in estimate.reason


@pytest.mark.parametrize("name", NAMES)
def test_a_hidden_marker_is_none_while_the_others_go_on_and_known_again_on_return(learned, name):
    for k in range(12):
        points = moving_hand(k)
        estimate = learned.step(without(points, name))
        assert estimate.status is DEGRADED
        assert f"the {name} marker is hidden" in estimate.reason
        errors = error_mm(estimate, points)
        assert np.isnan(errors).tolist() == [name == other for other in NAMES]
        assert np.nanmax(errors) < 0.5
    points = moving_hand(12)
    assert error_mm(learned.step(points), points).max() < 0.5


def test_a_marker_that_one_of_two_cameras_sees_is_hidden(learned):
    estimate = learned.step(hand_at(), {1: without(hand_at(), "index")})
    assert (estimate.status, estimate.index) == (DEGRADED, None)


def test_after_darkness_all_three_are_found_anywhere_but_two_are_not_guessed(learned):
    for _ in range(9):
        assert learned.step(without(hand_at(), *NAMES)).status is LOST
    elsewhere = hand_at((-0.12, 0.0, 0.1), (0.5, 0.2, 0.3))
    assert learned.step(without(elsewhere, "index")).status is LOST
    estimate = learned.step(elsewhere)
    assert estimate.status is TRACKED
    assert error_mm(estimate, elsewhere).max() < 0.5


@pytest.mark.parametrize("stray", [(0.1, 0.0, 0.05), (-0.12, 0.03, 0.12), (-0.05, 0.05, -0.1)])
def test_a_stray_light_changes_nothing(learned, stray):
    points = hand_at((0.01, 0.0, 0.01))
    estimate = learned.step(np.vstack([points, points[0] + stray]), levels=(220.0, 220.0, 220.0, 255.0))
    assert error_mm(estimate, points).max() < 0.5


@pytest.mark.parametrize("levels", [(255.0, 120.0, 180.0), (120.0, 255.0, 180.0), (100.0, 100.0, 255.0)])
def test_brightness_does_not_say_who_is_who(levels):
    scene = Scene()
    scene.learn(levels=levels[::-1])
    for k in range(5):
        points = moving_hand(5 * k)
        assert error_mm(scene.step(points, levels=levels), points).max() < 0.6


def test_a_jump_between_two_frames_is_followed(learned):
    for metres in (0.05, -0.08, 0.15):
        points = hand_at((metres, 0.0, 0.0))
        assert error_mm(learned.step(points), points).max() < 0.5


def test_views_out_of_sync_are_told(learned):
    points = hand_at()
    told = [learned.step(points, {1: raised(points, rise)}) for rise in (0.006, 0.030)]
    assert told[0].status is DEGRADED
    assert told[1].status is LOST
    assert all("out of sync" in estimate.reason for estimate in told)


def test_swapped_cameras_are_refused():
    cameras = four_cameras()[:2]
    scene = Scene(cameras, MarkerTracker(rig_of(cameras[::-1])))
    for k in range(12):
        estimate = scene.step(moving_hand(k))
        assert estimate.status is not TRACKED
        assert estimate.wrist is None


def test_a_third_camera_that_disagrees_or_is_blind_is_left_out_and_told():
    scene = Scene(four_cameras()[:3])
    scene.learn()
    points = hand_at()
    for seen in (raised(points, 0.06), without(points, *NAMES)):
        estimate = scene.step(points, {2: seen})
        assert estimate.status is DEGRADED
        assert "camera 2" in estimate.reason
        assert error_mm(estimate, points).max() < 0.5


def in_part(learned, points):
    """An instant in which the first camera sees half of the index marker."""
    pictures = [draw(camera, points) for camera in learned.cameras]
    camera = learned.cameras[0]
    u, v = camera.pixels(camera.to_camera(points[1])).astype(int)
    pictures[0][v - 10 : v + 10, u + 1 : u + 12] = 10
    t_ns = PERIOD_NS * learned.k
    learned.k += 1
    return learned.tracker.track(Views(t_ns, tuple(View(Frame(picture, t_ns, learned.k)) for picture in pictures)))


def test_a_marker_shown_in_part_is_told(learned):
    estimate = in_part(learned, hand_at())
    assert estimate.status is DEGRADED
    assert "index marker is partly hidden" in estimate.reason


def test_a_marker_shown_in_part_does_not_open_or_close_the_hand(learned):
    assert not in_part(learned, opened(1.0)).hand_open
    assert learned.step(opened(1.0)).hand_open
    assert in_part(learned, hand_at()).hand_open


def test_another_hand_is_learned_once_the_known_one_stays_away(learned):
    for _ in range(9):
        learned.step(without(hand_at(), *NAMES))
    other = hand_at((0.1, 0.0, 0.1), shape=1.6 * HAND)
    statuses = [learned.step(other).status for _ in range(80)]
    assert statuses[:30] == [LOST] * 30
    assert statuses[-1] is TRACKED


def opened(share):
    """The hand with its thumb spread away from the index."""
    return hand_at(shape=HAND + share * np.array([[0, 0, 0], [0, 0, 0], [0.02, -0.01, -0.035]]))


def test_the_open_hand_is_told_from_the_grip_with_a_margin(learned):
    shares = np.concatenate([np.linspace(0, 1, 8), np.ones(4), np.linspace(1, 0, 8)])
    told = [learned.step(opened(share)).hand_open for share in shares]
    assert told[0] is False
    assert told[10] is True
    assert told[-1] is False
    assert np.count_nonzero(np.diff(told)) == 2


def test_a_hidden_thumb_leaves_the_hand_as_it_was(learned):
    assert learned.step(opened(1.0)).hand_open
    assert learned.step(without(opened(1.0), "thumb")).hand_open
    assert not learned.step(hand_at()).hand_open
    assert not learned.step(without(opened(1.0), "thumb")).hand_open


def test_a_rigid_motion_of_the_whole_scene_moves_the_result_by_it():
    moved_T_operator = transform(rotation_from_vector(np.array([0.4, -0.9, 1.3])), np.array([0.3, -2.0, 0.7]))
    cameras = four_cameras()[:2]
    rig = rig_of(cameras)
    moved = replace_projections(rig, [c.projection @ np.linalg.inv(moved_T_operator) for c in cameras])
    here, there = Scene(cameras, MarkerTracker(rig)), Scene(cameras, MarkerTracker(moved))
    for k in range(14):
        points = moving_hand(k) if k > 10 else hand_at()
        a, b = here.step(points, noise=2.0, seed=k), there.step(points, noise=2.0, seed=k)
        assert (a.status, a.hand_open) == (b.status, b.hand_open)
        for name in NAMES:
            expected = moved_T_operator[:3, :3] @ getattr(a, name) + moved_T_operator[:3, 3]
            assert getattr(b, name) == pytest.approx(expected, abs=1e-7)


def replace_projections(rig, projections):
    cameras = tuple(
        camera.__class__(camera.name, tuple(tuple(map(float, row)) for row in projection), camera.reprojection_rms_px)
        for camera, projection in zip(rig.cameras, projections, strict=True)
    )
    return rig.__class__(cameras, rig.volume_min, rig.volume_max, rig.error_rms, rig.created)


def test_a_hand_outside_the_volume_is_degraded():
    cameras = four_cameras()[:2]
    rig = rig_of(cameras)
    small = rig.__class__(rig.cameras, (0.0, 0.0, 0.0), (1.0, 1.0, 0.3), rig.error_rms, rig.created)
    scene = Scene(cameras, MarkerTracker(small, MarkersConfig(initial_pairs=1)))
    assert "outside the calibrated volume" in scene.step(hand_at()).reason


def test_cameras_out_of_phase_are_brought_to_one_instant():
    scene = Scene()
    scene.learn()
    errors = []
    for k in range(20):
        # The right camera exposes half a period late: the instant lies between two of its exposures.
        points, before, after = (moving_hand(2 * (k + late)) for late in (0.0, -0.5, 0.5))
        t_ns = (20 + k) * PERIOD_NS
        left = Frame(draw(scene.cameras[0], points), t_ns, k)
        early = Frame(draw(scene.cameras[1], before), t_ns - PERIOD_NS // 2, k)
        late = Frame(draw(scene.cameras[1], after), t_ns + PERIOD_NS // 2, k + 1)
        estimate = present(scene.tracker).track(Views(t_ns, (View(left), View(late, early, 0.5))))
        errors.append(error_mm(estimate, points))
    assert np.max(errors) < 1.0
