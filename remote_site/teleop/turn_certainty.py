"""Speed at which the hand may turn the tool about each of the hand's axes, by its points' covariances; pure."""

import math

import numpy as np

from common.geometry import Array
from common.messages.base import Covariance, Vector3
from common.messages.hand import HandArm, PointCovariances
from remote_site.safety.config import CertaintyConfig, SafetyConfig
from remote_site.teleop.certainty import NONE_KNOWN

FREE = (math.inf, math.inf, math.inf)
POINTS = 3  # wrist, index and thumb


def turn_speeds(sample: HandArm, operator_R_hand: Array, config: SafetyConfig) -> Vector3:
    """The fastest turn about the hand's x, y and z in rad/s: inf where it is sure, 0 where it is too poor.

    `operator_R_hand` (3 x 3) is what the sample shows. A sample that states no covariance at all counts as certain; one
    that leaves out one of the three points turns nothing. An inferred thumb never turns the tool faster than
    `inferred_turn_deg_s`, however sure it seems.
    """
    known = sample.covariance
    if known is None or known == NONE_KNOWN:
        return FREE
    x, y, z = (_speed(variance, sample, config) for variance in _variances(sample, known, operator_R_hand))
    return x, y, z


def rotation_covariance(
    operator_R_hand: Array, to_index: Array, to_thumb: Array, covariances: tuple[Array, Array, Array]
) -> Array:
    """The covariance (3 x 3) in rad² of a small rotation of the hand, about the hand's own axes.

    It follows from those of wrist, index and thumb (3 x 3 each, m², operator frame), taken as independent; `to_index`
    and `to_thumb` (3,) in m lead from the wrist to the tips. To first order, as `hand_rotation` makes the axes.
    """
    _, y, z = operator_R_hand.T
    ahead = math.sqrt(float(np.sum((to_index + to_thumb) ** 2)))
    area = float(z @ np.cross(to_index, to_thumb))
    pointing = np.array([-z, y]) / ahead
    of_index = np.vstack([-np.cross(to_thumb, y) / area, pointing])
    of_thumb = np.vstack([-np.cross(y, to_index) / area, pointing])
    parts = zip((-of_index - of_thumb, of_index, of_thumb), covariances, strict=True)
    total: Array = sum((of_point @ covariance @ of_point.T for of_point, covariance in parts), np.zeros((3, 3)))
    return total


def _variances(sample: HandArm, known: PointCovariances, operator_R_hand: Array) -> list[float]:
    wrist, index, thumb = (np.array(point) for point in (sample.wrist, sample.index, sample.thumb))
    stated = [covariance for covariance in (known.wrist, known.index, known.thumb) if covariance is not None]
    if len(stated) < POINTS:
        return [math.inf] * POINTS
    covariances = _matrix(stated[0]), _matrix(stated[1]), _matrix(stated[2])
    if not np.isfinite(covariances).all():
        return [math.inf] * POINTS
    covariance = rotation_covariance(operator_R_hand, index - wrist, thumb - wrist, covariances)
    return [float(variance) for variance in np.diag(covariance)]


def _matrix(covariance: Covariance) -> Array:
    xx, xy, xz, yy, yz, zz = covariance
    return np.array([[xx, xy, xz], [xy, yy, yz], [xz, yz, zz]])


def _speed(variance: float, sample: HandArm, config: SafetyConfig) -> float:
    fraction = _fraction(variance, config.certainty)
    if sample.thumb_inferred:
        return fraction * math.radians(config.inferred_turn_deg_s)
    return math.inf if fraction == 1.0 else fraction * math.radians(config.hand_turn_deg_s)


def _fraction(variance: float, config: CertaintyConfig) -> float:
    """Of full speed: 1 up to the sure angle, 0 from the poor one on or where the variance is no number."""
    if not 0.0 <= variance < math.inf:
        return 0.0
    beyond = math.degrees(math.sqrt(variance)) - config.turn_sure_deg
    return 1.0 - min(max(beyond, 0.0) / (config.turn_poor_deg - config.turn_sure_deg), 1.0)
