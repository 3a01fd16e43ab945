"""The pictures that the operating page has painted, reported to the remote site in that site's own numbers."""

from collections import deque
from dataclasses import dataclass, field

from common.clock import NS_PER_MS, NS_PER_S
from common.messages.video import (
    VideoFrame,
    ViewCame,
    ViewShown,
    ViewsShown,
)
from local_site.console.model.page_messages import Painted, Shown

REMEMBERED = 64
CAMERA_VIEW = "camera/"
LEAST_APART_NS = 50 * NS_PER_MS


@dataclass
class _Arrivals:
    """The last frames of one camera: numbers and exposures by the remote clock, arrival times, the newest's age."""

    exposed: deque[tuple[int, int]] = field(default_factory=lambda: deque(maxlen=REMEMBERED))
    came_ns: deque[int] = field(default_factory=lambda: deque(maxlen=REMEMBERED))
    age_ms: float | None = None

    def newest(self, now_ns: int) -> ViewCame | None:
        """Return what to report of it; None before the first picture of known age."""
        if self.age_ms is None:
            return None
        of_last_second = sum(came_ns > now_ns - NS_PER_S for came_ns in self.came_ns)
        return ViewCame(seq=self.exposed[-1][0], age_ms=self.age_ms, fps=float(of_last_second))


class ShownViews:
    """Remembers when the last frames of each camera were exposed, by the remote clock, and how they came."""

    def __init__(self, session: int) -> None:
        self._session = session
        self._arrivals: dict[str, _Arrivals] = {}
        self._sent_ns = 0

    def remember(self, view: str, frame: VideoFrame, now_ns: int, offset_ns: int | None, *, usable: bool) -> None:
        """A frame was offered to the pages under this name of its view; `offset_ns` is the remote clock's, if known.

        One that is not `usable`, because none can decode it, is no page's fault: it has come, and none paints it.
        """
        arrivals = self._arrivals.setdefault(view, _Arrivals())
        arrivals.exposed.append((frame.seq, frame.capture_ns))
        if usable:
            arrivals.came_ns.append(now_ns)
        arrivals.age_ms = None if offset_ns is None else max(0.0, (now_ns + offset_ns - frame.capture_ns) / NS_PER_MS)

    def message(self, page: Shown, lease: int, now_ns: int) -> ViewsShown | None:
        """Build the report of the cameras that a page has painted; None too soon after the last, or without any.

        `lease` is the number of the operator's lease, 0 without one.
        """
        found = ((view, self._shown(view, newest, now_ns)) for view, newest in page.views.items())
        views = {view.removeprefix(CAMERA_VIEW): shown for view, shown in found if shown is not None}
        if not views or now_ns - self._sent_ns < LEAST_APART_NS:
            return None
        self._sent_ns = now_ns
        return ViewsShown(session=self._session, sent_ns=now_ns, lease=lease, h264=page.h264, views=views)

    def _shown(self, view: str, painted: Painted, now_ns: int) -> ViewShown | None:
        arrivals = self._arrivals.get(view, _Arrivals())
        came = arrivals.newest(now_ns)
        exposed = next((capture_ns for seq, capture_ns in reversed(arrivals.exposed) if seq == painted.seq), None)
        if came is None or exposed is None:
            return None
        return ViewShown(seq=painted.seq, capture_ns=exposed, age_ms=painted.age_ms, fps=painted.fps, came=came)
