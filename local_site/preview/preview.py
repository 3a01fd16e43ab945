"""The operator's own views for the console, while a page is open: drawn by an idle process; or why there are none."""

import os
from collections.abc import Mapping, Sequence
from contextlib import suppress
from dataclasses import dataclass
from functools import partial
from typing import Annotated, Protocol

import cv2
import msgspec
import numpy as np
import simplejpeg
import structlog
from msgspec import Meta

from common.cameras.camera import Image
from common.clock import NS_PER_MS, NS_PER_S
from common.geometry import Array
from common.messages.video import CameraStatus, Codec, VideoFrame
from common.process.children import Children, Heartbeat
from common.process.service import StopFlag, be_idle
from local_site.preview.cropping import Cropping
from local_site.preview.mailbox import Mailbox
from local_site.tracking.annotate import annotate
from local_site.tracking.tracker import ArmEstimate, Views

MAX_BYTES = 128_000_000  # four views of 4K in colour; memory that is never written costs nothing
WAIT_NS = 250 * NS_PER_MS
MAX_REASON = 400
REASON_EVERY_NS = 250 * NS_PER_MS  # where no camera is used


class PreviewConfig(msgspec.Struct, frozen=True, kw_only=True, forbid_unknown_fields=True):
    """Pictures of the operator, cropped to the arm, with what was found; made only while a console shows them."""

    fps: Annotated[float, Meta(gt=0, le=60, description="pictures per second of each view, at most")] = 12.0
    width: Annotated[
        int, Meta(ge=160, le=3840, description="pixels of a whole view; a narrower one stays as it is")
    ] = 640
    quality: Annotated[int, Meta(ge=10, le=100, description="JPEG quality")] = 70


class PictureInfo(msgspec.Struct, frozen=True):
    """The metadata of a picture."""

    shape: tuple[int, ...]
    capture_ns: int
    capture_estimated: bool


NOTHING = PictureInfo(shape=(), capture_ns=0, capture_estimated=False)


class DrawingOrder(msgspec.Struct, frozen=True):
    """Everything to be drawn at one instant, without the pictures."""

    taken: tuple[PictureInfo, ...]
    estimate: ArmEstimate


class Drawn(msgspec.Struct, frozen=True):
    """One view, ready to be sent."""

    taken: PictureInfo
    width: int
    height: int
    jpeg: bytes


def encode_order(views: Views, estimate: ArmEstimate) -> bytes:
    """Encode what to draw for an instant."""
    frames = [view.current for view in views.views]
    taken = tuple(PictureInfo(f.image.shape, f.capture_ns, f.capture_estimated) for f in frames)
    return msgspec.msgpack.encode(DrawingOrder(taken, estimate), enc_hook=_from_array)


def decode_order(data: bytes) -> DrawingOrder:
    """The order that was encoded."""
    return msgspec.msgpack.decode(data, type=DrawingOrder, dec_hook=_to_array)


def draw(
    order: DrawingOrder, pictures: Sequence[Image], projections: Sequence[Array], quality: int, cropping: Cropping
) -> list[Drawn]:
    """All views of an instant with what was found in them; the pictures are flat, as they came through the memory."""
    drawn = []
    for k, (pixels, taken) in enumerate(zip(pictures, order.taken, strict=True)):
        height, width = taken.shape[:2]
        part = cropping.part(order.estimate, k, width, height)
        picture = part.picture(pixels.reshape(taken.shape))
        annotated = annotate(picture, part.estimate(order.estimate, k), k, part.projection(projections[k]))
        drawn.append(_drawn(annotated, taken, quality))
    return drawn


def _drawn(picture: Image, taken: PictureInfo, quality: int) -> Drawn:
    height, width = picture.shape[:2]
    return Drawn(taken, width, height, bytes(simplejpeg.encode_jpeg(picture, quality, "BGR", "420")))


def _from_array(value: object) -> object:
    """An array as dtype, shape and bytes; a NumPy scalar as a number."""
    if isinstance(value, np.ndarray):
        return value.dtype.str, value.shape, value.tobytes()
    if isinstance(value, np.generic):
        return value.item()
    raise NotImplementedError(f"a preview cannot carry {type(value)}")


def _to_array(_kind: type, parts: tuple[str, Sequence[int], bytes]) -> object:
    dtype, shape, data = parts
    return np.frombuffer(data, dtype).reshape(shape)


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
        """End the process, scheduled like others, where that is permitted, so that it gets the processor to do so."""
        process = self._child.process
        if process.pid is not None and process.is_alive():
            # Without CAP_SYS_NICE or RLIMIT_NICE nobody leaves SCHED_IDLE; it then ends when a processor is idle.
            with suppress(PermissionError):
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
    cropping = Cropping(len(projections), config.width)
    while not should_stop():
        heartbeat.beat()
        orders.wait(WAIT_NS)
        parts = orders.take()
        if parts is not None:
            pictures = draw(decode_order(parts[0].tobytes()), parts[1:], projections, config.quality, cropping)
            drawn.put([msgspec.msgpack.encode(pictures)])


class PreviewSink(Protocol):
    """Sink for the pictures of one view, which knows whether there is a subscriber."""

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
            codec=Codec.JPEG,
            key=bool(jpeg),
            data=jpeg,
        )
        self.wire.put(frame)
        self.seq += 1


class Preview:
    """The operator's views for the console; the loop calls it at the end of each round, after the sample is sent.

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


class NoCamera:
    """Says of each view, by its name in `wires`, why there is none, while somebody looks."""

    def __init__(self, wires: Mapping[str, PreviewSink], reason: str) -> None:
        self._wires, self._reason = wires, reason[:MAX_REASON]
        self._seq = 0
        self._due_ns = 0

    def tell(self, now_ns: int) -> None:
        """Say it, if it is time."""
        if now_ns < self._due_ns:
            return
        self._due_ns = now_ns + REASON_EVERY_NS
        self._seq += 1
        for view, wire in self._wires.items():
            if wire.has_listener:
                wire.put(self._frame(view))

    def _frame(self, view: str) -> VideoFrame:
        return VideoFrame(
            camera=view,
            seq=self._seq,
            capture_ns=0,
            capture_estimated=False,
            status=CameraStatus.MISSING,
            reason=self._reason,
            width=0,
            height=0,
            codec=Codec.JPEG,
            key=False,
            data=b"",
        )
