"""What the loopback saw: every hand sample, robot state and camera frame, kept as plain numbers for the figures."""

import threading
import time
from collections.abc import Callable
from dataclasses import dataclass, field
from typing import TypeVar

import simplejpeg

from common.link.channels import CAMERA, HAND, STATE
from common.link.pubsub import Latest
from common.link.transport import Link
from common.messages.base import Message
from common.messages.hand import HandArm
from common.messages.robot import RobotState
from common.messages.video import CameraStatus, VideoFrame

M = TypeVar("M", bound=Message)

DECODE_EVERY = 5


@dataclass
class CameraRecord:
    """One camera's stream: exposures, arrivals at the viewer, exposure to the decoded picture (ms), the last frame."""

    exposures_ns: list[int] = field(default_factory=list)
    arrivals_ns: list[int] = field(default_factory=list)
    glass_to_glass_ms: list[float] = field(default_factory=list)
    not_live: int = 0
    last: VideoFrame | None = None

    def add(self, frame: VideoFrame, arrival_ns: int) -> None:
        """Take a frame; every fifth is decoded, since a display decodes too, and timed."""
        if frame.status is not CameraStatus.LIVE:
            self.not_live += 1
        if not frame.jpeg:
            return
        if len(self.arrivals_ns) % DECODE_EVERY == 0:
            simplejpeg.decode_jpeg(frame.jpeg, colorspace="BGR")
            self.glass_to_glass_ms.append((time.monotonic_ns() - frame.capture_ns) / 1e6)
        self.exposures_ns.append(frame.capture_ns)
        self.arrivals_ns.append(arrival_ns)
        self.last = frame


@dataclass
class Record:
    """Everything that came, in order, with the time at which it came (ns)."""

    hands: list[HandArm] = field(default_factory=list)
    states: list[RobotState] = field(default_factory=list)
    cameras: dict[str, CameraRecord] = field(default_factory=dict)
    last_hand_ns: int = 0
    last_state_ns: int = 0


class Recorder:
    """Listens on all channels, a thread each, until the links are closed."""

    def __init__(self, control: Link, video: Link, cell: str, cameras: tuple[str, ...]) -> None:
        self.record = Record(cameras={name: CameraRecord() for name in cameras})
        self._listen(control.latest(HAND, cell), self._hand)
        self._listen(control.latest(STATE, cell), self._state)
        for name, camera in self.record.cameras.items():
            self._listen(video.latest(CAMERA, cell, name), camera.add)

    def _hand(self, hand: HandArm, now_ns: int) -> None:
        self.record.hands.append(hand)
        self.record.last_hand_ns = now_ns

    def _state(self, state: RobotState, now_ns: int) -> None:
        self.record.states.append(state)
        self.record.last_state_ns = now_ns

    def _listen(self, latest: Latest[M], take: Callable[[M, int], None]) -> None:
        threading.Thread(target=latest.feed, args=(take,), daemon=True).start()
