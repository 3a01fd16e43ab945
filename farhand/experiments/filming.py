"""The simulated operator filmed at some rate and tracked, picture by picture: measured and true; no clock runs."""

from collections.abc import Callable
from dataclasses import dataclass

import cv2

from common.cameras.camera import Frame
from common.clock import NS_PER_S
from local_site.simulation.calibrated import calibrate_simulated
from local_site.simulation.config import SimulationConfig
from local_site.simulation.operator import SimulatedOperator
from local_site.tracking.choice import TrackingConfig, make_tracker
from local_site.tracking.tracker import ArmEstimate, View, Views

Progress = Callable[[], object]  # called after every frame; may raise, as InterruptionError when a person ends the work


@dataclass(frozen=True, slots=True)
class Film:
    """What the tracker measured in every frame, unsmoothed, at `fps` from time zero of the operator's motion."""

    operator: SimulatedOperator
    fps: float
    estimates: tuple[ArmEstimate, ...]


def film(config: SimulationConfig, tracking: TrackingConfig, fps: float, seconds: float, progress: Progress) -> Film:
    """Render and track all frames of `seconds`; deterministic by the configuration's seed."""
    cv2.setNumThreads(1)
    operator = SimulatedOperator(config)
    tracker = make_tracker(calibrate_simulated(config), tracking)
    estimates: list[ArmEstimate] = []
    for k in range(round(seconds * fps) + 1):
        t_ns = round(k * NS_PER_S / fps)
        views = tuple(View(Frame(picture, t_ns, k)) for picture in operator.render(t_ns / NS_PER_S))
        estimates.append(tracker.track(Views(t_ns, views)))
        progress()
    return Film(operator, fps, tuple(estimates))
