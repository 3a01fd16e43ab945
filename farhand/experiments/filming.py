"""The simulated operator filmed at some rate and tracked, picture by picture: measured and true; no clock runs."""

from collections.abc import Callable
from dataclasses import dataclass

import cv2

from common.cameras.camera import Frame
from common.clock import NS_PER_S
from common.errors import InterruptionError
from local_site.simulation.cameras import calibrate_simulated
from local_site.simulation.config import SimulationConfig
from local_site.simulation.operator import SimulatedOperator
from local_site.tracking.choice import TrackingConfig, make_tracker
from local_site.tracking.tracker import ArmEstimate, View, Views

Progress = Callable[[], bool]


@dataclass(frozen=True, slots=True)
class Film:
    """What the tracker measured in every frame, unsmoothed, at `fps` from time zero of the operator's motion."""

    operator: SimulatedOperator
    fps: float
    estimates: tuple[ArmEstimate, ...]


def film(config: SimulationConfig, tracking: TrackingConfig, fps: float, seconds: float, progress: Progress) -> Film:
    """Render and track all frames of so many seconds; deterministic by the configuration's seed.

    `progress` is called after every frame; when it says False, InterruptionError.
    """
    cv2.setNumThreads(1)
    operator = SimulatedOperator(config)
    tracker = make_tracker(calibrate_simulated(config), tracking)
    estimates: list[ArmEstimate] = []
    for k in range(round(seconds * fps) + 1):
        t_ns = round(k * NS_PER_S / fps)
        views = tuple(View(Frame(picture, t_ns, k)) for picture in operator.render(t_ns / NS_PER_S))
        estimates.append(tracker.track(Views(t_ns, views)))
        if not progress():
            raise InterruptionError("interrupted before the experiment was done; nothing was written")
    return Film(operator, fps, tuple(estimates))
