"""The process that draws the previews: forked before the loop asks for real time, idle, and never waited for."""

import os
from collections.abc import Sequence

import cv2
import msgspec
import structlog

from common.clock import NS_PER_MS
from common.geometry import Array
from common.process.children import Children, Heartbeat
from common.process.service import StopFlag, be_idle
from local_site.preview.drawing import Drawn, PreviewConfig, decode_order, draw, encode_order
from local_site.preview.mailbox import Mailbox
from local_site.tracking.tracker import ArmEstimate, Views

MAX_BYTES = 128_000_000  # four views of 4K in colour; memory that is never written is never taken
WAIT_NS = 250 * NS_PER_MS


class PreviewProcess:
    """Takes an instant when it is free, and gives its pictures some milliseconds later.

    `projections` (3, 4) are the cameras' matrices. Create it before any session is opened; it ends with `close`.
    """

    def __init__(self, config: PreviewConfig, projections: Sequence[Array]) -> None:
        self._orders, self._drawn = Mailbox(MAX_BYTES), Mailbox(MAX_BYTES)
        self._children = Children("local")
        self._child = self._children.start("preview", _Drawing(config, projections, self._orders, self._drawn).run)
        self._told = False

    def take(self) -> list[Drawn]:
        """The pictures that have become ready since the last call."""
        parts = self._drawn.take()
        return [] if parts is None else msgspec.msgpack.decode(parts[0].tobytes(), type=list[Drawn])

    def draw(self, views: Views, estimate: ArmEstimate) -> None:
        """Have an instant drawn, unless the last is still being drawn; what makes it impossible is told once."""
        if self._orders.is_free:
            pictures = [view.current.image for view in views.views]
            if not self._orders.put([encode_order(views, estimate), *pictures]):
                self._tell(
                    "the operator's pictures are too large for a preview", cure="give the cameras a smaller size"
                )
        elif not self._child.process.is_alive():
            self._tell("the process that draws the previews died", cure="restart the local site")

    def _tell(self, event: str, cure: str) -> None:
        if not self._told:
            self._told = True
            structlog.get_logger().error(event, cure=cure)

    def close(self) -> None:
        """End the process, which has its turn like others for that."""
        process = self._child.process
        if process.pid is not None and process.is_alive():
            os.sched_setscheduler(process.pid, os.SCHED_OTHER, os.sched_param(0))
        self._children.end()


class _Drawing:
    """The body of the process."""

    def __init__(self, config: PreviewConfig, projections: Sequence[Array], orders: Mailbox, drawn: Mailbox) -> None:
        self._config = config
        self._projections = projections
        self._orders = orders
        self._drawn = drawn

    def run(self, should_stop: StopFlag, heartbeat: Heartbeat) -> None:
        """Draw what comes until asked to stop."""
        be_idle()
        # Zero and not one: one would wait for OpenCV's worker threads, which a forked process has not.
        cv2.setNumThreads(0)
        while not should_stop():
            heartbeat.beat()
            self._orders.wait(WAIT_NS)
            parts = self._orders.take()
            if parts is not None:
                drawn = draw(decode_order(parts[0].tobytes()), parts[1:], self._projections, self._config)
                self._drawn.put([msgspec.msgpack.encode(drawn)])
