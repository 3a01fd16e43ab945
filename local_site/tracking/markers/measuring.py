"""Measures each marker from its spots: position with covariance from centroids, size, and visible fraction."""

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np

from common.geometry import Array
from local_site.calibration.rig import Rig
from local_site.calibration.triangulation import images_of
from local_site.tracking.markers.correspondence import Candidates
from local_site.tracking.markers.spots import Spots

REFINEMENTS = 2
RIDGE = 1e-12


@dataclass(frozen=True, slots=True)
class MarkerFix:
    """A marker's position (3,) in m, covariance (3, 3) in m², and the sum of squared residuals over their expected
    variances, whose mean is `freedom`."""

    point: Array
    covariance: Array
    misfit: float
    freedom: int


def fix_marker(projections: Array, pixels: Array, sigmas: Array, start: Array) -> MarkerFix:
    """The maximum likelihood position of a marker that cameras with projections (V, 3, 4), V >= 2, see at pixels (V, 2)
    with standard deviations (V,) px.

    Gauss-Newton on the weighted reprojection error from a point (3,) nearby; the covariance is the inverse of the
    normal matrix. Views that disagree by more than their deviations increase it.
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
    _, jacobians = images_of(projections, point)
    areas: Array = np.sqrt(np.linalg.det(jacobians @ jacobians.transpose(0, 2, 1)))
    return np.sqrt(areas)


def _normal(jacobian: Array) -> Array:
    """The normal matrix (3, 3) with a small ridge, so that it is invertible where the lines of sight coincide."""
    normal: Array = jacobian.T @ jacobian
    normal += RIDGE * np.trace(normal) * np.eye(3)
    return normal


def _weighted(projections: Array, pixels: Array, sigmas: Array, point: Array) -> tuple[Array, Array]:
    """Jacobian (2V, 3) and residuals (2V,) in standard deviations."""
    projected, jacobians = images_of(projections, point)
    residuals = (pixels - projected) / sigmas[:, None]
    return (jacobians / sigmas[:, None, None]).reshape(-1, 3), residuals.reshape(-1)


# What sampling by pixels leaves of a centroid, px.
SAMPLING_SIGMA_PX = 0.04
# A projection of p = 11 numbers fitted to N = 75 points (thesis section 3.2.9.1) is off by sqrt(p / (2N - p)) of the
# residual of a coordinate, which is the rig's rms distance over the square root of two.
CALIBRATION_FRACTION = 0.2
# If a small fraction of a disc is hidden, its centroid moves by about this many radii times the fraction.
HIDDEN_SHIFT = 0.85
FRACTION_NOISE = 0.04
WHOLE = (0.85, 1.2)


@dataclass(frozen=True, slots=True)
class Sighting:
    """A measured marker: its position, its spot in each view (-1 for none), the largest reprojection error in px, its
    diameter in m, and the fraction (V,) of its area that each view shows: NaN for none, more than 1 if it is merged
    with something else."""

    fix: MarkerFix
    spots: tuple[int, ...]
    residual_px: float
    size: float
    fractions: Array

    @property
    def is_whole(self) -> bool:
        """Return whether all views that see the marker show all of it and nothing bright beside it."""
        seen = self.fractions[np.isfinite(self.fractions)]
        return bool(np.all((seen >= WHOLE[0]) & (seen <= WHOLE[1])))


class MarkerMeter:
    """Measures chosen candidates with all views that see them."""

    def __init__(self, rig: Rig) -> None:
        self._projections = np.array(rig.matrices)
        self._calibration_px = [CALIBRATION_FRACTION * camera.reprojection_rms_px for camera in rig.cameras]

    def measure(self, candidates: Candidates, which: int, spots: Sequence[Spots], size: float | None) -> Sighting:
        """One candidate's marker; `size` is its diameter in m if known."""
        members = candidates.members[which]
        start = candidates.points[which]
        seen = [k for k in range(len(members)) if members[k] >= 0]
        scales = magnifications(self._projections[seen], start)
        areas = np.array([spots[k].areas[members[k]] for k in seen])
        diameters = np.sqrt(4.0 * areas / np.pi) / np.maximum(scales, 1e-9)
        fractions = np.full(len(members), np.nan)
        fractions[seen] = 1.0 if size is None else (diameters / size) ** 2
        pixels = np.array([spots[k].pixels[members[k]] for k in seen])
        noises = [(spots[k].sigmas[members[k]], self._calibration_px[k]) for k in seen]
        sigmas = np.array([np.sqrt(noise**2 + SAMPLING_SIGMA_PX**2 + rms**2) for noise, rms in noises])
        if size is not None:
            missing = np.abs(1.0 - fractions[seen])
            hidden = np.where(missing > FRACTION_NOISE, HIDDEN_SHIFT * (0.5 * size * scales) * missing, 0.0)
            sigmas = np.hypot(sigmas, hidden)
        fix = fix_marker(self._projections[seen], pixels, sigmas, start)
        residual_px = float(candidates.residuals[which])
        return Sighting(fix, tuple(int(m) for m in members), residual_px, float(np.median(diameters)), fractions)
