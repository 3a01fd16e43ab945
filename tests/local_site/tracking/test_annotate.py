"""What is drawn over a frame: contour, lines, points where they are, sigmas as large as they are, and readable text."""

from typing import Any

import cv2
import numpy as np
import pytest

from common.messages.hand import TrackingStatus
from local_site.calibration.triangulation import project
from local_site.simulation.cameras import exact_rig
from local_site.simulation.config import StereoConfig
from local_site.tracking.annotate import POINTS, STATUS, annotate, sigma_outline, wrapped
from local_site.tracking.tracker import ArmEstimate, Overlay

MATRIX = exact_rig(StereoConfig()).matrices[0]
PLACES = {
    "elbow": np.array([0.6, 0.43, 0.45]),
    "wrist": np.array([0.43, 0.4, 0.5]),
    "index": np.array([0.3, 0.38, 0.6]),
    "thumb": np.array([0.35, 0.3, 0.5]),
}
PIXELS = {name: project(MATRIX, place) for name, place in PLACES.items()}
BLACK = np.zeros((480, 640), np.uint8)
GREYS = [np.zeros((480, 640), np.uint8), np.full((480, 640), 255, np.uint8)]
REASON = "the forearm is nearly parallel to the line between the cameras; the elbow is nearly straight"


def estimate(sigma_m=0.004, overlay=None, **more):
    values: dict[str, Any] = {
        "t_ns": 0,
        "status": TrackingStatus.TRACKED,
        "reason": "",
        "covariances": {name: sigma_m**2 * np.eye(3) for name in PLACES},
        "overlays": (overlay or Overlay(None, **PIXELS),),
        **PLACES,
    }
    return ArmEstimate(**{**values, **more})


def lost(reason=""):
    return ArmEstimate(t_ns=0, status=TrackingStatus.LOST, reason=reason)


def coloured(picture, colour, within, tolerance=40):
    """Where a picture has nearly this colour, within (x, y, half side): pixels (N, 2)."""
    x, y, half = (round(float(value)) for value in within)
    part = picture[y - half : y + half + 1, x - half : x + half + 1].astype(int)
    rows, columns = np.nonzero(np.max(np.abs(part - colour), axis=2) < tolerance)
    return np.column_stack([columns - half, rows - half])


def test_the_frame_itself_stays_as_it_was():
    image = BLACK.copy()
    assert annotate(image, estimate(), 0, MATRIX).any()
    assert not image.any()


@pytest.mark.parametrize("grey", GREYS)
@pytest.mark.parametrize("name", POINTS)
def test_a_point_is_marked_where_it_is(name, grey):
    picture = annotate(grey, estimate(covariances={}), 0)
    marked = coloured(picture, POINTS[name], (*PIXELS[name], 12))
    assert len(marked) > 8
    assert np.abs(marked.mean(axis=0)).max() < 1.0
    assert np.abs(marked).max() <= 4


@pytest.mark.parametrize("name", POINTS)
def test_a_point_that_was_not_found_has_no_mark_though_a_view_has_a_place_for_it(name):
    picture = annotate(BLACK, estimate(covariances={}, **{name: None}), 0)
    assert not len(coloured(picture, POINTS[name], (*PIXELS[name], 12)))


def test_an_inferred_thumb_is_a_ring():
    picture = annotate(BLACK, estimate(covariances={}, thumb_inferred=True), 0)
    x, y = np.round(PIXELS["thumb"]).astype(int)
    assert not np.array_equal(picture[y, x], POINTS["thumb"])
    assert len(coloured(picture, POINTS["thumb"], (x, y, 6), tolerance=90)) > 7


def test_contour_and_medial_lines_are_drawn():
    square = np.array([[100, 100], [300, 100], [300, 300], [100, 300]], np.int32)
    lines = {
        "forearm_line": np.array([[120.0, 200], [280, 200]]),
        "upper_arm_line": np.array([[200.0, 120], [200, 280]]),
    }
    picture = annotate(BLACK, estimate(overlay=Overlay(contour=square, **lines)), 0)
    assert picture[100, 200].any()
    assert picture[250, 100].any()
    for x, y in ((150, 200), (200, 150)):
        assert picture[y, x].min() > 200
    assert annotate(GREYS[1], estimate(overlay=Overlay(**lines)), 0)[190:211, 150].min() < 50


@pytest.mark.parametrize("sigma_m", [0.01, 0.02])
def test_the_ellipse_is_as_large_as_two_sigma(sigma_m):
    picture = annotate(BLACK, estimate(sigma_m), 0, MATRIX)
    reach = np.linalg.norm(coloured(picture, POINTS["wrist"], (*PIXELS["wrist"], 40)), axis=1).max()
    pixels_per_m = 800 / 1.5
    assert reach == pytest.approx(2 * sigma_m * pixels_per_m, rel=0.15)


