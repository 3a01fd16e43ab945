"""The operator's own views for the console: at their own pace, only while somebody looks, after the sample is sent."""

from collections.abc import Mapping
from dataclasses import dataclass
from typing import Protocol

from common.clock import NS_PER_S
from common.messages.video import CameraStatus, VideoFrame
from local_site.preview.drawing import Drawn, PictureInfo
from local_site.tracking.tracker import ArmEstimate, Views

MAX_REASON = 400
NOTHING = PictureInfo(shape=(), capture_ns=0, capture_estimated=False)


class PreviewSink(Protocol):
    """Where one view's pictures go, and whether anybody listens."""

    @property
    def has_listener(self) -> bool: ...

    def put(self, message: VideoFrame) -> None: ...


class Drawer(Protocol):
    """Who draws: takes an instant if it is free, gives pictures when they are ready; neither waits."""

    def draw(self, views: Views, estimate: ArmEstimate) -> None: ...

    def take(self) -> list[Drawn]: ...


@dataclass(slots=True)
class _View:
    name: str
    wire: PreviewSink
    seq: int = 0
    taken: PictureInfo = NOTHING


class Preview:
    """What the loop calls at the end of each round; drawing is another process's work.

    `wires` are by the name of the view, in the order of the rig's cameras.
    """

    def __init__(self, wires: Mapping[str, PreviewSink], drawer: Drawer, fps: float) -> None:
        self._views = [_View(name, wire) for name, wire in wires.items()]
        self._drawer = drawer
        self._period_ns = round(NS_PER_S / fps)
        self._due_ns = 0

    def show(self, views: Views, estimate: ArmEstimate) -> None:
        """Send what has been drawn, and have this instant drawn if it is time and somebody listens."""
        for view, drawn in zip(self._views, self._drawer.take(), strict=False):
            _send_picture(view, drawn)
        if self._is_due(views.t_ns):
            self._drawer.draw(views, estimate)

    def say(self, reason: str, now_ns: int) -> None:
        """Without views: say why, in the place of pictures."""
        self._drawer.take()
        if self._is_due(now_ns):
            for view in self._views:
                _send(view, CameraStatus.FROZEN, reason[:MAX_REASON], 0, 0, b"")

    def _is_due(self, t_ns: int) -> bool:
        """At most once a period, on average, of an instant that may come late."""
        if t_ns < self._due_ns:
            return False
        self._due_ns = max(self._due_ns, t_ns - self._period_ns) + self._period_ns
        return any(view.wire.has_listener for view in self._views)


def _send_picture(view: _View, drawn: Drawn) -> None:
    view.taken = drawn.taken
    _send(view, CameraStatus.LIVE, "", drawn.width, drawn.height, drawn.jpeg)


def _send(view: _View, status: CameraStatus, reason: str, width: int, height: int, jpeg: bytes) -> None:
    view.wire.put(
        VideoFrame(
            camera=view.name,
            seq=view.seq,
            capture_ns=view.taken.capture_ns,
            capture_estimated=view.taken.capture_estimated,
            status=status,
            reason=reason,
            width=width,
            height=height,
            jpeg=jpeg,
        )
    )
    view.seq += 1
