"""Fit of a rig's file to these cameras: what the views miss each other by, against the wrist's own sigma."""

import math
from collections import deque
from dataclasses import dataclass

import numpy as np

from local_site.calibration.rig import Rig
from local_site.calibration.triangulation import image_of
from local_site.tracking.tracker import ArmEstimate, TrackingReason

LEAST_PAIRS = 20
MISFIT_SHARE = 0.5
WRIST = "wrist"


@dataclass(frozen=True, slots=True)
class _Compared:
    """A pair whose views were compared: the residual, and what the wrist's sigma explains of it (NaN: unknown), px."""

    t_ns: int
    residual_px: float
    explained_px: float
    misfits: bool


class RigFit:
    """Compares pairs of views of a rig, and says when most of them contradict it.

    A pair contradicts it if its residual is more than `sigmas` times the wrist's sigma in the pictures and the rig's
    own residual at calibration, or if the tracker says that the views do not fit together. A camera that is turned in
    the plane of both cameras and the arm moves points along their epipolar lines: this is not seen.
    """

    def __init__(self, rig: Rig, sigmas: float) -> None:
        self._matrices, self._calibrated_px = rig.matrices, rig.epipolar_px or 0.0
        self._sigmas = sigmas
        self._pairs: deque[_Compared] = deque()

    def add(self, estimate: ArmEstimate) -> None:
        """Take a pair; one whose views were not compared says nothing."""
        residual_px = estimate.residual_px
        if residual_px is None or not math.isfinite(residual_px):
            return
        refused = TrackingReason.OUT_OF_STEP in estimate.reason
        explained_px = self._calibrated_px + self._sigmas * self._wrist_sigma_px(estimate)
        if refused or math.isfinite(explained_px):
            misfits = refused or residual_px > explained_px
            self._pairs.append(_Compared(estimate.t_ns, residual_px, explained_px, misfits))

    def forget_before(self, t_ns: int) -> None:
        """Forget the pairs before a time."""
        while self._pairs and self._pairs[0].t_ns < t_ns:
            self._pairs.popleft()

    @property
    def begin_ns(self) -> int | None:
        """The time of the first pair that counts."""
        return self._pairs[0].t_ns if self._pairs else None

    def problem(self) -> str:
        """A sentence with the cure if most pairs contradict the rig; empty if they do not, or are too few."""
        misfits = sum(pair.misfits for pair in self._pairs)
        if len(self._pairs) < LEAST_PAIRS or misfits <= MISFIT_SHARE * len(self._pairs):
            return ""
        explained = [pair.explained_px for pair in self._pairs if math.isfinite(pair.explained_px)]
        known = f", the wrist's sigma explains {np.median(explained):.1f}" if explained else ""
        return (
            f"the views miss each other by {np.median([pair.residual_px for pair in self._pairs]):.1f} px{known}: the "
            "calibration does not fit these cameras; calibrate again, or give the file of this rig"
        )

    def _wrist_sigma_px(self, estimate: ArmEstimate) -> float:
        """The wrist's sigma along one axis of a picture, rms over all of them; NaN where it is not known."""
        covariance = estimate.covariances.get(WRIST)
        if estimate.wrist is None or covariance is None:
            return math.nan
        jacobians = [image_of(matrix, estimate.wrist)[1] for matrix in self._matrices]
        variances = [float(np.trace(jacobian @ covariance @ jacobian.T)) / 2 for jacobian in jacobians]
        return math.sqrt(max(float(np.mean(variances)), 0.0))
