"""Drift: detects from the epipolar residuals of tracked points that a camera has moved, or is not the rig's."""

import math
from collections import deque
from collections.abc import Callable, Iterable
from dataclasses import replace
from typing import Annotated

import msgspec
import numpy as np
from msgspec import Meta

from common.clock import NS_PER_S
from local_site.calibration.rig import Rig
from local_site.tracking.rig_fit import RigFit
from local_site.tracking.tracker import ArmEstimate


class DriftConfig(msgspec.Struct, frozen=True, kw_only=True, forbid_unknown_fields=True):
    """From which residuals on a camera counts as moved, or as another than the rig's."""

    learn_s: Annotated[float, Meta(gt=0, le=60, description="first seconds of tracking, whose level is normal")] = 5.0
    window_s: Annotated[float, Meta(gt=0, le=600, description="over which the median is taken")] = 10.0
    min_residuals: Annotated[int, Meta(ge=10, le=10_000, description="fewer in a window give no verdict")] = 100
    factor: Annotated[float, Meta(gt=1, le=20, description="a median this many times the normal level, and")] = 2.0
    margin_px: Annotated[float, Meta(gt=0, le=50, description="at least this much above it, is drift, px")] = 1.5
    misfit_sigmas: Annotated[
        float,
        Meta(gt=1, le=20, description="a residual of more sigmas of the wrist, in the picture, contradicts the rig"),
    ] = 1.25  # noise alone gives up to 1.15 in two views


class DriftAlarm:
    """Compares the median residual of a time window with that of the first seconds, as the calibration drifts.

    `calibrated_px` is the rig's own median residual, to be reported. Tracked points are noisier than a plate's, so the
    normal level is learned from the first seconds; whether that level itself fits the rig, RigFit says.
    """

    def __init__(self, calibrated_px: float | None, config: DriftConfig | None = None) -> None:
        self._calibrated_px = calibrated_px or 0.0
        self._config = config or DriftConfig()
        self._residuals: deque[tuple[int, float]] = deque()
        self._first_ns: int | None = None
        self._judged_ns = -NS_PER_S
        self._normal_px: float | None = None
        self._sentence: str | None = None

    def feed(self, residuals_px: Iterable[float], time_ns: int) -> str | None:
        """Take the residuals of one instant, ignoring NaN; a sentence while a camera seems to have moved, else None."""
        self._residuals.extend((time_ns, value) for value in residuals_px if math.isfinite(value))
        if self._first_ns is None and self._residuals:
            self._first_ns = time_ns
        oldest_ns = time_ns - self._config.window_s * NS_PER_S
        while self._residuals and self._residuals[0][0] < oldest_ns:
            self._residuals.popleft()
        if time_ns - self._judged_ns >= NS_PER_S:
            self._judged_ns = time_ns
            self._sentence = self._judge(time_ns)
        return self._sentence

    def _judge(self, time_ns: int) -> str | None:
        if self._first_ns is None or len(self._residuals) < self._config.min_residuals:
            return None
        median = float(np.median([value for _, value in self._residuals]))
        if self._normal_px is None:
            if time_ns - self._first_ns < self._config.learn_s * NS_PER_S:
                return None
            self._normal_px = median
            self._residuals.clear()
        limit = max(self._config.factor * self._normal_px, self._normal_px + self._config.margin_px)
        if median <= limit:
            return None
        return (
            f"tracked points miss their epipolar lines by {median:.1f} px ({self._normal_px:.1f} px at the start, "
            f"{self._calibrated_px:.1f} px at calibration): a camera has moved or the views are out of step; "
            "calibrate again"
        )


class DriftWatch:
    """Judges each estimate's residual; `warn` is called once with the first sentence of an alarm."""

    def __init__(self, rig: Rig, config: DriftConfig, warn: Callable[[str], None]) -> None:
        self._alarm = DriftAlarm(rig.epipolar_px, config)
        self._fit, self._misfit = RigFit(rig, config.misfit_sigmas), ""
        self._judged_ns = -NS_PER_S
        self._config = config
        self._warn: Callable[[str], None] | None = warn

    def judge(self, estimate: ArmEstimate) -> ArmEstimate:
        """The estimate; during an alarm with its sentence at the end of the reason."""
        residuals_px = () if estimate.residual_px is None else (estimate.residual_px,)
        self._fit.add(estimate)
        if estimate.t_ns - self._judged_ns >= NS_PER_S:
            self._judged_ns, self._misfit = estimate.t_ns, self._judge_rig(estimate.t_ns)
        sentence = self._alarm.feed(residuals_px, estimate.t_ns) or self._misfit
        if not sentence:
            return estimate
        if self._warn is not None:
            self._warn(sentence)
            self._warn = None
        return replace(estimate, reason="; ".join(filter(None, (estimate.reason, sentence))))

    def _judge_rig(self, t_ns: int) -> str:
        """Say how the last seconds contradict the rig; empty if they do not, or while too little was seen."""
        self._fit.forget_before(t_ns - round(self._config.window_s * NS_PER_S))
        begin_ns = self._fit.begin_ns
        if begin_ns is None or t_ns - begin_ns < self._config.learn_s * NS_PER_S:
            return ""
        return self._fit.problem()
