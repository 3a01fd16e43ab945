"""Looks for markers in the cameras' full pictures, at a few of them a second, and passes on what is known of them."""

from collections.abc import Callable, Mapping, Sequence

from common.cameras.camera import Frame
from common.clock import NS_PER_MS, Clock
from common.geometry import Array
from common.messages.requests import ViewCalibration
from remote_site.assist.config import AssistConfig
from remote_site.assist.detection import MarkerDetector
from remote_site.assist.marker_watch import MarkerWatch
from remote_site.assist.sighting import MarkerSighting

LOOK_NS = 160 * NS_PER_MS  # of each view: a look takes some milliseconds that its pictures lack
BUDGET_NS = 60 * NS_PER_MS  # of a look; what is not reached comes first in the view's next one


class MarkerLook:
    """Finds the markers that targets name in calibrated views; `tool_at` is where the tool was at a time, if known.

    By `clock` a look ends in time, whatever is before a camera.
    """

    def __init__(
        self,
        config: AssistConfig,
        views: Mapping[str, ViewCalibration],
        tool_at: Callable[[int], Array | None],
        publish: Callable[[Sequence[MarkerSighting]], None],
        clock: Clock,
    ) -> None:
        self._detector = MarkerDetector(config.family, config.marker_sizes_m)
        self._watch = MarkerWatch(config, views)
        self._views, self._tool_at, self._publish = frozenset(views), tool_at, publish
        self._looked_ns: dict[str, int] = {}
        self._unreached: dict[str, tuple[int, ...]] = {}
        self._clock = clock
        self._published_ns = 0

    def see(self, view: str, frame: Frame | None, now_ns: int) -> None:
        """Take a view's newest picture, if its next look is due, and publish what all views show, if that is due."""
        is_new = frame is not None and frame.capture_ns - self._looked_ns.get(view, -LOOK_NS) >= LOOK_NS
        if frame is not None and is_new and view in self._views:
            self._looked_ns[view] = frame.capture_ns
            end_ns = self._clock.now_ns() + BUDGET_NS
            left = self._unreached.get(view, ())
            found = self._detector.find(frame.image, lambda: self._clock.now_ns() < end_ns, first=left)
            self._unreached[view] = found.unreached
            self._watch.observe(view, frame.capture_ns, found, self._tool_at(frame.capture_ns))
        if now_ns - self._published_ns >= LOOK_NS:
            self._published_ns = now_ns
            self._publish(self._watch.sightings(now_ns))
