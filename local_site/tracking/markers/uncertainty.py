"""A marker's place and its covariance from its centroids: what sensor noise and calibration leave open."""

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np

from common.geometry import Array
from local_site.calibration.triangulation import project

REFINEMENTS = 3


@dataclass(frozen=True, slots=True)
class MarkerFix:
    """Where a marker is: point (3,) in m, covariance (3, 3) in m², and the sum of squared residuals over their expected
    variances, which averages `freedom`."""

    point: Array
    covariance: Array
    misfit: float
    freedom: int


def fix_marker(projections: Sequence[Array], pixels: Array, sigmas: Array, start: Array) -> MarkerFix:
    """The likeliest place of a marker seen at pixels (V, 2) with standard deviations (V,) px, V >= 2.

    Gauss-Newton on the weighted reprojection error from a point (3,) near by; the covariance is the inverse of the
    normal matrix. Views that disagree more than their deviations allow make it larger, never smaller.
    """
    weights = np.repeat(1.0 / sigmas, 2)
    point = start
    for _ in range(REFINEMENTS):
        jacobian, offset = _linearised(projections, pixels, point)
        point = point + np.linalg.lstsq(jacobian * weights[:, None], offset * weights, rcond=None)[0]
    jacobian, offset = _linearised(projections, pixels, point)
    scaled = jacobian * weights[:, None]
    misfit = float(np.sum((offset * weights) ** 2))
    freedom = 2 * len(sigmas) - 3
    covariance: Array = np.linalg.pinv(scaled.T @ scaled) * max(1.0, misfit / freedom)
    return MarkerFix(point, covariance, misfit, freedom)


def pixel_jacobian(projection: Array, point: Array) -> Array:
    """How a pixel moves with its point (3,): (2, 3) in px per m."""
    pixel = project(projection, point)
    depth = float(projection[2, :3] @ point + projection[2, 3])
    result: Array = (projection[:2, :3] - np.outer(pixel, projection[2, :3])) / depth
    return result


def magnification(projection: Array, point: Array) -> float:
    """The length in px of a metre across the line of sight at a point (3,)."""
    jacobian = pixel_jacobian(projection, point)
    return float(np.sqrt(np.sqrt(np.linalg.det(jacobian @ jacobian.T))))


def _linearised(projections: Sequence[Array], pixels: Array, point: Array) -> tuple[Array, Array]:
    jacobian = np.concatenate([pixel_jacobian(matrix, point) for matrix in projections])
    offset = np.concatenate([pixel - project(matrix, point) for matrix, pixel in zip(projections, pixels, strict=True)])
    return jacobian, offset
