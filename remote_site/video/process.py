"""The video process: every camera at its rate, staggered, each picture or its absence published; and what it sent."""

import mmap
import time
from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass, field
from functools import partial
from itertools import islice
from typing import NamedTuple

import cv2
import numpy as np
import structlog

from common.cameras.camera import Frame
from common.cameras.lost_pictures import LostPictures
from common.clock import NS_PER_MS, NS_PER_S
from common.errors import CameraError, MessageError
from common.link.channels import KEY_FRAMES
from common.messages.robot import VideoLink
from common.messages.video import CameraStatus, KeyFrameRequest, VideoFrame, ViewsShown
from common.process.log import RefusalLog
from common.process.processor_wait import ProcessorWait, QueuedTime
from common.process.service import be_nice
from remote_site.video.calibration import FittingPictures
from remote_site.video.config import VideoConfig
from remote_site.video.full_pictures import FullPictures
from remote_site.video.marker_look import MarkerLook
from remote_site.video.sources import FrameSource, SimulatedViews, open_sources
from remote_site.video.streaming.adaptation import Adaptation
from remote_site.video.streaming.codec_choice import CodecPreference
from remote_site.video.streaming.departures import Departures
from remote_site.video.streaming.encoding import can_encode
from remote_site.video.streaming.h264 import H264_CURE
from remote_site.video.streaming.setting import StreamSetting
from remote_site.video.streaming.stream import CameraStream

LIVE_POLL_NS = 5 * NS_PER_MS
TROUBLE_EVERY_NS = 500 * NS_PER_MS
WATCHED_NS = NS_PER_S
LISTENERS_EVERY_NS = 50 * NS_PER_MS
IDLE_S = 0.05
STATUSES = tuple(CameraStatus)
BYTES, CAPTURE_NS, OLDEST_NS = (len(STATUSES) + k for k in range(3))
FIELDS = len(STATUSES) + 3
COUNT_BYTES = 8


@dataclass(frozen=True, slots=True)
class CameraTally:
    """One camera: messages by status, bytes of pictures, exposure of the newest live picture (ns, 0 without one).

    `oldest_ns` is the longest time from a live picture's exposure until it was sent.
    """

    frames: dict[CameraStatus, int]
    picture_bytes: int
    capture_ns: int
    oldest_ns: int


class VideoTally:
    """Counts of every camera, and of what it has `lost`; one process writes, others read. Create it before the fork."""

    def __init__(self, cameras: Sequence[str]) -> None:
        self.cameras, self.lost = tuple(cameras), LostPictures(cameras)
        rows = max(1, len(self.cameras))  # nothing can be mapped of no size
        self._counts = np.frombuffer(mmap.mmap(-1, rows * FIELDS * COUNT_BYTES), dtype=np.int64).reshape(rows, FIELDS)

    def note(self, frame: VideoFrame, now_ns: int) -> None:
        """Count a message that was sent now."""
        row = self._counts[self.cameras.index(frame.camera)]
        row[STATUSES.index(frame.status)] += 1
        row[BYTES] += len(frame.data)
        if frame.status is CameraStatus.LIVE:
            row[CAPTURE_NS] = frame.capture_ns
            row[OLDEST_NS] = max(row[OLDEST_NS], now_ns - frame.capture_ns)

    def read(self, camera: str) -> CameraTally:
        """The counts of one camera so far."""
        counts = self._counts[self.cameras.index(camera)].tolist()
        return CameraTally(dict(zip(STATUSES, counts, strict=False)), *counts[BYTES:])

    def sentences(self) -> dict[str, str]:
        """Say how many messages of all cameras were sent by status, how old the oldest live one was, what was lost."""
        every = [self.read(camera) for camera in self.cameras]
        sent = {status: sum(tally.frames[status] for tally in every) for status in STATUSES}
        others = [f"{count} {status}" for status, count in sent.items() if count and status is not CameraStatus.LIVE]
        others += [f"{count} lost" for count in [sum(self.lost.read().values())] if count]
        oldest_ms = max((tally.oldest_ns for tally in every), default=0) / NS_PER_MS
        live = f"{sent[CameraStatus.LIVE]} live, the oldest {oldest_ms:.0f} ms from exposure to sending"
        return {"pictures": ", ".join([live, *others])} if any(sent.values()) else {}


class LeaseInForce(NamedTuple):
    """The lease in force: its number, and its holder's name."""

    number: int
    holder: str


