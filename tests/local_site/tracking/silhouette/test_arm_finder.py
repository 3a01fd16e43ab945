"""The arm is found in the silhouettes of all views, searched near the last one, and anew after a loss."""

import numpy as np
import pytest

from local_site.tracking.features.view_meter import ViewMeter
from local_site.tracking.foreground.dark_wall import DarkWall
from local_site.tracking.silhouette.arm_finder import ArmFinder, NoArm, SeenArm
from local_site.tracking.silhouette.joints import Body
from local_site.tracking.tracker import TrackingReason, Views
from tests.local_site.tracking.rendered_arm import rig_of
from tests.present import present

UNKNOWN = Body()
CLOSE_M = {"elbow": 0.025, "wrist": 0.035}


class WatchedMeter(ViewMeter):
    """A meter that keeps what it was told to begin with."""

    def __init__(self, camera):
        super().__init__(camera, DarkWall())
        self.guesses, self.forgotten = [], 0

    def features(self, view, guess):
        self.guesses.append(guess)
        return super().features(view, guess)

    def forget(self):
        self.forgotten += 1
        super().forget()


@pytest.fixture
def meters(moving):
    return [WatchedMeter(camera) for camera in rig_of(moving.projections).cameras]


@pytest.fixture
def finder(moving, meters):
    return ArmFinder(rig_of(moving.projections), meters)


def is_close(arm, truth):
    off = {name: np.linalg.norm(getattr(arm.joints, name) - getattr(truth, name)) for name in CLOSE_M}
    return isinstance(arm, SeenArm) and all(off[name] < limit_m for name, limit_m in CLOSE_M.items())


def black(pictures):
    return [np.full_like(picture, 9) for picture in pictures]


def test_the_arm_is_found_with_all_that_the_views_show(moving, finder):
    arm = finder.find(moving.views(5), UNKNOWN)
    assert is_close(arm, moving.truths[5])
    assert arm.t_ns == moving.views(5).t_ns
    assert arm.residual_px < 1.5
    assert set(finder.hand_views(arm)) == {0, 1}
    evidence = finder.evidence(arm)
    np.testing.assert_allclose(evidence.wrist, arm.joints.wrist)
    reach = np.linalg.norm(evidence.far_end - evidence.wrist)
    assert 0.1 < reach < 0.25
    assert len(finder.overlays(arm, [arm.joints.elbow, arm.joints.wrist])) == 2


def test_what_was_kept_is_where_the_search_begins_and_moves_on(moving, finder, meters):
    for k in (20, 21):
        arm = finder.find(moving.views(k), UNKNOWN)
        finder.keep(arm, arm.joints.wrist)
    assert meters[0].guesses[0] is None
    assert is_close(finder.find(moving.views(22), UNKNOWN), moving.truths[22])
    expected = meters[0].guesses[-1].wrist
    (x, y, w) = moving.projections[0] @ np.append(moving.truths[22].wrist, 1.0)
    assert np.linalg.norm(expected - np.array([x, y]) / w) < 20.0


def test_hints_count_only_while_nothing_was_kept(moving, finder, meters):
    arm = finder.find(moving.views(5), UNKNOWN)
    hint = arm.features[0].guess
    finder.find(moving.views(6), UNKNOWN, [hint, None])
    assert meters[0].guesses[-1] is hint
    assert meters[1].guesses[-1] is None
    finder.keep(arm, arm.joints.wrist)
    finder.find(moving.views(7), UNKNOWN, [hint, hint])
    assert meters[0].guesses[-1] is not hint


def test_forgetting_reaches_the_meters_and_begins_anew(moving, finder, meters):
    arm = finder.find(moving.views(5), UNKNOWN)
    finder.keep(arm, arm.joints.wrist)
    finder.forget()
    assert all(meter.forgotten == 1 for meter in meters)
    finder.find(moving.views(6), UNKNOWN)
    assert meters[0].guesses[-1] is None


def test_one_dark_view_of_two_is_a_reason_that_names_it(moving, finder):
    found = finder.find(moving.views(5, lambda pictures: [pictures[0], np.full_like(pictures[1], 9)]), UNKNOWN)
    assert isinstance(found, NoArm)
    assert "camera 1" in found.reason
    both = finder.find(moving.views(6, black), UNKNOWN)
    assert "camera 0" in both.reason
    assert "camera 1" in both.reason


def test_another_number_of_views_is_a_reason(moving, finder):
    views = moving.views(5)
    found = finder.find(Views(views.t_ns, views.views[:1]), UNKNOWN)
    assert found.reason == "1 views for 2 calibrated cameras"


def test_views_of_other_instants_are_out_of_step(moving, finder):
    now, later = moving.views(14), moving.views(44)
    shifted = [np.roll(now.views[0].current.image, 60, axis=0), later.views[1].current.image]
    found = finder.find(moving.views(14, lambda _: shifted), UNKNOWN)
    assert isinstance(found, NoArm)
    assert found.reason == TrackingReason.OUT_OF_STEP
    assert present(found.residual_px) > 5.0


def test_between_exposures_outlines_are_not_compared(moving, finder):
    views = Views(moving.views(5).t_ns, (moving.views(5).views[0], moving.between(5, 1, 0.01)))
    arm = finder.find(views, UNKNOWN)
    assert is_close(arm, moving.truths[5])
    assert arm.residual_px is None