def test_the_outline_of_a_covariance_is_where_samples_project_to():
    random = np.random.default_rng(5)
    spread = 0.003 * random.standard_normal((3, 3))
    samples = PLACES["wrist"] + random.standard_normal((20000, 3)) @ spread.T
    seen = np.cov((project(MATRIX, samples) - PIXELS["wrist"]).T)
    outline = sigma_outline(MATRIX, PLACES["wrist"], spread @ spread.T)
    assert np.sum(outline * np.linalg.solve(seen, outline.T).T, axis=1) == pytest.approx(4.0, rel=0.06)


def test_status_has_its_colour_and_every_point_a_line():
    for status, colour in STATUS.items():
        picture = annotate(BLACK, estimate(status=status), 0)
        assert len(coloured(picture, colour, (30, 12, 12), tolerance=90)) > 5
    missing = annotate(BLACK, lost(), 0)
    assert not np.array_equal(missing[400:], annotate(BLACK, estimate(), 0)[400:])


def test_text_can_be_read_before_a_white_picture():
    picture = annotate(GREYS[1], lost(REASON), 0)
    assert picture[12, 3:6].max() < 80


def test_long_reasons_are_wrapped_at_words_within_the_width():
    lines = wrapped(REASON, 200)
    assert len(lines) > 2
    assert " ".join(lines) == REASON
    assert all(cv2.getTextSize(line, cv2.FONT_HERSHEY_SIMPLEX, 0.45, 1)[0][0] <= 200 for line in lines)
    assert wrapped("unbreakable", 5) == ["unbreakable"]
    assert not annotate(BLACK, lost(REASON * 3), 0)[:, 634:].any()


@pytest.mark.parametrize("shape", [(1, 1), (32, 32), (120, 160, 3), (480, 640, 4), (20, 2000)])
def test_a_frame_of_any_size_can_be_drawn_on(shape):
    picture = annotate(np.full(shape, 90, np.uint8), estimate(reason=REASON), 0, MATRIX)
    assert picture.shape == (*shape[:2], 3)


def test_points_that_are_nowhere_do_no_harm():
    far = Overlay(elbow=np.array([np.nan, 3.0]), wrist=np.array([1e9, -1e9]), index=np.array([np.inf, 0.0]))
    assert annotate(BLACK, estimate(overlay=far), 0, MATRIX).shape == (480, 640, 3)
    assert annotate(BLACK, estimate(overlays=()), 0, MATRIX).shape == (480, 640, 3)


def test_small_pictures_leave_the_sigmas_out_rather_than_write_over_the_reason():
    small = np.full((90, 300), 200, np.uint8)
    assert (annotate(small, lost(REASON), 0)[-20:] == 200).all()


@pytest.mark.parametrize(("height", "has_lines"), [(230, False), (250, True)])
def test_the_sigmas_cover_a_third_of_the_picture_at_most(height, has_lines):
    tracked = estimate(overlay=Overlay(), covariances={})
    assert annotate(np.zeros((height, 320), np.uint8), tracked, 0)[40:].any() == has_lines


@pytest.mark.parametrize("place", [(40.0, 12.0), (40.0, 400.0)])
def test_no_text_hides_a_point(place):
    wrist = Overlay(wrist=np.array(place))
    picture = annotate(BLACK, estimate(overlay=wrist, covariances={}), 0)
    assert len(coloured(picture, POINTS["wrist"], (*place, 3))) > 8


@pytest.mark.parametrize("number", [np.nan, np.inf])
def test_a_sigma_that_is_no_number_leaves_its_ellipse_out(number):
    without = annotate(BLACK, estimate(covariances={}), 0, MATRIX)
    picture = annotate(BLACK, estimate(covariances={"wrist": np.full((3, 3), number)}), 0, MATRIX)
    rows = slice(0, BLACK.shape[0] - 18 * len(POINTS) - 18)
    assert np.array_equal(picture[rows], without[rows])


def test_a_place_behind_the_camera_has_no_ellipse():
    behind = -MATRIX
    assert np.array_equal(annotate(BLACK, estimate(), 0, behind), annotate(BLACK, estimate(), 0))


def test_a_camera_that_saw_nothing_shows_the_status_alone_beside_one_that_saw_all():
    given = estimate(overlay=Overlay())
    assert not annotate(BLACK, given, 0, MATRIX)[30:400].any()
    assert np.array_equal(annotate(BLACK, given, 1, MATRIX), annotate(BLACK, given, 0, MATRIX))
