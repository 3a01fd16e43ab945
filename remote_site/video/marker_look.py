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
REST = 4  # times as long as a look has taken, before the view's next one: a large picture full of markers takes 200 ms


class MarkerLook:
    """Finds the markers that targets name in calibrated views; `tool_at` is where the tool was at a time, if known.

    By `clock` a look ends in time, whatever is before a camera, and looks at a view take a fifth of the time at most.
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
        self._due_ns: dict[str, int] = {}
        self._unreached: dict[str, tuple[int, ...]] = {}
        self._clock = clock
        self._published_ns = 0

    def see(self, view: str, frame: Frame | None, now_ns: int) -> None:
        """Take a view's newest picture, if its next look is due, and publish what all views show, if that is due."""
        if frame is not None and view in self._views and frame.capture_ns >= self._due_ns.get(view, 0):
            begun_ns = self._clock.now_ns()
            left = self._unreached.get(view, ())
            found = self._detector.find(frame.image, lambda: self._clock.now_ns() - begun_ns < BUDGET_NS, first=left)
            took_ns = self._clock.now_ns() - begun_ns
            self._due_ns[view] = frame.capture_ns + max(LOOK_NS, (1 + REST) * took_ns)
            self._unreached[view] = found.unreached
            self._watch.observe(view, frame.capture_ns, found, self._tool_at(frame.capture_ns))
        if now_ns - self._published_ns >= LOOK_NS:
            self._published_ns = now_ns
            self._publish(self._watch.sightings(now_ns))
