"""How far a hand sample's covariance slows the arm: by the certainty of its wrist; pure."""

import math
from dataclasses import dataclass

from common.messages.base import Covariance
from common.messages.hand import PointCovariances
from remote_site.safety.config import CertaintyConfig


@dataclass(frozen=True, slots=True)
class Certainty:
    """The fraction of full speed, 0 for too poor a sample; the wrist's sigma in mm."""

    position: float
    wrist_mm: float


def certainty_of(covariance: PointCovariances | None, config: CertaintyConfig) -> Certainty:
    """Judge the wrist's covariance; a point without one counts as certain."""
    if covariance is None:
        return Certainty(1.0, 0.0)
    wrist = _sigma_mm(covariance.wrist)
    return Certainty(_fraction(wrist, config), wrist)


def _sigma_mm(covariance: Covariance | None) -> float:
    """The root of the trace; inf where it is not finite."""
    if covariance is None:
        return 0.0
    trace = covariance[0] + covariance[3] + covariance[5]
    return 1e3 * math.sqrt(trace) if 0.0 <= trace < math.inf else math.inf


def _fraction(sigma_mm: float, config: CertaintyConfig) -> float:
    if sigma_mm > config.wrist_poor_mm:
        return 0.0
    beyond = max(sigma_mm - config.wrist_sure_mm, 0.0) / (config.wrist_poor_mm - config.wrist_sure_mm)
    return 1.0 - beyond * (1.0 - config.slowest)
