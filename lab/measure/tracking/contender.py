"""One of our trackers on a scene, timed, with a counter of the hand's openings that takes its estimates."""

import time

from lab.measure.tracking.figures import Found
from lab.films.scenes import TrackingScene
from common.messages.hand import TrackingStatus
from local_site.samples.hand_sample import GestureConfig, OpenHand
from local_site.tracking.choice import TrackingConfig, make_tracker
from local_site.tracking.tracker import Views

NAMES = ("elbow", "wrist", "index", "thumb")


class Contender:
    """A tracker by its method; NotInstalledError where its models are missing."""

    def __init__(self, method: str, scene: TrackingScene) -> None:
        self._tracker = make_tracker(scene.rig, TrackingConfig(method=method))
        self._hand = OpenHand()

    def track(self, views: Views) -> Found:
        """Track the next pair of images; the counter's time is not included."""
        wall, processor = time.perf_counter(), time.process_time()
        estimate = self._tracker.track(views)
        wall_ms, processor_ms = 1e3 * (time.perf_counter() - wall), 1e3 * (time.process_time() - processor)
        self._hand = self._hand.observe(estimate, GestureConfig())
        by_name = {name: getattr(estimate, name) for name in NAMES}
        return Found(
            points={name: point for name, point in by_name.items() if point is not None},
            wall_ms=wall_ms,
            processor_ms=processor_ms,
            covariances=estimate.covariances,
            thumb_inferred=estimate.thumb_inferred,
            is_tracked=estimate.status is TrackingStatus.TRACKED,
            toggles=self._hand.toggles,
        )
