"""A motion of the thesis's, filmed and tracked: the points tracked and the true ones, frame by frame."""

from collections.abc import Sequence
from dataclasses import dataclass

import msgspec
import numpy as np

from common.clock import NS_PER_S
from common.errors import ProcessError
from common.geometry import Array
from lab.experiments.following import film
from lab.experiments.report import Progress
from lab.experiments.thesis.paths import FPS, Recorded
from local_site.simulation.body import ArmTruth
from local_site.simulation.config import SimulationConfig
from local_site.tracking.choice import TrackingConfig
from local_site.tracking.tracker import ArmEstimate


@dataclass(frozen=True, slots=True)
class TrackedFilm:
    """The tracker's measurements in the frames that count, and the truth of them."""

    estimates: Sequence[ArmEstimate]
    truths: Sequence[ArmTruth]

    def tracked(self, name: str) -> Array:
        """A point's measured positions (N, 3), operator frame, m; NaN where not; ProcessError if it never was."""
        points = [getattr(estimate, name) for estimate in self.estimates]
        if all(point is None for point in points):
            raise ProcessError(f"the {name} was not tracked in any frame; check the tracking")
        return np.array([np.full(3, np.nan) if point is None else point for point in points])

    def true(self, name: str) -> Array:
        """A point's true positions (N, 3), operator frame, m."""
        return np.array([getattr(truth, name) for truth in self.truths])


def film_recorded(config: SimulationConfig, recorded: Recorded, method: str, progress: Progress) -> TrackedFilm:
    """Film a motion and track it, with markers worn where they are what is tracked."""
    config = msgspec.structs.replace(config, motion=recorded.motion, markers=method == "markers")
    filmed = film(config, TrackingConfig(method=method), FPS, recorded.seconds, progress, recorded.path)
    estimates = filmed.estimates[-recorded.frames :]
    return TrackedFilm(estimates, [filmed.operator.truth(estimate.t_ns / NS_PER_S) for estimate in estimates])
