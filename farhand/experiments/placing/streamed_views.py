"""The cell's views on stepped time: rendered from the snapshot, encoded as they are sent, decoded as they are shown."""

from collections.abc import Mapping
from dataclasses import dataclass

import numpy as np

from common.geometry import Array
from common.messages.requests import Description
from farhand.loopback.picture_decoder import PictureDecoder
from farhand.visual_operator.shown import ShownView
from remote_site.config import RemoteConfig
from remote_site.simulation.cell import build_cell
from remote_site.simulation.memory import CellMemory
from remote_site.video.cell_cameras import CellCamera, open_cell_cameras
from remote_site.video.streaming.setting import StreamSetting
from remote_site.video.streaming.stream import CameraStream


@dataclass(slots=True)
class _Channel:
    """One camera from its exposure to the decoded picture."""

    camera: CellCamera
    stream: CameraStream
    decoder: PictureDecoder
    projection: Array
    on_tool: bool

    def look(self, setting: StreamSetting, now_ns: int) -> ShownView | None:
        """What is on the page once the picture exposed now has come; None where there is none."""
        sent = self.stream.take(self.camera.newest(), setting, now_ns)
        picture = self.decoder.decode(sent) if sent is not None else None
        if sent is None or picture is None:
            return None
        return ShownView(picture, sent.capture_ns, self.projection, self.on_tool)


class StreamedViews:
    """All views of the cell that the description publishes a calibration of."""

    def __init__(self, config: RemoteConfig, memory: CellMemory, description: Description) -> None:
        cell = build_cell(config.simulation, config.robot, dressed=True)
        calibrated = {camera.name: camera.calibration for camera in description.cameras if camera.calibration}
        cameras = open_cell_cameras(list(calibrated), cell, memory.snapshot, config.video)
        self._setting = StreamSetting(config.video.quality, 1.0, config.video.fps)
        self._channels = {
            camera.name: _Channel(
                camera,
                CameraStream(camera.name, config.video, noise_free=True),
                PictureDecoder(),
                np.reshape(calibrated[camera.name].projection, (3, 4)),
                calibrated[camera.name].on_tool,
            )
            for camera in cameras
        }

    def look(self, now_ns: int) -> Mapping[str, ShownView]:
        """All views exposed now."""
        looked = {name: channel.look(self._setting, now_ns) for name, channel in self._channels.items()}
        return {name: view for name, view in looked.items() if view is not None}
