"""What a view sees: between two exposures it lies between, but what only one tells is where that one has it."""

import numpy as np

from local_site.tracking.eye.arm_points import ELBOW, POINTS, WRIST
from local_site.tracking.eye.view_sight import ViewSight, blended


def sight(at_px: float) -> ViewSight:
    covariances = np.tile(4.0 * np.eye(2), (POINTS, 1, 1))
    return ViewSight(np.full((POINTS, 2), at_px), covariances, 1.0, 1.0, None)


def test_points_lie_between_two_exposures() -> None:
    assert blended(sight(100.0), sight(110.0), 0.25).pixels[WRIST].tolist() == [102.5, 102.5]


def test_an_elbow_that_only_the_second_exposure_was_asked_for_is_where_that_has_it() -> None:
    before, after = sight(100.0), sight(110.0)
    before.covariances[ELBOW] = np.inf
    between = blended(before, after, 0.25)
    assert between.pixels[ELBOW].tolist() == [110.0, 110.0]
    assert np.isfinite(between.of(np.eye(3, 4)).whitening).all()


def test_a_point_that_is_told_by_none_weighs_nothing() -> None:
    before, after = sight(100.0), sight(110.0)
    after.covariances[ELBOW] = np.inf
    whitening = blended(before, after, 0.25).of(np.eye(3, 4)).whitening
    assert not whitening[ELBOW].any()
    assert whitening[WRIST].any()
