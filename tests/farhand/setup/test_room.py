"""What a room lacks, measured in rendered pictures of an arm whose light and background are known."""

import cv2
import numpy as np
import pytest

from farhand.doctor.findings import Severity
from farhand.setup.room import (
    Light,
    arm_in_picture,
    in_view,
    judge_background,
    judge_contrast,
    judge_elbow,
    judge_light,
    light_of,
)
from local_site.simulation.config import SimulationConfig
from local_site.simulation.operator import SimulatedOperator
from local_site.tracking.features.silhouette import find_silhouette
from tests.present import present


def arm(gain=1.0, wall=0.0):
    """The simulated operator's arm, its light times a gain before a wall of this grey level, and its outline."""
    (picture,) = SimulatedOperator(SimulationConfig()).render(0.0, (0,))
    outline = present(find_silhouette(picture, 60.0)).contour.astype(np.int32)
    mask = cv2.fillPoly(np.zeros_like(picture), [outline.reshape(-1, 1, 2)], 1) > 0
    lit = np.where(mask, np.clip(gain * picture.astype(float), 0, 255), np.maximum(picture, wall))
    return lit.astype(np.uint8), outline


def test_the_arm_and_what_is_around_it_are_measured_apart():
    dark, outline = arm()
    bright, _ = arm(wall=100.0)
    before_dark, before_bright = present(arm_in_picture(dark, outline)), present(arm_in_picture(bright, outline))
    assert before_dark.light == before_bright.light
    assert before_bright.around == pytest.approx(100.0, abs=3.0)
    assert before_dark.contrast - before_bright.contrast == pytest.approx(100.0 - before_dark.around, abs=4.0)


def test_colour_is_measured_as_grey():
    picture, outline = arm()
    colour = cv2.cvtColor(picture, cv2.COLOR_GRAY2BGR)
    in_colour, in_grey = (present(arm_in_picture(shown, outline)) for shown in (colour, picture))
    assert in_colour.contrast == pytest.approx(in_grey.contrast, abs=0.5)


def test_an_outline_without_an_inside_gives_nothing():
    picture, _ = arm()
    assert arm_in_picture(picture, np.array([[5, 5], [8, 5], [8, 8]], dtype=np.int32)) is None


@pytest.mark.parametrize(
    ("gain", "level", "words"),
    [(1.0, Severity.OK, "mean level"), (0.3, Severity.WARNING, "dark"), (1.7, Severity.WARNING, "too bright")],
)
def test_light_on_the_arm_is_judged(gain, level, words):
    picture, outline = arm(gain)
    finding = judge_light("left", present(arm_in_picture(picture, outline)).light, "on the arm")
    assert finding.level is level, finding.sentence
    assert words in finding.sentence
    assert bool(finding.cure) == (level is Severity.WARNING)


def test_contrast_counts_for_a_tracker_that_needs_a_dark_background_only():
    picture, outline = arm(wall=150.0)
    contrast = present(arm_in_picture(picture, outline)).contrast
    assert judge_contrast("left", contrast, needs_dark=True).cure.startswith("a darker and plainer background")
    assert judge_contrast("left", contrast, needs_dark=False).level is Severity.OK
    dark, _ = arm()
    assert judge_contrast("left", present(arm_in_picture(dark, outline)).contrast, needs_dark=True).level is Severity.OK


def test_a_view_without_an_arm_is_judged_by_what_stands_out():
    assert judge_background("left", light_of(np.full((48, 64), 140, np.uint8))).level is Severity.WARNING
    assert judge_background("left", Light(mean=30.0, bright=180.0, saturated=0.0)).level is Severity.OK


def test_saturation_is_a_share():
    greys = np.zeros(100, np.uint8)
    greys[:25] = 255
    assert light_of(greys).saturated == 0.25


def test_an_elbow_at_the_edge_of_a_picture_is_not_in_view():
    assert in_view(np.array([320.0, 240.0]), (640, 480))
    for pixel in ((5.0, 240.0), (700.0, 240.0), (320.0, -10.0), (320.0, 476.0)):
        assert not in_view(np.array(pixel), (640, 480))


def test_the_view_that_shows_the_elbow_least_decides():
    assert judge_elbow({"left": 1.0, "right": 0.95}).level is Severity.OK
    finding = judge_elbow({"left": 1.0, "right": 0.4})
    assert "right 40 %" in finding.sentence
    assert "turn the cameras" in finding.cure
    assert judge_elbow({}).sentence == "never found"
