"""The cell's views on stepped time: rendered from the snapshot, encoded as they are sent, decoded as they are shown."""

from collections.abc import Callable, Mapping
from dataclasses import dataclass, field

import cv2
import numpy as np

from common.cameras.camera import Frame
from common.clock import NS_PER_MS, NS_PER_S
from common.geometry import Array
from common.messages.requests import Description
from common.messages.video import VideoFrame, ViewsShown
from farhand.loopback.picture_decoder import PictureDecoder
from lab.experiments.placing.network import Messages, Network, Stream
from lab.stage.stepped.site import LEASE, SESSION
from lab.visual_operator.shown import ShownView
from local_site.console.model.page_messages import Painted
from local_site.console.model.page_messages import Shown as PageShown
from local_site.console.model.shown import CAMERA_VIEW, ShownViews
from remote_site.config import RemoteConfig
from remote_site.simulation.cell import build_cell
from remote_site.simulation.memory import CellMemory
from remote_site.video.cell_cameras import CellCamera, open_cell_cameras
from remote_site.video.config import VideoConfig
from remote_site.video.streaming.adaptation import Adaptation
from remote_site.video.streaming.encoding import can_encode
from remote_site.video.streaming.stream import CameraStream

PICTURE_NS = 60 * NS_PER_MS  # from the exposure of a view to the page, beside the network


@dataclass(slots=True)
class _Channel:
    """One camera, and its picture on the page."""

    camera: CellCamera
    stream: CameraStream
    projection: Array
    on_tool: bool
    due_ns: int = 0
    decoder: PictureDecoder = field(default_factory=PictureDecoder)
    shown: ShownView | None = None
    painted: Painted | None = None


@dataclass(frozen=True, slots=True)
class _Report:
    """The console's report to the video process: what it has shown, and what it cannot decode without a key frame."""

    shown: ViewsShown | None
    wants_after: Mapping[str, int]


class StreamedViews:
    """All views of the cell that the description publishes a calibration of; those of a page over a network.

    What is sent follows the console's reports, as at a site. Without a network there are none: all is sent in full.
    `see` is called with each camera's newest picture, before it is encoded.
    """

    def __init__(
        self,
        config: RemoteConfig,
        memory: CellMemory,
        description: Description,
        network: Network | None,
        rng: np.random.Generator,
    ) -> None:
        self._config: VideoConfig = config.video
        self._adaptation = Adaptation(config.video, h264=can_encode(config.video.codec))
        self._console = ShownViews(SESSION) if network is not None else None
        self._pictures = Stream[VideoFrame](network or Network(), rng, PICTURE_NS)
        self._reports = Messages[_Report](network or Network(), rng)
        self._channels = _channels(config, memory, description)
        self.see: Callable[[str, Frame | None], None] = lambda _name, _frame: None

    def expose(self, now_ns: int) -> None:
        """Expose the cameras whose turn it is, and send what they see."""
        for report in self._reports.arrived(now_ns):
            self._follow(report, now_ns)
        for name, channel in self._channels.items():
            if now_ns < channel.due_ns:
                continue
            setting = self._adaptation.setting(name, now_ns)
            channel.due_ns = now_ns + round(NS_PER_S / min(self._config.fps, setting.fps))
            frame = channel.camera.newest()
            self.see(name, frame)
            sent = channel.stream.take(frame, setting, now_ns)
            if sent is not None:
                self._pictures.send(sent, len(sent.data), now_ns)
                self._adaptation.sent(sent, now_ns)

    def page(self, now_ns: int) -> Mapping[str, ShownView]:
        """The newest picture of every view that has come."""
        for sent in self._pictures.arrived(now_ns):
            self._paint(self._channels[sent.camera], sent, now_ns)
        if self._console is not None:
            self._reports.send(self._report(self._console, now_ns), now_ns)
        return {name: channel.shown for name, channel in self._channels.items() if channel.shown is not None}

    def _paint(self, channel: _Channel, sent: VideoFrame, now_ns: int) -> None:
        picture = channel.decoder.decode(sent)
        usable = picture is not None
        if self._console is not None:
            self._console.remember(CAMERA_VIEW + sent.camera, sent, now_ns, 0, usable=usable)
        if picture is None:
            return
        size = self._config.width, self._config.height
        if picture.shape[1::-1] != size:
            picture = np.asarray(cv2.resize(picture, size, interpolation=cv2.INTER_LINEAR), dtype=np.uint8)
        channel.shown = ShownView(picture, sent.capture_ns, channel.projection, channel.on_tool)
        age_ms = (now_ns - sent.capture_ns) / NS_PER_MS
        channel.painted = Painted(seq=sent.seq, age_ms=age_ms, fps=self._config.fps)

    def _report(self, console: ShownViews, now_ns: int) -> _Report:
        channels = self._channels.items()
        painted = {CAMERA_VIEW + name: channel.painted for name, channel in channels if channel.painted is not None}
        wants = {name: after for name, channel in channels if (after := channel.decoder.wants_after) is not None}
        return _Report(console.message(PageShown(views=painted, h264=True), LEASE, now_ns), wants)

    def _follow(self, report: _Report, now_ns: int) -> None:
        if report.shown is not None:
            self._adaptation.update(report.shown, now_ns)
        for name, after in report.wants_after.items():
            self._channels[name].stream.want_key_frame(after)


def _channels(config: RemoteConfig, memory: CellMemory, description: Description) -> dict[str, _Channel]:
    cell = build_cell(config.simulation, config.robot, dressed=True)
    calibrated = {camera.name: camera.calibration for camera in description.cameras if camera.calibration}
    return {
        camera.name: _Channel(
            camera,
            CameraStream(camera.name, config.video, noise_free=True),
            np.reshape(calibrated[camera.name].projection, (3, 4)),
            calibrated[camera.name].on_tool,
        )
        for camera in open_cell_cameras(list(calibrated), cell, memory.snapshot, config.video)
    }
