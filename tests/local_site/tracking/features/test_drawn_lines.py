"""The forearm's line that is drawn over a view: as far as the view shows the forearm, and no further."""

from dataclasses import replace

import cv2
import numpy as np
import pytest

from local_site.simulation.cameras import exact_rig
from local_site.simulation.config import StereoConfig
from local_site.tracking.features.features import measure
from local_site.tracking.features.medial import MedialLine
from local_site.tracking.features.posture import Posture
from local_site.tracking.features.silhouette import find_silhouette, to_grey
from local_site.tracking.features.view_meter import overlay_of

CAMERA = exact_rig(StereoConfig()).cameras[0]
PLACES = [np.array([0.6, 0.43, 0.45]), np.array([0.43, 0.4, 0.5])]
SHOULDER, ELBOW, WRIST, TIPS = (np.array(p) for p in ((500.0, 160.0), (360.0, 240.0), (220.0, 240.0), (160.0, 240.0)))
WIDTH = 40


def features():
    """An arm whose forearm lies along a row, seen from tips to shoulder."""
    image = np.full((480, 640), 10, np.uint8)
    cv2.polylines(image, [np.array([TIPS, ELBOW, SHOULDER], np.int32)], isClosed=False, color=150, thickness=WIDTH)
    silhouette = find_silhouette(to_grey(image), 60.0)
    assert silhouette is not None
    found = measure(silhouette, Posture(SHOULDER, ELBOW, WRIST, TIPS, WIDTH / 2))
    assert found is not None
    return found


def line_from(foot):
    """The forearm's line as it is drawn where the elbow's foot on it is there."""
    view = replace(features(), forearm=MedialLine(np.array(foot), np.array([-1.0, 0.0])))
    return overlay_of(CAMERA, view, PLACES).forearm_line


def test_a_forearm_that_is_seen_to_its_elbow_has_its_whole_line():
    assert line_from((360.0, 240.0))[0] == pytest.approx(CAMERA.distort_pixels(ELBOW), abs=1.0)


@pytest.mark.parametrize("foot", [(600.0, 240.0), (2000.0, 240.0)])
def test_a_line_ends_where_the_arm_does_though_the_elbow_is_thought_beyond(foot):
    (end, _), wrist = line_from(foot)[:, 0], features().guess.wrist
    assert ELBOW[0] - 5 < end < ELBOW[0] + 2 * WIDTH
    assert line_from(foot)[1] == pytest.approx(CAMERA.distort_pixels(wrist), abs=1.0)


def test_what_is_nowhere_has_no_line():
    view = features()
    nowhere = replace(view, guess=replace(view.guess, wrist=np.array([np.nan, 0.0])))
    assert overlay_of(CAMERA, nowhere, PLACES).forearm_line is None
