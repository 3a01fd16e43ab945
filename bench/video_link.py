"""A link of so many bits a second, first in, first out, and behind it a viewer that reports what it shows."""

import itertools
import math
from collections import deque
from collections.abc import Callable
from dataclasses import dataclass, field

from common.clock import NS_PER_MS, NS_PER_S
from common.messages import CameraStatus, VideoFrame, ViewShown, ViewsShown
from remote_site.video.adaptation import Adaptation
from remote_site.video.config import VideoConfig
from remote_site.video.setting import Setting

TICK_NS = NS_PER_MS
REPORT_NS = 100 * NS_PER_MS
DELAY_NS = 10 * NS_PER_MS
MAKE_AND_PAINT_MS = 25.0

Picture = Callable[[str, int, Setting], bytes]


@dataclass(frozen=True, slots=True)
class Arrival:
    """A picture as it came: when (ns), of which camera, how old (ms), how large."""

    t_ns: int
    camera: str
    age_ms: float
    size: int


@dataclass
class Link:
    """A queue of so many bytes, beyond which a picture is lost; `mbit_s` may change while it runs."""

    mbit_s: float
    holds_bytes: float = math.inf
    queue: deque[tuple[int, VideoFrame]] = field(default_factory=deque)
    credit_bits: float = 0.0

    def put(self, frame: VideoFrame, ready_ns: int) -> None:
        """A picture comes to the queue, to be sent not before it is ready."""
        if sum(len(waiting.jpeg) for _, waiting in self.queue) + len(frame.jpeg) <= self.holds_bytes:
            self.queue.append((ready_ns, frame))

    def tick(self, now_ns: int) -> list[VideoFrame]:
        """What has come through by now, a tick after the last call."""
        through = []
        if self.queue and self.queue[0][0] <= now_ns:
            self.credit_bits += self.mbit_s * 1e6 * TICK_NS / NS_PER_S
        while self.queue and self.queue[0][0] <= now_ns and self.credit_bits >= 8 * len(self.queue[0][1].jpeg):
            frame = self.queue.popleft()[1]
            self.credit_bits -= 8 * len(frame.jpeg)
            through.append(frame)
        if not (self.queue and self.queue[0][0] <= now_ns):
            self.credit_bits = 0.0
        return through


class Run:
    """Cameras, adaptation, link and viewer in simulated time; `picture` makes the bytes of (camera, number, setting).

    `reports` is whether the viewer is a console, which reports. Pictures that wait in the link go to it late, as they
    would through the buffers of a connection.
    """

    def __init__(self, config: VideoConfig, picture: Picture, mbit_s: float, *, reports: bool = True) -> None:
        self.adaptation = Adaptation(config)
        self.link = Link(mbit_s)
        self.arrivals: list[Arrival] = []
        self.now_ns = 0
        self._config = config
        self._picture = picture
        self._reports = reports
        self._shown: dict[str, ViewShown] = {}
        self._numbers = {camera.name: itertools.count() for camera in config.cameras}
        self._sent_ns = dict.fromkeys(self._numbers, -NS_PER_S)

    def run(self, seconds: float) -> list[Arrival]:
        """Let time pass; what came meanwhile."""
        before, end_ns = len(self.arrivals), self.now_ns + round(seconds * NS_PER_S)
        while self.now_ns < end_ns:
            self.now_ns += TICK_NS
            self._expose()
            for frame in self.link.tick(self.now_ns):
                self._show(frame)
            if self._reports and self.now_ns % REPORT_NS == 0 and self._shown:
                told = ViewsShown(session=1, lease=0, sent_ns=self.now_ns, views=dict(self._shown))
                self.adaptation.hear(told, self.now_ns)
        return self.arrivals[before:]

    def _expose(self) -> None:
        period_ns = round(NS_PER_S / self._config.fps)
        for k, camera in enumerate(self._numbers):
            setting = self.adaptation.setting(camera, self.now_ns)
            phase_ns = (self.now_ns + k * period_ns // len(self._numbers)) % period_ns
            waited_ns = self.now_ns - self._sent_ns[camera]
            if phase_ns < TICK_NS and waited_ns > NS_PER_S / setting.fps - period_ns / 2:
                self._sent_ns[camera] = self.now_ns
                self._send(camera, setting)

    def _send(self, camera: str, setting: Setting) -> None:
        seq = next(self._numbers[camera])
        frame = VideoFrame(
            camera=camera,
            seq=seq,
            capture_ns=self.now_ns,
            capture_estimated=False,
            status=CameraStatus.LIVE,
            reason="",
            width=1,
            height=1,
            jpeg=self._picture(camera, seq, setting),
        )
        self.adaptation.sent(frame, self.now_ns)
        self.link.put(frame, self.now_ns + DELAY_NS)

    def _show(self, frame: VideoFrame) -> None:
        age_ms = (self.now_ns - frame.capture_ns) / NS_PER_MS + MAKE_AND_PAINT_MS
        self.arrivals.append(Arrival(self.now_ns, frame.camera, age_ms, len(frame.jpeg)))
        fps = self._config.fps
        self._shown[frame.camera] = ViewShown(seq=frame.seq, capture_ns=frame.capture_ns, age_ms=age_ms, fps=fps)
