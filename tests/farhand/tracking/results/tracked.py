"""Tracked pairs as a test wants them: a wrist where it says, in views of one grey."""

import numpy as np

from common.cameras.camera import Frame
from common.clock import NS_PER_S
from common.messages.hand import TrackingStatus
from farhand.tracking.results.tracked_pair import Result, TrackedPair
from farhand.tracking.track_line import track_line
from local_site.calibration.rig import Rig
from local_site.samples.hand_sample import OpenHand
from local_site.simulation.cameras import exact_rig
from local_site.simulation.config import StereoConfig
from local_site.tracking.tracker import ArmEstimate, View, Views

FPS = 25.0
WIDTH, HEIGHT = 161, 121  # odd, as codecs do not like it
RIG: Rig = exact_rig(StereoConfig())


def pair(
    frame: int,
    wrist: tuple[float, float, float] | None = None,
    *,
    sigma_mm: float = 1.0,
    reason: str = "",
    status: TrackingStatus | None = None,
    grey: int = 60,
    residual_px: float | None = None,
    fps: float = FPS,
) -> TrackedPair:
    """A pair of the left and the right camera; without a wrist, and unless stated otherwise, it is lost."""
    t_ns = round(frame * NS_PER_S / fps)
    view = View(Frame(np.full((HEIGHT, WIDTH), grey, np.uint8), t_ns, frame))
    found = status or (TrackingStatus.LOST if wrist is None else TrackingStatus.TRACKED)
    covariance = np.eye(3) * (sigma_mm * 1e-3) ** 2 / 3
    place, covariances = (None, {}) if wrist is None else (np.array(wrist), {"wrist": covariance})
    estimate = ArmEstimate(t_ns, found, reason, wrist=place, covariances=covariances, residual_px=residual_px)
    line = track_line(frame, estimate, OpenHand(), 5.0)
    return TrackedPair(RIG, Views(t_ns, (view, view)), estimate, line, frame / fps)


def write_then_fail(result: Result, pairs: int, error: Exception) -> None:
    """A track that ends with an error after some lost pairs."""
    with result as take:
        for k in range(pairs):
            take(pair(k))
        raise error
