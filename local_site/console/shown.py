"""What the operating page has painted, told to the remote site in the remote site's own numbers; pure."""

from collections import deque

from common.clock import NS_PER_MS
from common.messages import VideoFrame, ViewShown, ViewsShown
from local_site.console.page_messages import Painted

REMEMBERED = 64
CAMERA_VIEW = "camera/"
LEAST_APART_NS = 50 * NS_PER_MS


class ShownViews:
    """Remembers when the last frames of each camera were exposed, by the remote clock."""

    def __init__(self, session: int) -> None:
        self._session = session
        self._exposed: dict[str, deque[tuple[int, int]]] = {}
        self._sent_ns = 0

    def remember(self, view: str, frame: VideoFrame) -> None:
        """A frame was offered to the pages under this name of its view."""
        self._exposed.setdefault(view, deque(maxlen=REMEMBERED)).append((frame.seq, frame.capture_ns))

    def message(self, painted: dict[str, Painted], lease: int, now_ns: int) -> ViewsShown | None:
        """What to publish of the cameras that a page has painted; None too soon after the last, or without any.

        `lease` is the number of the operator's lease, 0 without one.
        """
        found = ((view, self._shown(view, newest)) for view, newest in painted.items())
        views = {view.removeprefix(CAMERA_VIEW): shown for view, shown in found if shown is not None}
        if not views or now_ns - self._sent_ns < LEAST_APART_NS:
            return None
        self._sent_ns = now_ns
        return ViewsShown(session=self._session, lease=lease, sent_ns=now_ns, views=views)

    def _shown(self, view: str, painted: Painted) -> ViewShown | None:
        for seq, capture_ns in reversed(self._exposed.get(view, ())):
            if seq == painted.seq:
                return ViewShown(seq=seq, capture_ns=capture_ns, age_ms=painted.age_ms, fps=painted.fps)
        return None
