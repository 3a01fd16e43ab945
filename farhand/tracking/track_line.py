"""One pair of a track as it is written: status, points, how certain they are, and what it took."""

import math

import msgspec
import numpy as np

from common.geometry import Array
from common.messages.base import Vector3
from common.messages.hand import TrackingStatus
from local_site.samples.hand_sample import OpenHand
from local_site.tracking.tracker import ArmEstimate

POINTS = ("elbow", "wrist", "index", "thumb")
ALL_POINTS = (*POINTS, "palm")


class TrackLine(msgspec.Struct, frozen=True, kw_only=True):
    """One pair of a recording: points (m, operator frame) and their uncertainty, null where unknown.

    `sigma` in m is the root of the covariance's trace: the rms length of the point's 3D error, not of one axis.
    `residual_px` is the rms epipolar residual between the views; `ms` is how long the pair was tracked.
    """

    frame: int
    t_ns: int
    status: TrackingStatus
    reason: str
    elbow: Vector3 | None
    wrist: Vector3 | None
    index: Vector3 | None
    thumb: Vector3 | None
    sigma: dict[str, float | None]
    thumb_inferred: bool
    hand_open: bool
    gripper_toggles: int
    ms: float
    palm: Vector3 | None = None
    residual_px: float | None = None


def track_line(frame: int, estimate: ArmEstimate, hand: OpenHand, ms: float) -> TrackLine:
    """The line of the pair with this number, counted from 0."""
    return TrackLine(
        frame=frame,
        t_ns=estimate.t_ns,
        status=estimate.status,
        reason=estimate.reason,
        sigma={name: _sigma(estimate, name) for name in POINTS},
        thumb_inferred=estimate.thumb_inferred,
        hand_open=hand.is_open,
        gripper_toggles=hand.toggles,
        ms=round(ms, 3),
        residual_px=_finite(estimate.residual_px),
        **{name: _vector(getattr(estimate, name)) for name in ALL_POINTS},
    )


def _sigma(estimate: ArmEstimate, name: str) -> float | None:
    """The rms length of a point's 3D error, m."""
    if getattr(estimate, name) is None or name not in estimate.covariances:
        return None
    variance = float(np.trace(estimate.covariances[name]))
    return round(math.sqrt(variance), 6) if 0 <= variance < math.inf else None


def _finite(value: float | None) -> float | None:
    return round(float(value), 3) if value is not None and math.isfinite(value) else None


def _vector(point: Array | None) -> Vector3 | None:
    if point is None:
        return None
    x, y, z = (round(float(value), 6) for value in point)
    return x, y, z
