"""The fit of points: exact without errors, unmoved by one that is far off, honest about what no view tells."""

import numpy as np
import pytest
from numpy.typing import NDArray

from common.geometry import Array
from local_site.calibration.triangulation import project, triangulate_many
from local_site.tracking.eye.arm_points import AVERAGE_M, BONES, ELBOW, INDEX_TIP, POINTS, WRIST
from local_site.tracking.eye.fitted_points import Expected, FittedPoints, Lengths, PointSight, fit_points

FOCAL_PX, SIGMA_PX = 800.0, 2.0
LOOSE = np.full(POINTS, 0.1)


def camera(x_m: float) -> Array:
    """A projection (3, 4) that looks along z, from beside the origin by so much."""
    intrinsic = np.array([[FOCAL_PX, 0.0, 320.0], [0.0, FOCAL_PX, 240.0], [0.0, 0.0, 1.0]])
    projection: Array = intrinsic @ np.column_stack([np.eye(3), [-x_m, 0.0, 0.0]])
    return projection


VIEWS = [camera(-0.25), camera(0.25)]


@pytest.fixture
def arm() -> Array:
    """The points (22, 3) in m of an arm whose bones are as long as the average's, all but exactly."""
    random = np.random.default_rng(1)
    points = np.array([0.0, 0.0, 0.9]) + 0.05 * random.standard_normal((POINTS, 3))
    for _ in range(400):  # springs
        way = points[BONES[:, 1]] - points[BONES[:, 0]]
        long = np.linalg.norm(way, axis=1)
        pull = 0.1 * ((long - AVERAGE_M) / long)[:, None] * way
        np.add.at(points, BONES[:, 0], pull)
        np.add.at(points, BONES[:, 1], -pull)
    return points


def sights(points: Array, noise_px: float = 0.0, told: NDArray[np.bool_] | None = None) -> list[PointSight]:
    """What the views see, with noise; points that are not `told` (22,) by none."""
    random, whitening = np.random.default_rng(2), np.tile(np.eye(2) / SIGMA_PX, (POINTS, 1, 1))
    if told is not None:
        whitening[~told] = 0.0
    return [
        PointSight(m, project(m, points) + noise_px * random.standard_normal((POINTS, 2)), whitening) for m in VIEWS
    ]


def fitted(seen: list[PointSight], start: Array, sigma_m: Array = LOOSE) -> FittedPoints:
    return fit_points(seen, Expected(start, sigma_m), Lengths.unknown())


def test_points_without_errors_are_found(arm: Array) -> None:
    start = arm + 0.02 * np.random.default_rng(3).standard_normal(arm.shape)
    fit = fitted(sights(arm), start)
    assert np.linalg.norm(fit.points - arm, axis=1).max() < 0.002
    assert fit.misfit < 0.05


def test_bones_bring_points_nearer_than_the_views_alone(arm: Array) -> None:
    seen = sights(arm, noise_px=SIGMA_PX)
    alone = triangulate_many(VIEWS, np.stack([s.pixels for s in seen], axis=1))
    lengths = Lengths(np.linalg.norm(arm[BONES[:, 1]] - arm[BONES[:, 0]], axis=1), np.full(len(BONES), 0.0008))
    fit = fit_points(seen, Expected(arm + 0.01, LOOSE), lengths)
    misses = [np.sqrt(np.mean(np.sum((p - arm) ** 2, axis=1))) for p in (fit.points, alone)]
    assert misses[0] < 0.75 * misses[1]
    within = [off @ np.linalg.solve(c, off) < 7.81 for off, c in zip(fit.points - arm, fit.covariances, strict=True)]
    assert np.mean(within) > 0.8


def test_a_tip_that_one_view_takes_for_another_hardly_moves(arm: Array) -> None:
    seen = sights(arm)
    seen[0].pixels[INDEX_TIP] += [60.0, 20.0]
    alone = triangulate_many(VIEWS, np.stack([s.pixels for s in seen], axis=1))
    misses = [np.linalg.norm(points[INDEX_TIP] - arm[INDEX_TIP]) for points in (fitted(seen, arm).points, alone)]
    assert misses[0] < 0.25 * misses[1]


def test_what_no_view_tells_stays_where_it_is_expected_and_is_told_to_be_unsure(arm: Array) -> None:
    told = np.ones(POINTS, bool)
    told[ELBOW] = False
    fit = fitted(sights(arm, told=told), arm, np.full(POINTS, 0.05))
    assert np.linalg.norm(fit.points[ELBOW] - arm[ELBOW]) < 0.005
    assert np.sqrt(np.linalg.eigvalsh(fit.covariances[ELBOW])[-1]) > 0.035
    assert np.sqrt(np.linalg.eigvalsh(fit.covariances[WRIST])[-1]) < 0.01


def test_a_forearms_length_is_learned_slowly_and_never_for_certain(arm: Array) -> None:
    arm[ELBOW] = arm[WRIST] + 1.15 * (arm[ELBOW] - arm[WRIST])
    long_m, lengths = float(np.linalg.norm(arm[ELBOW] - arm[WRIST])), Lengths.unknown()
    for k in range(60):
        fit = fit_points(sights(arm), Expected(arm, LOOSE), lengths)
        lengths = lengths.learned(fit.length_m, fit.length_sigma_m)
        if k == 0:
            assert abs(lengths.mean_m[0] - AVERAGE_M[0]) > 0.001
    assert lengths.mean_m[0] == pytest.approx(long_m, abs=0.003)
    assert (lengths.sigma_m >= 0.0008).all()
