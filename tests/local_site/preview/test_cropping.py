"""Each view is cropped to what any tracker found in it; a single camera's view, in which joints are marked, never."""

from dataclasses import replace

import numpy as np
import pytest

from common.messages.hand import TrackingStatus
from local_site.preview.arm_window import PictureBox
from local_site.preview.cropping import Cropping, ViewPart, arm_box
from local_site.tracking.annotate import annotate
from local_site.tracking.tracker import ArmEstimate, Overlay
from tests.present import present

WIDTH, HEIGHT = 640, 480
BARE_ARM = Overlay(contour=np.array([[256, 120], [384, 120], [384, 240]], np.int32), elbow=np.array([300.0, 200.0]))
MARKERS = Overlay(wrist=np.array([320.0, 240.0]), index=np.array([256.0, 192.0]), thumb=np.array([288.0, 144.0]))
MONOCULAR = Overlay(
    forearm_line=np.array([[320.0, 96.0], [384.0, 336.0]]), upper_arm_line=np.array([[320.0, 96.0], [128.0, 48.0]])
)
WHOLE = ViewPart(0, 0, WIDTH, HEIGHT, WIDTH)


def estimate(*overlays, status=TrackingStatus.TRACKED, t_ns=0):
    return ArmEstimate(t_ns, status, "", overlays=overlays)


def parts(cropping, given, width=WIDTH, height=HEIGHT, seconds=4.0):
    """The parts of all views once the estimate has held for so long."""
    for k in range(round(seconds * 12)):
        now = replace(given, t_ns=round(k * 1e9 / 12))
        seen = [cropping.part(now, view, width, height) for view in range(len(given.overlays))]
    return seen


@pytest.mark.parametrize(
    ("overlay", "box"),
    [
        (BARE_ARM, PictureBox(0.4, 0.25, 0.6, 0.5)),
        (MARKERS, PictureBox(0.4, 0.3, 0.5, 0.5)),
        (MONOCULAR, PictureBox(0.2, 0.1, 0.6, 0.7)),
        (Overlay(wrist=np.array([320.0, 240.0]), elbow=np.array([900.0, 240.0])), PictureBox(0.5, 0.5, 1.0, 0.5)),
        (Overlay(wrist=np.array([320.0, 240.0]), elbow=np.array([np.nan, 240.0])), PictureBox(0.5, 0.5, 0.5, 0.5)),
        (Overlay(wrist=np.array([-320.0, 240.0])), None),
        (Overlay(wrist=np.array([np.nan, np.inf])), None),
        (Overlay(contour=np.empty((0, 2), np.int32)), None),
        (Overlay(), None),
    ],
)
def test_whatever_a_tracker_draws_is_the_arm(overlay, box):
    assert arm_box(estimate(overlay), 0, WIDTH, HEIGHT) == box
    assert arm_box(estimate(overlay, status=TrackingStatus.DEGRADED), 0, WIDTH, HEIGHT) == box


def test_where_no_arm_is_tracked_there_is_none():
    for status in (TrackingStatus.LOST, TrackingStatus.INITIALISING):
        assert arm_box(estimate(BARE_ARM, status=status), 0, WIDTH, HEIGHT) is None
    assert arm_box(estimate(), 1, WIDTH, HEIGHT) is None


def test_each_view_has_its_own_part_and_one_that_shows_no_arm_is_whole():
    near, whole = parts(Cropping(2, 640), estimate(BARE_ARM, Overlay()))
    assert (near.width, near.height) == (262, 197)
    assert near.left < 256
    assert near.left + near.width > 384
    assert whole == WHOLE
    assert parts(Cropping(2, 640), estimate(BARE_ARM, BARE_ARM, status=TrackingStatus.LOST)) == [WHOLE, WHOLE]


@pytest.mark.parametrize(("width", "sent"), [(640, 262), (1280, 427), (2560, 427)])
def test_a_part_is_sent_in_the_cameras_pixels_and_at_most_two_thirds_as_wide_as_a_whole_picture(width, sent):
    scale = width // 640
    bare_arm = Overlay(contour=scale * BARE_ARM.contour)
    near, whole = parts(Cropping(2, 640), estimate(bare_arm, Overlay()), width, 480 * scale)
    assert near.sent_width == pytest.approx(sent, abs=1)
    assert whole.sent_width == 640


def test_a_single_cameras_view_stays_whole_so_that_joints_are_marked_where_they_are():
    (part,) = parts(Cropping(1, 320), estimate(MONOCULAR))
    assert (part.left, part.top, part.width, part.height, part.sent_width) == (0, 0, WIDTH, HEIGHT, 320)


def pixel_map(part):
    """Where the pixels of a picture come to be: its own coordinates, cropped and shrunk."""
    across, down = np.meshgrid(np.arange(WIDTH), np.arange(HEIGHT))
    return [part.picture((coordinate // 4).astype(np.uint8)) for coordinate in (across, down)]


@pytest.mark.parametrize("part", [ViewPart(100, 60, 400, 300, 400), ViewPart(100, 60, 400, 300, 200), WHOLE])
def test_what_was_found_lies_on_the_same_spot_of_the_picture_as_before(part):
    overlay = Overlay(contour=np.array([[140, 80], [300, 200]], np.int32), wrist=np.array([201.0, 161.0]))
    given = estimate(Overlay(), overlay)
    moved = part.estimate(given, 1)
    assert moved.overlays[0] is given.overlays[0]
    befores, afters = ([shown.wrist, *present(shown.contour)] for shown in (overlay, moved.overlays[1]))
    for before, after in zip(befores, afters, strict=True):
        column, row = np.rint(after).astype(int)
        there = [coordinate[row, column] for coordinate in pixel_map(part)]
        assert np.abs(there - before // 4).max() <= 1
    assert moved.overlays[1].contour.dtype == np.int32


def test_a_point_between_two_pixels_that_become_one_lies_in_its_middle():
    part = ViewPart(100, 60, 400, 300, 200)
    moved = part.estimate(estimate(Overlay(wrist=np.array([100.5, 60.5]))), 0)
    assert moved.overlays[0].wrist == pytest.approx([0.0, 0.0])


def test_an_ellipse_of_the_same_uncertainty_is_drawn_in_the_scale_of_the_part():
    camera = np.array([[500.0, 0.0, 320.0, 320.0], [0.0, 500.0, 240.0, 240.0], [0.0, 0.0, 1.0, 1.0]])
    part, point = ViewPart(160, 120, 320, 240, 160), np.array([0.1, 0.05, 0.2])
    found = ArmEstimate(
        0,
        TrackingStatus.TRACKED,
        "",
        wrist=point,
        overlays=(Overlay(wrist=(camera @ [*point, 1.0])[:2] / 1.2),),
        covariances={"wrist": 4e-4 * np.eye(3)},
    )
    drawn = [
        annotate(np.zeros((HEIGHT, WIDTH), np.uint8), found, 0, camera),
        annotate(np.zeros((120, 160), np.uint8), part.estimate(found, 0), 0, part.projection(camera)),
    ]
    whole, small = (np.argwhere(picture.max(axis=2) > 60) for picture in drawn)
    whole, small = whole[(whole[:, 0] > 24) & (whole[:, 0] < 400)], small[small[:, 0] > 24]
    assert np.ptp(small, axis=0) == pytest.approx(np.ptp(whole, axis=0) / 2, abs=2)
    shifted = (whole.mean(axis=0) - (120, 160)) / 2
    assert small.mean(axis=0) == pytest.approx(shifted, abs=2)