Shown = Callable[[], tuple[str, ViewsShown] | None]


@dataclass(frozen=True, slots=True)
class VideoWire:
    """The outlet for pictures, what operators' consoles report of them, and the lease in force (None without one).

    Each source of `shown` returns a report once, with the operator whose key it came on; `key_frames` returns each
    viewer's request once. `show_trouble` is told twice a second what keeps pictures from coming all and in time, None
    for nothing. `has_listener` is whether anybody receives pictures, and `unsent_bytes` how much of what was published
    waits in this host on its way to who operates.
    """

    publish: Callable[[VideoFrame], None]
    shown: Sequence[Shown] = ()
    lease: Callable[[], LeaseInForce | None] = lambda: None
    key_frames: Callable[[], KeyFrameRequest | None] = lambda: None
    show_trouble: Callable[[VideoLink | None], None] = lambda _link: None
    has_listener: Callable[[], bool] = lambda: True
    unsent_bytes: Callable[[], int] = lambda: 0


@dataclass(slots=True)
class _CameraSlot:
    source: FrameSource
    stream: CameraStream
    period_ns: int
    due_ns: int
    frame: Frame | None = None

    def serve(
        self, setting: StreamSetting, now_ns: int, waits: Callable[[], bool], *, every_picture: bool
    ) -> VideoFrame | None:
        """The message due now, if any, and no picture while the last one still `waits`; missed deadlines are skipped.

        A rendered view is rendered only to be sent, unless `every_picture` is wanted.
        """
        rendered = self.source.noise_free and not every_picture
        period_ns = max(self.period_ns, round(NS_PER_S / setting.fps)) if rendered else self.period_ns
        self.due_ns += period_ns * max(1, (now_ns - self.due_ns) // period_ns + 1)
        try:
            self.frame = self.source.newest()
            return self.stream.take(self.frame, setting, now_ns, waits)
        except CameraError as error:
            self.frame = None
            return self.stream.missing(str(error), now_ns)


@dataclass(slots=True)
class _Console:
    """The reports of the operator's console, and the settings that follow; refused ones are counted, and logged once.

    While somebody holds the lease only the holder's console counts: a viewer on a narrow link must not
    degrade the operator's pictures. Without a lease every console counts.
    """

    wire: VideoWire
    adaptation: Adaptation
    wait: ProcessorWait = field(default_factory=ProcessorWait)
    refusals: RefusalLog = field(default_factory=lambda: RefusalLog("a console's report of its views is refused"))
    reported_ns: int = 0
    heard_ns: int = 0
    looked_ns: int = 0

    def is_watched(self, now_ns: int) -> bool:
        """Return whether the console that counts has reported lately."""
        return now_ns - self.heard_ns <= WATCHED_NS

    def listen(self, now_ns: int) -> None:
        if now_ns - self.looked_ns >= LISTENERS_EVERY_NS:
            self.looked_ns = now_ns
            self.adaptation.listened(now_ns, has_listener=self.wire.has_listener())
            self.adaptation.wait(self.wait.longest_ms(now_ns))
        for source in self.wire.shown:
            self._take(source, now_ns)
        if now_ns - self.reported_ns >= TROUBLE_EVERY_NS:
            self.reported_ns = now_ns
            self.wire.show_trouble(self.adaptation.trouble(now_ns))

    def _take(self, source: Shown, now_ns: int) -> None:
        try:
            named = source()
        except MessageError as error:
            self.refusals.note(error)
            return
        if named is None:
            return
        operator, shown = named
        if self.wire.lease() in (None, LeaseInForce(shown.lease, operator)):
            self._follow(shown, now_ns)
            self.heard_ns = now_ns

    def _follow(self, shown: ViewsShown, now_ns: int) -> None:
        """Adapt to a report; numbers of another host that no estimate can be made of cost that estimate alone."""
        try:
            self.adaptation.update(shown, now_ns)
        except (ArithmeticError, LookupError, ValueError) as error:
            self.adaptation.forget()
            self.refusals.note(MessageError("impossible", f"nothing follows from its numbers ({error!r})"))


@dataclass(slots=True)
class _KeyFrameRequests:
    """Requests of any viewer, passed to the camera's stream; refused ones are counted, and logged once."""

    source: Callable[[], KeyFrameRequest | None]
    streams: Mapping[str, CameraStream]
    refusals: RefusalLog = field(default_factory=lambda: RefusalLog("a viewer's request for a key frame is refused"))

    def listen(self) -> None:
        try:
            for request in islice(iter(self.source, None), KEY_FRAMES.depth):
                if request.camera in self.streams:
                    self.streams[request.camera].want_key_frame(request.after_seq)
        except MessageError as error:
            self.refusals.note(error)


@dataclass(slots=True)
class _Sending:
    """Publishes pictures, unless the camera's last one still waits in this host."""

    wire: VideoWire
    adaptation: Adaptation
    departures: Departures = field(default_factory=Departures)

    def waits(self, camera: str, now_ns: int) -> bool:
        waits = self.departures.waits(camera, self.wire.unsent_bytes(), now_ns)
        if waits:
            self.adaptation.hold_back(camera)
        return waits

    def publish(self, frame: VideoFrame, now_ns: int) -> None:
        self.wire.publish(frame)
        self.departures.put(frame.camera, len(frame.data), now_ns)
        self.adaptation.sent(frame, now_ns)


def run_video(
    config: VideoConfig,
    views: SimulatedViews | None,
    wire: VideoWire,
    should_stop: Callable[[], bool],
    beat: Callable[[], None],
    markers: MarkerLook | None = None,
    full: FullPictures | None = None,
    lost: LostPictures | None = None,
) -> None:
    """Stream every camera until `should_stop`; `views` is None where no cell is simulated.

    While the operator's console shows pictures, `markers` are looked for in them. `full` gets all while it wants them.
    What cameras lose is counted in `lost`.
    Without cameras it only lives.
    Raises ConfigError for a simulated camera without a cell, CameraError when views cannot be rendered here.
    """
    cv2.setNumThreads(1)
    slots = _open_slots(config, open_sources(config, views, lost))
    be_nice(config.nice)  # not before: nothing moves until the site is ready, and on a busy machine that would be late
    if not slots:
        _wait_for_the_end(should_stop, beat)
        return
    requests = _KeyFrameRequests(wire.key_frames, {slot.source.name: slot.stream for slot in slots})
    console = _Console(wire, Adaptation(config, h264=_encodes_h264(config.codec)))
    sending, queued, fitting = _Sending(wire, console.adaptation), QueuedTime(), FittingPictures(config)
    try:
        while not should_stop():
            slot = min(slots, key=lambda s: s.due_ns)
            delay_ns = slot.due_ns - time.monotonic_ns()
            if delay_ns > 0:
                time.sleep(delay_ns / NS_PER_S)
            now_ns = time.monotonic_ns()
            console.wait.turn(queued.read_ns(), now_ns)
            console.listen(now_ns)
            requests.listen()
            name, records = slot.source.name, full is not None and full.wanted
            setting = console.adaptation.setting(name, now_ns)
            message = slot.serve(setting, now_ns, partial(sending.waits, name, now_ns), every_picture=records)
            if message is not None:
                sending.publish(message, time.monotonic_ns())  # what drawing takes is none of the link's delay
            if full is not None and records:
                full.see(name, slot.frame, message, setting)
            frame = slot.frame if slot.frame is not None and fitting.fits(name, slot.frame) else None
            if markers is not None and console.is_watched(now_ns):
                markers.see(name, frame, now_ns)
            beat()
    finally:
        for slot in slots:
            slot.source.close()


def _wait_for_the_end(should_stop: Callable[[], bool], beat: Callable[[], None]) -> None:
    """Beat until the end: where no camera is used there is nothing to send."""
    while not should_stop():
        beat()
        time.sleep(IDLE_S)


def _encodes_h264(codec: CodecPreference) -> bool:
    encodes = can_encode(codec)
    if codec is CodecPreference.AUTO and not encodes:
        structlog.get_logger().warning("a narrow link gets JPEG, not H.264: PyAV is not installed", cure=H264_CURE)
    return encodes


def _open_slots(config: VideoConfig, sources: Sequence[FrameSource]) -> list[_CameraSlot]:
    now_ns, frame_ns = time.monotonic_ns(), round(NS_PER_S / config.fps)
    slots = []
    for k, source in enumerate(sources):
        period_ns = frame_ns if source.noise_free else LIVE_POLL_NS
        stream = CameraStream(source.name, config, noise_free=source.noise_free)
        slots.append(_CameraSlot(source, stream, period_ns, now_ns + k * frame_ns // len(sources)))
    return slots
