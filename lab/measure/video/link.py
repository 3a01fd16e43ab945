"""A simulated link of limited bandwidth, first in, first out, and a viewer at its end that reports what it shows."""

import math
from collections import deque
from collections.abc import Callable
from dataclasses import dataclass, field

from common.clock import NS_PER_MS, NS_PER_S
from common.messages.video import CameraStatus, VideoFrame, ViewCame, ViewShown, ViewsShown
from lab.stage.network.in_transit import InTransit
from remote_site.video.config import VideoConfig
from remote_site.video.streaming.adaptation import Adaptation
from remote_site.video.streaming.departures import Departures
from remote_site.video.streaming.encoding import Encoded
from remote_site.video.streaming.setting import StreamSetting

TICK_NS = NS_PER_MS
REPORT_NS = 100 * NS_PER_MS
DELAY_MS = 10.0
MAKE_AND_PAINT_MS = 25.0
RATE_OF = 128  # pictures, more than there are in a second

Picture = Callable[[str, int, StreamSetting], Encoded]


def live_frame(camera: str, seq: int, capture_ns: int, encoded: Encoded) -> VideoFrame:
    """A live camera's frame of a picture whose capture time is known."""
    return VideoFrame(
        camera=camera,
        seq=seq,
        capture_ns=capture_ns,
        capture_estimated=False,
        status=CameraStatus.LIVE,
        reason="",
        width=encoded.width,
        height=encoded.height,
        codec=encoded.codec,
        key=encoded.key,
        data=encoded.data,
    )


@dataclass(frozen=True, slots=True)
class Arrival:
    """A picture as it came: when (ns), of which camera, how old (ms), how large."""

    t_ns: int
    camera: str
    age_ms: float
    size: int


@dataclass
class SimulatedLink:
    """A queue of `holds_bytes`, beyond which a picture is lost, and a delay each way; all may change while it runs."""

    mbit_s: float
    holds_bytes: float = math.inf
    delay_ms: float = DELAY_MS
    queue: deque[VideoFrame] = field(default_factory=deque)
    travelling: InTransit[VideoFrame] = field(default_factory=InTransit)
    reports: InTransit[ViewsShown] = field(default_factory=InTransit)
    credit_bits: float = 0.0

    def put(self, frame: VideoFrame) -> None:
        """Queue a picture."""
        if self.queued_bytes + len(frame.data) <= self.holds_bytes:
            self.queue.append(frame)

    @property
    def queued_bytes(self) -> int:
        """The bytes that wait."""
        return sum(len(waiting.data) for waiting in self.queue)

    def put_back(self, report: ViewsShown, now_ns: int) -> None:
        """Send a report the other way, where the link has room."""
        self.reports.send(report, self._arrives_ns(now_ns))

    def came_back(self, now_ns: int) -> list[ViewsShown]:
        """The reports that have arrived by now."""
        return self.reports.arrived(now_ns)

    def tick(self, now_ns: int) -> list[VideoFrame]:
        """The pictures that arrive by now, one tick after the last call."""
        self.credit_bits += self.mbit_s * 1e6 * TICK_NS / NS_PER_S
        while self.queue and self.credit_bits >= 8 * len(self.queue[0].data):
            frame = self.queue.popleft()
            self.credit_bits -= 8 * len(frame.data)
            self.travelling.send(frame, self._arrives_ns(now_ns))
        if not self.queue:
            self.credit_bits = 0.0
        return self.travelling.arrived(now_ns)

    def _arrives_ns(self, now_ns: int) -> int:
        return now_ns + round(self.delay_ms * NS_PER_MS)


@dataclass
class _LinkedView:
    """A viewer's knowledge of one camera: when its pictures came, the one that waits, and those that were painted."""

    came: VideoFrame
    shown: VideoFrame
    waiting: VideoFrame | None = None
    late_ms: float = 0.0
    came_ns: deque[int] = field(default_factory=lambda: deque(maxlen=RATE_OF))
    painted: list[Arrival] = field(default_factory=list)


