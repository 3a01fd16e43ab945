"""Records every hand sample, robot state and camera frame of a loopback for its figures."""

import time
from collections.abc import Callable
from dataclasses import dataclass, field
from functools import partial

from common.cameras.camera import Image
from common.link.channel_feeds import ChannelFeeds
from common.link.channels import ANY, CAMERA, HAND, KEY_FRAMES, STATE
from common.link.pubsub import Publisher
from common.link.transport import Link
from common.messages.hand import HandArm
from common.messages.robot import RobotState
from common.messages.video import CameraStatus, Codec, KeyFrameRequest, VideoFrame
from farhand.loopback.picture_decoder import PictureDecoder

DECODE_EVERY = 5


@dataclass
class CameraRecord:
    """One camera's stream: exposures, arrivals at the viewer, exposure to the decoded picture (ms), the last of these.

    `ask` is called with the number of a picture that cannot be decoded, to get a key frame.
    """

    exposures_ns: list[int] = field(default_factory=list)
    arrivals_ns: list[int] = field(default_factory=list)
    glass_to_glass_ms: list[float] = field(default_factory=list)
    not_live: int = 0
    last: Image | None = None
    ask: Callable[[int], object] = lambda _: None
    decoder: PictureDecoder = field(default_factory=PictureDecoder)

    def add(self, frame: VideoFrame, arrival_ns: int) -> None:
        """Record a frame; decode and time every fifth, as a display would, and all that others need."""
        if frame.status is not CameraStatus.LIVE:
            self.not_live += 1
        if not frame.data:
            return
        if len(self.arrivals_ns) % DECODE_EVERY == 0 or frame.codec is not Codec.JPEG:
            self._decode(frame)
        self.exposures_ns.append(frame.capture_ns)
        self.arrivals_ns.append(arrival_ns)

    def _decode(self, frame: VideoFrame) -> None:
        picture = self.decoder.decode(frame)
        if picture is not None:
            self.glass_to_glass_ms.append((time.monotonic_ns() - frame.capture_ns) / 1e6)
            self.last = picture
        elif self.decoder.wants_after is not None:
            self.ask(self.decoder.wants_after)


@dataclass
class Record:
    """Everything received, in order, and the times of the last hand and the last state (ns)."""

    hands: list[HandArm] = field(default_factory=list)
    states: list[RobotState] = field(default_factory=list)
    cameras: dict[str, CameraRecord] = field(default_factory=dict)
    last_hand_ns: int = 0
    last_state_ns: int = 0


class Recorder:
    """Listens to all channels, a thread each, until the links are closed."""

    def __init__(self, control: Link, video: Link, cell: str, cameras: tuple[str, ...], operator: str = ANY) -> None:
        self.record = Record(cameras={name: CameraRecord() for name in cameras})
        self._feeds = ChannelFeeds()
        self._feeds.add(control.latest(HAND, cell, operator=operator), self._hand)
        self._feeds.add(control.latest(STATE, cell), self._state)
        key_frames = video.publisher(KEY_FRAMES, cell) if cameras else None
        for name, camera in self.record.cameras.items():
            if key_frames is not None:
                camera.ask = partial(_ask, key_frames, name)
            self._feeds.add(video.latest(CAMERA, cell, name), camera.add)

    def _hand(self, hand: HandArm, now_ns: int) -> None:
        self.record.hands.append(hand)
        self.record.last_hand_ns = now_ns

    def _state(self, state: RobotState, now_ns: int) -> None:
        self.record.states.append(state)
        self.record.last_state_ns = now_ns

    def join(self) -> None:
        """Wait for the threads once the links are closed."""
        self._feeds.join()


def _ask(key_frames: Publisher[KeyFrameRequest], camera: str, after_seq: int) -> None:
    key_frames.put(KeyFrameRequest(camera=camera, after_seq=after_seq))
