"""The video process with H.264: viewers get key frames on request, and an invalid request delays nothing."""

import time
from collections.abc import Callable, Iterator

import numpy as np
import pytest
from structlog.testing import capture_logs

from common.cameras.camera import Frame
from common.errors import MessageError
from common.messages.video import CameraStatus, Codec, KeyFrameRequest, VideoFrame
from farhand.loopback.picture_decoder import PictureDecoder
from remote_site.video import process, sources
from remote_site.video.config import CameraConfig, VideoConfig
from remote_site.video.process import VideoWire, run_video
from remote_site.video.streaming.codec_choice import CodecPreference

CONFIG = VideoConfig(
    cameras=(CameraConfig(name="side", source="0"), CameraConfig(name="front", source="1")),
    codec=CodecPreference.H264,
    frozen_ms=5000,  # a busy machine may stop this process for long
)
PATIENCE_S = 20.0


class Moving:
    """A camera that gives a new picture each time it is asked."""

    noise_free = False

    def __init__(self, name: str, _open_it: object, _lost: object) -> None:
        self.name = name
        self._seq = 0

    def newest(self) -> Frame:
        self._seq += 1
        image = np.full((120, 160, 3), 60, np.uint8)
        image[:, : self._seq % 160] = 180
        return Frame(image, time.monotonic_ns(), self._seq)

    def close(self) -> None: ...


@pytest.fixture(autouse=True)
def moving_cameras(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(process, "be_nice", lambda _: None)
    monkeypatch.setattr(sources, "ThreadedCamera", Moving)


class Viewer:
    """Decodes what comes; loses the pictures that `loses` selects, and asks as a console does."""

    def __init__(self, loses: Callable[[VideoFrame], bool] = lambda _: False) -> None:
        self.seen: list[VideoFrame] = []
        self.decoded: list[tuple[str, int]] = []
        self._loses = loses
        self._decoders = {camera.name: PictureDecoder() for camera in CONFIG.cameras}

    def take(self, frame: VideoFrame) -> None:
        self.seen.append(frame)
        if not self._loses(frame) and self._decoders[frame.camera].decode(frame) is not None:
            self.decoded.append((frame.camera, frame.seq))

    def requests(self) -> Iterator[KeyFrameRequest]:
        for camera, decoder in self._decoders.items():
            if decoder.wants_after is not None:
                yield KeyFrameRequest(camera=camera, after_seq=decoder.wants_after)


def run(viewer: Viewer, source: Callable[[], KeyFrameRequest | None], enough: Callable[[], bool]) -> None:
    deadline = time.monotonic() + PATIENCE_S
    wire = VideoWire(viewer.take, key_frames=source)
    run_video(CONFIG, None, wire, lambda: enough() or time.monotonic() > deadline, lambda: None)


def test_a_viewer_that_lost_a_picture_decodes_again_after_the_key_frame_that_it_asked_for() -> None:
    viewer = Viewer(lambda frame: frame.camera == "side" and frame.seq == 5)
    run(
        viewer,
        lambda: next(viewer.requests(), None),
        lambda: sum(camera == "side" for camera, _ in viewer.decoded) >= 15,
    )
    keys = {name: [f.seq for f in viewer.seen if f.camera == name and f.key] for name in ("side", "front")}
    assert {frame.codec for frame in viewer.seen if frame.data} == {Codec.H264}
    assert keys["front"] == [0]
    assert keys["side"][0] == 0
    assert len(keys["side"]) == 2
    decoded = [seq for camera, seq in viewer.decoded if camera == "side"]
    assert decoded[:6] == [0, 1, 2, 3, 4, keys["side"][1]]
    assert [seq for camera, seq in viewer.decoded if camera == "front"][:8] == list(range(8))


def test_requests_for_unknown_cameras_and_of_another_release_change_nothing() -> None:
    viewer = Viewer()
    heard = [KeyFrameRequest(camera="roof", after_seq=3)] * 20

    def asked() -> KeyFrameRequest | None:
        if heard:
            return heard.pop()
        raise MessageError("version", "version 8, this side speaks 9")

    with capture_logs() as logs:
        run(viewer, asked, lambda: len(viewer.seen) > 20)
    assert [entry["event"] for entry in logs] == ["a viewer's request for a key frame is refused"]
    assert [frame.seq for frame in viewer.seen if frame.key] == [0, 0]
    assert {frame.status for frame in viewer.seen} <= {CameraStatus.LIVE, CameraStatus.SLOW}
