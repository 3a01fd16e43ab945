"""The operator's own views for the console: drawn by an idle process, sent at their own pace while a page is open."""

import os
from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from functools import partial
from typing import Protocol

import cv2
import msgspec
import structlog

from common.clock import NS_PER_MS, NS_PER_S
from common.geometry import Array
from common.messages.video import CameraStatus, VideoFrame
from common.process.children import Children, Heartbeat
from common.process.service import StopFlag, be_idle
from local_site.preview.drawing import Drawn, PictureInfo, PreviewConfig, decode_order, draw, encode_order
from local_site.preview.mailbox import Mailbox
from local_site.tracking.tracker import ArmEstimate, Views

MAX_BYTES = 128_000_000  # four views of 4K in colour; memory that is never written costs nothing
WAIT_NS = 250 * NS_PER_MS
MAX_REASON = 400
NOTHING = PictureInfo(shape=(), capture_ns=0, capture_estimated=False)


class PreviewProcess:
    """Draws in a process of its own: takes an instant when it is free, gives its pictures some ms later, never waits.

    `projections` (3, 4) are the cameras' matrices. Create it before any session is opened and before the loop asks for
    real time; it ends with `close`.
    """

    def __init__(self, config: PreviewConfig, projections: Sequence[Array]) -> None:
        self._orders, self._drawn = Mailbox(MAX_BYTES), Mailbox(MAX_BYTES)
        self._children = Children("local")
        main = partial(_draw_orders, config, projections, self._orders, self._drawn)
        self._child = self._children.start("preview", main)
        self._failed = False

    def take(self) -> list[Drawn]:
        """The pictures that have become ready since the last call."""
        parts = self._drawn.take()
        return [] if parts is None else msgspec.msgpack.decode(parts[0].tobytes(), type=list[Drawn])

    def draw(self, views: Views, estimate: ArmEstimate) -> None:
        """Have an instant drawn, unless the last is still being drawn; what makes it impossible is logged once."""
        if self._orders.is_free:
            pictures = [view.current.image for view in views.views]
            if not self._orders.put([encode_order(views, estimate), *pictures]):
                self._fail("the operator's pictures are too large for a preview", "give the cameras a smaller size")
        elif not self._child.process.is_alive():
            self._fail("the process that draws the previews died", "restart the local site")

    def _fail(self, event: str, cure: str) -> None:
        if not self._failed:
            self._failed = True
            structlog.get_logger().error(event, cure=cure)

    def close(self) -> None:
        """End the process, scheduled like others so that it gets the processor to do so."""
        process = self._child.process
        if process.pid is not None and process.is_alive():
            os.sched_setscheduler(process.pid, os.SCHED_OTHER, os.sched_param(0))
        self._children.end()


def _draw_orders(
    config: PreviewConfig,
    projections: Sequence[Array],
    orders: Mailbox,
    drawn: Mailbox,
    should_stop: StopFlag,
    heartbeat: Heartbeat,
) -> None:
    """The body of the process: draw what comes until asked to stop."""
    be_idle()
    # Zero and not one: one would wait for OpenCV's worker threads, which a forked process does not have.
    cv2.setNumThreads(0)
    while not should_stop():
        heartbeat.beat()
        orders.wait(WAIT_NS)
        parts = orders.take()
        if parts is not None:
            pictures = draw(decode_order(parts[0].tobytes()), parts[1:], projections, config)
            drawn.put([msgspec.msgpack.encode(pictures)])


class PreviewSink(Protocol):
    """Where one view's pictures go, and whether there is a subscriber."""

    @property
    def has_listener(self) -> bool: ...

    def put(self, message: VideoFrame) -> None: ...


@dataclass(slots=True)
class _SentView:
    """One view's frames as they are numbered and sent."""

    name: str
    wire: PreviewSink
    seq: int = 0
    taken: PictureInfo = NOTHING

    def send(self, status: CameraStatus, reason: str = "", width: int = 0, height: int = 0, jpeg: bytes = b"") -> None:
        frame = VideoFrame(
            camera=self.name,
            seq=self.seq,
            capture_ns=self.taken.capture_ns,
            capture_estimated=self.taken.capture_estimated,
            status=status,
            reason=reason,
            width=width,
            height=height,
            jpeg=jpeg,
        )
        self.wire.put(frame)
        self.seq += 1


class Preview:
    """What the loop calls at the end of each round, after the sample is sent.

    `wires` are by the name of the view, in the order of the rig's cameras.
    """

    def __init__(self, wires: Mapping[str, PreviewSink], drawing: PreviewProcess, fps: float) -> None:
        self._views = [_SentView(name, wire) for name, wire in wires.items()]
        self._drawing = drawing
        self._period_ns = round(NS_PER_S / fps)
        self._due_ns = 0

    def show(self, views: Views, estimate: ArmEstimate) -> None:
        """Send what has been drawn, and have this instant drawn if it is due and there is a subscriber."""
        for view, drawn in zip(self._views, self._drawing.take(), strict=False):
            view.taken = drawn.taken
            view.send(CameraStatus.LIVE, "", drawn.width, drawn.height, drawn.jpeg)
        if self._is_due(views.t_ns):
            self._drawing.draw(views, estimate)

    def show_reason(self, reason: str, now_ns: int) -> None:
        """Without views: send the reason instead of pictures."""
        self._drawing.take()
        if self._is_due(now_ns):
            for view in self._views:
                view.send(CameraStatus.FROZEN, reason[:MAX_REASON])

    def _is_due(self, t_ns: int) -> bool:
        """At most once a period, on average, of an instant that may come late."""
        if t_ns < self._due_ns:
            return False
        self._due_ns = max(self._due_ns, t_ns - self._period_ns) + self._period_ns
        return any(view.wire.has_listener for view in self._views)
