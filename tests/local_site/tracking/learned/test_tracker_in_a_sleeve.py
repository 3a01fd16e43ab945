"""The elbow of an arm that has been learned, when a sleeve slips down to it and no view shows the upper arm."""

import numpy as np
import pytest

from common.messages.hand import TrackingStatus
from local_site.calibration.triangulation import project
from local_site.simulation.config import MotionConfig
from tests.local_site.tracking.learned.simulated_landmarks import shown_tracker, simulated_landmarks
from tests.local_site.tracking.rendered_arm import errors_m

LEARNED, LAST = 15, 40
SKIN_LEFT_PX = 12.0
WALL = 9
LARGEST_MM = 20.0
SHOULDER = np.array(MotionConfig().shoulder)


def sleeved(sequence, k):
    """A change of the k-th pictures: the upper arm looks like the wall."""

    def cover(pictures):
        for matrix, picture in zip(sequence.projections, pictures, strict=True):
            elbow, shoulder = project(matrix, np.array([sequence.truths[k].elbow, SHOULDER]))
            y, x = np.indices(picture.shape[:2])
            towards = (shoulder - elbow) / np.linalg.norm(shoulder - elbow)
            beyond = (x - elbow[0]) * towards[0] + (y - elbow[1]) * towards[1] > SKIN_LEFT_PX
            yield np.where(beyond, WALL, picture).astype(np.uint8)

    return cover


@pytest.fixture
def shown(monkeypatch, moving):
    return shown_tracker(monkeypatch, moving.projections)


def test_its_length_tells_the_elbow(shown, moving):
    for k in range(LEARNED):
        shown.track(moving.views(k), simulated_landmarks(moving, k))
    covered = range(LEARNED, LAST)
    estimates = [shown.track(moving.views(k, sleeved(moving, k)), simulated_landmarks(moving, k)) for k in covered]
    assert all(estimate.status is TrackingStatus.TRACKED for estimate in estimates)
    errors = errors_m(estimates, [moving.truths[k] for k in covered], "elbow")
    assert 1e3 * np.linalg.norm(errors, axis=1).max() < LARGEST_MM
