"""A marker's place and its covariance from its centroids: what sensor noise and calibration leave open."""

from dataclasses import dataclass

import numpy as np

from common.geometry import Array

REFINEMENTS = 2
RIDGE = 1e-12


@dataclass(frozen=True, slots=True)
class MarkerFix:
    """Where a marker is: point (3,) in m, covariance (3, 3) in m², and the sum of squared residuals over their expected
    variances, which averages `freedom`."""

    point: Array
    covariance: Array
    misfit: float
    freedom: int


def fix_marker(projections: Array, pixels: Array, sigmas: Array, start: Array) -> MarkerFix:
    """The likeliest place of a marker that cameras with projections (V, 3, 4), V >= 2, see at pixels (V, 2) with
    standard deviations (V,) px.

    Gauss-Newton on the weighted reprojection error from a point (3,) near by; the covariance is the inverse of the
    normal matrix. Views that disagree more than their deviations allow make it larger, never smaller.
    """
    point = start
    for _ in range(REFINEMENTS):
        jacobian, offset = _weighted(projections, pixels, sigmas, point)
        point = point + np.asarray(np.linalg.solve(_normal(jacobian), jacobian.T @ offset), dtype=np.float64)
    jacobian, offset = _weighted(projections, pixels, sigmas, point)
    misfit, freedom = float(offset @ offset), 2 * len(sigmas) - 3
    covariance = np.asarray(np.linalg.inv(_normal(jacobian)) * max(1.0, misfit / freedom), dtype=np.float64)
    return MarkerFix(point, covariance, misfit, freedom)


def magnifications(projections: Array, point: Array) -> Array:
    """The length in px (V,) of a metre across the line of sight of each camera (V, 3, 4) at a point (3,)."""
    _, jacobians = _projected(projections, point)
    areas: Array = np.sqrt(np.linalg.det(jacobians @ jacobians.transpose(0, 2, 1)))
    return np.sqrt(areas)


def _normal(jacobian: Array) -> Array:
    """The normal matrix (3, 3), kept from being singular where lines of sight coincide: that is told by its inverse."""
    normal: Array = jacobian.T @ jacobian
    normal += RIDGE * np.trace(normal) * np.eye(3)
    return normal


def _projected(projections: Array, point: Array) -> tuple[Array, Array]:
    """The pixels (V, 2) of a point, and how they move with it (V, 2, 3) in px per m."""
    image = projections[:, :, :3] @ point + projections[:, :, 3]
    pixels = image[:, :2] / image[:, 2:]
    return pixels, (projections[:, :2, :3] - pixels[..., None] * projections[:, 2:, :3]) / image[:, 2:, None]


def _weighted(projections: Array, pixels: Array, sigmas: Array, point: Array) -> tuple[Array, Array]:
    """Jacobian (2V, 3) and offsets (2V,) in standard deviations."""
    projected, jacobians = _projected(projections, point)
    offset = (pixels - projected) / sigmas[:, None]
    return (jacobians / sigmas[:, None, None]).reshape(-1, 3), offset.reshape(-1)
