"""How far a hand sample's covariance slows the arm: position and orientation judged separately; pure."""

import math
from dataclasses import dataclass

from common.messages.base import Covariance
from common.messages.hand import PointCovariances
from remote_site.safety.config import CertaintyConfig


@dataclass(frozen=True, slots=True)
class Certainty:
    """The fractions of full speed for position and rotation, 0 for too poor a sample; the wrist's sigma in mm."""

    position: float
    orientation: float
    wrist_mm: float


def certainty_of(covariance: PointCovariances | None, config: CertaintyConfig) -> Certainty:
    """Judge the points' covariances; a point without one counts as certain."""
    if covariance is None:
        return Certainty(1.0, 1.0, 0.0)
    wrist = _sigma_mm(covariance.wrist)
    tips = max(_sigma_mm(covariance.index), _sigma_mm(covariance.thumb), wrist)
    return Certainty(
        _fraction(wrist, config.wrist_sure_mm, config.wrist_poor_mm, config.slowest),
        _fraction(tips, config.tips_sure_mm, config.tips_poor_mm, config.slowest),
        wrist,
    )


def _sigma_mm(covariance: Covariance | None) -> float:
    """The root of the trace; inf where it is not finite."""
    if covariance is None:
        return 0.0
    trace = covariance[0] + covariance[3] + covariance[5]
    return 1e3 * math.sqrt(trace) if 0.0 <= trace < math.inf else math.inf


def _fraction(sigma_mm: float, sure_mm: float, poor_mm: float, slowest: float) -> float:
    if sigma_mm > poor_mm:
        return 0.0
    beyond = max(sigma_mm - sure_mm, 0.0) / (poor_mm - sure_mm)
    return 1.0 - beyond * (1.0 - slowest)
