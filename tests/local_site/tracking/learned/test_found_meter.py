"""A camera's found silhouettes are measured like any others, each for the frame in which it was found."""

import numpy as np
import pytest

from common.cameras.camera import Frame
from local_site.tracking.features.features import Features
from local_site.tracking.features.silhouette import find_silhouette, to_grey
from local_site.tracking.features.view_meter import ViewMeter
from local_site.tracking.foreground.dark_wall import DarkWall
from local_site.tracking.learned.found_meter import NOT_FOUND, FoundMeter
from local_site.tracking.tracker import View
from tests.local_site.tracking.rendered_arm import rig_of

LEVEL = 50.0


@pytest.fixture
def meter(moving):
    return FoundMeter(rig_of(moving.projections).cameras[0])


def silhouette_of(view):
    found = find_silhouette(to_grey(view.current.image), LEVEL)
    assert found is not None
    return found


def test_a_found_silhouette_is_measured_as_one_before_a_dark_wall(moving, meter):
    view = moving.views(5).views[0]
    usual = ViewMeter(rig_of(moving.projections).cameras[0], DarkWall()).features(view, None)
    meter.show(view.current, silhouette_of(view))
    found = meter.features(view, None)
    assert isinstance(found, Features)
    assert isinstance(usual, Features)
    np.testing.assert_allclose(found.forearm.point, usual.forearm.point, atol=3.0)
    assert abs(found.half_width - usual.half_width) < 1.0
    assert meter.overlay(found, [moving.truths[5].elbow, moving.truths[5].wrist]).contour is not None


def test_the_reason_for_none_is_told_with_the_cameras_name(moving, meter):
    view = moving.views(0).views[0]
    meter.show(view.current, "the arm's colour is everywhere")
    assert meter.features(view, None) == "camera 0: the arm's colour is everywhere"


def test_a_frame_in_which_nothing_was_looked_for_says_so(moving, meter):
    first, second = moving.views(0).views[0], moving.views(1).views[0]
    assert NOT_FOUND in meter.features(first, None)
    meter.show(second.current, silhouette_of(second))
    other = FoundMeter(rig_of(moving.projections).cameras[0])
    other.show(second.current, silhouette_of(second))
    assert NOT_FOUND in str(other.features(moving.views(2).views[0], None))


def test_between_two_exposures_it_interpolates_what_both_show(moving, meter):
    first, second = moving.views(20).views[0], moving.views(21).views[0]
    measured = []
    for view in (first, second):
        meter.show(view.current, silhouette_of(view))
        measured.append(meter.features(view, None))
    between = meter.features(View(second.current, first.current, 0.5), None)
    middle = (measured[0].guess.wrist + measured[1].guess.wrist) / 2
    assert np.linalg.norm(between.guess.wrist - measured[1].guess.wrist) < 5.0
    assert np.linalg.norm(between.guess.wrist - middle) < 5.0


def test_an_earlier_picture_that_was_never_looked_at_is_a_reason(moving, meter):
    first, second = moving.views(20).views[0], moving.views(21).views[0]
    meter.show(second.current, silhouette_of(second))
    reason = meter.features(View(Frame(second.current.image, 7, 70), first.current, 0.5), None)
    assert isinstance(reason, str)


def test_unsynchronised_frames_are_interpolated_from_the_second_on(moving, meter):
    found = []
    for k in range(20, 25):
        now, before = moving.views(k).views[0].current, moving.views(k - 1).views[0].current
        meter.show(now, silhouette_of(moving.views(k).views[0]))
        found.append(meter.features(View(now, before, 0.5), None))
    assert isinstance(found[0], str)
    assert all(isinstance(features, Features) for features in found[1:])