class Viewer:
    """Paints the newest picture of every camera, each `paints_fps` times a second at most; `painted` is what it did.

    With `reports` it is a console, which says what it shows, and with `h264` it decodes that. Where its host is busy,
    everything comes `late_ms` later, and its console says that it has waited for `waited_ms`.
    """

    def __init__(self, *, reports: bool, h264: bool) -> None:
        self.reports, self._h264 = reports, h264
        self.paints_fps = math.inf
        self.late_ms = self.waited_ms = 0.0
        self.painted: list[Arrival] = []
        self._views: dict[str, _LinkedView] = {}

    def take(self, frame: VideoFrame, now_ns: int) -> None:
        """Take a picture that has arrived; it replaces one that still waits."""
        view = self._views.setdefault(frame.camera, _LinkedView(frame, frame))
        view.came = view.waiting = frame
        view.came_ns.append(now_ns)
        view.late_ms = self.late_ms

    def paint(self, now_ns: int) -> None:
        """Paint the pictures that wait, where the paint rate allows."""
        for camera, view in self._views.items():
            busy = view.painted and now_ns - view.painted[-1].t_ns < NS_PER_S / self.paints_fps
            if view.waiting is not None and not busy:
                frame, view.waiting = view.waiting, None
                age_ms = (now_ns - frame.capture_ns) / NS_PER_MS + view.late_ms + MAKE_AND_PAINT_MS
                view.painted.append(Arrival(now_ns, camera, age_ms, len(frame.data)))
                self.painted.append(view.painted[-1])
                view.shown = frame

    def report(self, now_ns: int) -> ViewsShown | None:
        """Report what its console shows, ten times a second; None otherwise, or where it is none."""
        if not self.reports or now_ns % REPORT_NS != 0 or not self._views:
            return None
        return ViewsShown(
            session=1, lease=0, h264=self._h264, sent_ns=now_ns, views=self._shown(now_ns), waited_ms=self.waited_ms
        )

    def _shown(self, now_ns: int) -> dict[str, ViewShown]:
        since_ns, shown = now_ns - NS_PER_S, {}
        for camera, view in self._views.items():
            came_fps = float(sum(t_ns > since_ns for t_ns in view.came_ns))
            came_age_ms = (view.came_ns[-1] - view.came.capture_ns) / NS_PER_MS + view.late_ms
            shown[camera] = ViewShown(
                seq=view.shown.seq,
                capture_ns=view.shown.capture_ns,
                age_ms=view.painted[-1].age_ms,
                fps=float(sum(one.t_ns > since_ns for one in view.painted[-RATE_OF:])),
                came=ViewCame(seq=view.came.seq, age_ms=came_age_ms, fps=came_fps),
            )
        return shown


@dataclass
class _Exposed:
    """How many pictures a camera has sent, and when the last one."""

    pictures: int = 0
    sent_ns: int = -NS_PER_S


class StreamRun:
    """Cameras, adaptation, link and viewer in simulated time; `picture` encodes (camera, number, setting).

    `reports` is whether the viewer is a console, which reports, and `h264` whether it decodes that. Pictures that wait
    in the link go to it late, as they would through the buffers of a connection; with `sees_queue` they wait where the
    sender can see it. Where the cell's host is busy, a picture leaves `leaves_ms` after it was sent, and the sender
    knows that it has waited for `waited_ms`.
    """

    def __init__(
        self,
        config: VideoConfig,
        picture: Picture,
        mbit_s: float,
        *,
        reports: bool = True,
        h264: bool = False,
        sees_queue: bool = False,
    ) -> None:
        self.adaptation = Adaptation(config, h264=h264)
        self._sees_queue = sees_queue
        self._departures = Departures()
        self.link = SimulatedLink(mbit_s)
        self.viewer = Viewer(reports=reports, h264=h264)
        self.now_ns = 0
        self.leaves_ms = self.waited_ms = 0.0
        self._leaving = InTransit[VideoFrame]()
        self._config = config
        self._picture = picture
        self._cameras = {camera.name: _Exposed() for camera in config.cameras}

    def run(self, seconds: float) -> list[Arrival]:
        """Let time pass; the pictures painted meanwhile."""
        before, end_ns = len(self.viewer.painted), self.now_ns + round(seconds * NS_PER_S)
        while self.now_ns < end_ns:
            self.now_ns += TICK_NS
            self.adaptation.wait(self.waited_ms)
            self._expose()
            for frame in self._leaving.arrived(self.now_ns):
                self.link.put(frame)
            for frame in self.link.tick(self.now_ns):
                self.viewer.take(frame, self.now_ns)
            self.viewer.paint(self.now_ns)
            if (shown := self.viewer.report(self.now_ns)) is not None:
                self.link.put_back(shown, self.now_ns)
            for report in self.link.came_back(self.now_ns):
                self.adaptation.update(report, self.now_ns)
        return self.viewer.painted[before:]

    def _expose(self) -> None:
        period_ns = round(NS_PER_S / self._config.fps)
        for k, (camera, exposed) in enumerate(self._cameras.items()):
            setting = self.adaptation.setting(camera, self.now_ns)
            phase_ns = (self.now_ns + k * period_ns // len(self._cameras)) % period_ns
            waited_ns = self.now_ns - exposed.sent_ns
            due = phase_ns < TICK_NS and waited_ns > NS_PER_S / setting.fps - period_ns / 2
            if due and self._sees_queue and self._departures.waits(camera, self.link.queued_bytes, self.now_ns):
                self.adaptation.hold_back(camera)
            elif due:
                exposed.sent_ns = self.now_ns
                seq, exposed.pictures = exposed.pictures, exposed.pictures + 1
                frame = live_frame(camera, seq, self.now_ns, self._picture(camera, seq, setting))
                self.adaptation.sent(frame, self.now_ns)
                self._leaving.send(frame, self.now_ns + round(self.leaves_ms * NS_PER_MS))
                self._departures.put(camera, len(frame.data), self.now_ns)
