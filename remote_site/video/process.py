"""The video process: every camera at its rate, staggered, each picture or its absence published."""

import time
from collections.abc import Callable, Sequence
from dataclasses import dataclass

import cv2
import structlog

from common.clock import NS_PER_MS, NS_PER_S
from common.errors import CameraError, MessageError
from common.messages.video import VideoFrame, ViewsShown
from common.process.service import be_nice
from remote_site.video.config import VideoConfig
from remote_site.video.sources import FrameSource, SimulatedViews, open_sources
from remote_site.video.streaming.adaptation import Adaptation
from remote_site.video.streaming.setting import StreamSetting
from remote_site.video.streaming.stream import CameraStream

LIVE_POLL_NS = 5 * NS_PER_MS


@dataclass(frozen=True, slots=True)
class VideoWire:
    """Where pictures go, what consoles report of them (each report once), and the lease in force (0 without one)."""

    publish: Callable[[VideoFrame], None]
    shown: Callable[[], ViewsShown | None] = lambda: None
    lease: Callable[[], int] = lambda: 0


@dataclass(slots=True)
class _Slot:
    source: FrameSource
    stream: CameraStream
    period_ns: int
    due_ns: int

    def serve(self, setting: StreamSetting, now_ns: int) -> VideoFrame | None:
        """The message due now, if any; missed deadlines are skipped. A rendered view is rendered only to be sent."""
        rendered = self.source.noise_free
        period_ns = max(self.period_ns, round(NS_PER_S / setting.fps)) if rendered else self.period_ns
        self.due_ns += period_ns * max(1, (now_ns - self.due_ns) // period_ns + 1)
        try:
            return self.stream.take(self.source.newest(), setting, now_ns)
        except CameraError as error:
            return self.stream.missing(str(error), now_ns)


@dataclass(slots=True)
class _Console:
    """The reports of the operator's console, and the settings that follow; invalid ones are logged once.

    While somebody holds the lease only the holder's console counts: a viewer on a narrow link must not
    degrade the operator's pictures. Without a lease every console counts.
    """

    wire: VideoWire
    adaptation: Adaptation
    refused: bool = False

    def listen(self, now_ns: int) -> None:
        try:
            shown = self.wire.shown()
        except MessageError as error:
            if not self.refused:
                structlog.get_logger().warning("a console's report of its views is refused", reason=str(error))
            self.refused = True
            return
        if shown is not None and self.wire.lease() in (0, shown.lease):
            self.adaptation.update(shown, now_ns)


def run_video(
    config: VideoConfig,
    views: SimulatedViews | None,
    wire: VideoWire,
    should_stop: Callable[[], bool],
    beat: Callable[[], None],
) -> None:
    """Stream every camera until `should_stop`; `views` is None where no cell is simulated.

    Raises ConfigError for a simulated camera without a cell, CameraError when views cannot be rendered here.
    """
    be_nice(config.nice)
    cv2.setNumThreads(1)
    slots = _open_slots(config, open_sources(config, views))
    console = _Console(wire, Adaptation(config))
    try:
        while not should_stop():
            _serve_next(slots, console, wire)
            beat()
    finally:
        for slot in slots:
            slot.source.close()


def _serve_next(slots: Sequence[_Slot], console: _Console, wire: VideoWire) -> None:
    slot = min(slots, key=lambda s: s.due_ns)
    delay_ns = slot.due_ns - time.monotonic_ns()
    if delay_ns > 0:
        time.sleep(delay_ns / NS_PER_S)
    now_ns = time.monotonic_ns()
    console.listen(now_ns)
    message = slot.serve(console.adaptation.setting(slot.source.name, now_ns), now_ns)
    if message is not None:
        wire.publish(message)
        console.adaptation.sent(message, now_ns)


def _open_slots(config: VideoConfig, sources: Sequence[FrameSource]) -> list[_Slot]:
    now_ns, frame_ns = time.monotonic_ns(), round(NS_PER_S / config.fps)
    slots = []
    for k, source in enumerate(sources):
        period_ns = frame_ns if source.noise_free else LIVE_POLL_NS
        stream = CameraStream(source.name, config, noise_free=source.noise_free)
        slots.append(_Slot(source, stream, period_ns, now_ns + k * frame_ns // len(sources)))
    return slots
