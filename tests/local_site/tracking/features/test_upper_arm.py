"""The upper arm's line: seen on an arm whose sleeve ends far from the elbow, none of what a sleeve leaves of it."""

import cv2
import numpy as np
import pytest

from local_site.tracking.features.features import measure
from local_site.tracking.features.posture import Posture
from local_site.tracking.features.silhouette import find_silhouette, to_grey

WIDTH = 40
ELBOW, WRIST, TIPS = np.array([220.0, 170.0]), np.array([120.0, 90.0]), np.array([70.0, 60.0])


def bare_to(shoulder_end):
    """The features of a drawn arm whose bare part ends there."""
    image = np.full((240, 400), 10, np.uint8)
    for ends, width in (((ELBOW, shoulder_end), WIDTH), ((ELBOW, WRIST), WIDTH - 8), ((WRIST, TIPS), WIDTH - 12)):
        start, end = (tuple(int(v) for v in point) for point in ends)
        cv2.line(image, start, end, 150, width)
    cv2.rectangle(image, (int(shoulder_end[0]), 0), (399, 239), 10, cv2.FILLED)
    silhouette = find_silhouette(to_grey(image), 60.0)
    assert silhouette is not None
    features = measure(silhouette, Posture(shoulder_end, ELBOW, WRIST, TIPS, WIDTH / 2))
    assert features is not None
    return features


def test_a_long_bare_upper_arm_has_its_line():
    line = bare_to(np.array([330.0, 165.0])).upper_arm
    assert line is not None
    assert line.direction == pytest.approx((1.0, -0.045), abs=0.05)


def test_a_short_end_of_it_has_none():
    assert bare_to(np.array([244.0, 169.0])).upper_arm is None


def test_the_forearm_of_an_arm_that_the_border_cuts_at_the_elbow_is_not_taken_for_its_upper_arm():
    """What was taken for the shoulder's end lies on the forearm: the last instants' elbow was wrong."""
    elbow, wrist, tips = np.array([200.0, 0.0]), np.array([210.0, 150.0]), np.array([215.0, 210.0])
    image = np.full((240, 400), 10, np.uint8)
    for ends, width in (((elbow, wrist), WIDTH - 8), ((wrist, tips), WIDTH - 12)):
        start, end = (tuple(int(v) for v in point) for point in ends)
        cv2.line(image, start, end, 150, width)
    silhouette = find_silhouette(to_grey(image), 60.0)
    assert silhouette is not None
    features = measure(silhouette, Posture(wrist, elbow, wrist, tips, WIDTH / 2))
    assert features is not None
    assert features.upper_arm is None
    assert features.guess.shoulder_end[1] < 20.0
