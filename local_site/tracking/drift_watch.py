"""Watches over the calibration while the arm is tracked: says once, and in every reason, that a camera has moved."""

from collections.abc import Callable
from dataclasses import replace

from local_site.calibration.drift import DriftAlarm, DriftConfig
from local_site.calibration.rig import Rig
from local_site.tracking.tracker import ArmEstimate


class DriftWatch:
    """Feeds the drift alarm with what the views of each instant miss each other by; `tell` hears of it once."""

    def __init__(self, rig: Rig, config: DriftConfig, tell: Callable[[str], None]) -> None:
        self._alarm = DriftAlarm(rig.epipolar_px, config)
        self._tell: Callable[[str], None] | None = tell

    def judge(self, estimate: ArmEstimate) -> ArmEstimate:
        """The estimate; while the alarm rings, with its sentence at the end of the reason."""
        residuals_px = () if estimate.residual_px is None else (estimate.residual_px,)
        sentence = self._alarm.feed(residuals_px, estimate.t_ns)
        if sentence is None:
            return estimate
        if self._tell is not None:
            self._tell(sentence)
            self._tell = None
        return replace(estimate, reason="; ".join(filter(None, (estimate.reason, sentence))))
