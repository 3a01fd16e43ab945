"""Certainty of a hand sample by its covariances, of the points that the arm copies: how far it slows the arm; pure."""

import math
from dataclasses import dataclass

from common.messages.base import Covariance
from common.messages.hand import HandPoint, PointCovariances
from remote_site.safety.config import CertaintyConfig

NONE_KNOWN = PointCovariances()
ELBOW_POINTS = ("elbow", "wrist")  # what an arm with seven axes copies is the direction from the one to the other


@dataclass(frozen=True, slots=True)
class Certainty:
    """The fraction of full speed, 0 for too poor a sample; the sigma in mm of the point that the tool copies.

    The sigma is inf where the sample states it for other points alone, or where it is no number.
    """

    position: float
    sigma_mm: float


def certainty_of(covariance: PointCovariances | None, point: HandPoint, config: CertaintyConfig) -> Certainty:
    """Judge the covariance of the point that the tool copies; a sample that states none at all counts as certain."""
    sigma_mm = _sigma_mm(covariance, point)
    return Certainty(_fraction(sigma_mm, config), sigma_mm)


def elbow_is_certain(covariance: PointCovariances | None, config: CertaintyConfig) -> bool:
    """Return whether the elbow may be copied; poorer than the arm may follow, it is as good as not seen."""
    return all(_sigma_mm(covariance, point) <= config.position_poor_mm for point in ELBOW_POINTS)


def _sigma_mm(covariance: PointCovariances | None, point: str) -> float:
    """The root of the trace."""
    if covariance is None or covariance == NONE_KNOWN:
        return 0.0
    known: Covariance | None = getattr(covariance, point)
    if known is None:
        return math.inf
    trace = known[0] + known[3] + known[5]
    return 1e3 * math.sqrt(trace) if 0.0 <= trace < math.inf else math.inf


def _fraction(sigma_mm: float, config: CertaintyConfig) -> float:
    if sigma_mm > config.position_poor_mm:
        return 0.0
    beyond = max(sigma_mm - config.position_sure_mm, 0.0) / (config.position_poor_mm - config.position_sure_mm)
    return 1.0 - beyond * (1.0 - config.slowest)
