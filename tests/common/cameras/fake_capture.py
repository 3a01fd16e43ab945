"""A stand-in for cv2.VideoCapture with the V4L2 backend: a camera with known modes on a clock that tests advance."""

from dataclasses import dataclass, field

import cv2
import numpy as np

from common.cameras.camera import Image
from common.clock import NS_PER_MS, FakeClock

MJPG, YUYV = (cv2.VideoWriter.fourcc(*code) for code in ("MJPG", "YUYV"))
SIZES = {MJPG: ((640, 480), (1280, 720)), YUYV: ((640, 480),)}
OFFERED_FPS = (15.0, 30.0, 60.0)
CONTROLS = {
    cv2.CAP_PROP_AUTO_EXPOSURE: 3.0,
    cv2.CAP_PROP_EXPOSURE: 157.0,
    cv2.CAP_PROP_GAIN: 0.0,
    cv2.CAP_PROP_AUTOFOCUS: 1.0,
    cv2.CAP_PROP_FOCUS: 0.0,
}


@dataclass
class FakeCapture:
    """Gives the nearest of what it has, as drivers do, and a frame each period of its rate.

    A frame arrives `transfer_ms` after its stamp. `stamp_shift_ns` moves the stamps to another clock; `missing` are
    properties that the camera does not have; `step` is that of its focus.
    """

    clock: FakeClock
    backend: str = "V4L2"
    transfer_ms: float = 5.0
    stamp_shift_ns: float = 0
    missing: frozenset[int] = frozenset()
    step: int = 5
    opens: bool = True
    frames: int = 1_000_000
    waiting: int = 0
    released: bool = False
    values: dict[int, float] = field(default_factory=lambda: dict(CONTROLS))
    _size: tuple[int, int] = (640, 480)
    _format: int = YUYV
    _fps: float = 30.0
    _width: int = 640
    _stamp_ns: int = 0

    def isOpened(self) -> bool:
        return self.opens

    def getBackendName(self) -> str:
        return self.backend

    def set(self, propId: int, value: float, /) -> bool:
        if propId in self.missing:
            return False
        if propId == cv2.CAP_PROP_FOURCC:
            self._format = int(value) if int(value) in SIZES else self._format
        elif propId == cv2.CAP_PROP_FRAME_WIDTH:
            self._width = int(value)
        elif propId == cv2.CAP_PROP_FRAME_HEIGHT:
            wanted = self._width, int(value)
            self._size = min(SIZES[self._format], key=lambda size: abs(size[0] - wanted[0]) + abs(size[1] - wanted[1]))
        elif propId == cv2.CAP_PROP_FPS:
            self._fps = min(OFFERED_FPS, key=lambda fps: abs(fps - value))
        else:
            self._set_control(propId, value)
        return True

    def _set_control(self, prop: int, value: float) -> None:
        is_auto = self.values.get(cv2.CAP_PROP_AUTO_EXPOSURE) == 3.0
        if prop == cv2.CAP_PROP_EXPOSURE and is_auto:
            return  # inactive, as V4L2 says
        self.values[prop] = self.step * round(value / self.step) if prop == cv2.CAP_PROP_FOCUS else float(value)

    def get(self, propId: int, /) -> float:
        if propId in self.missing:
            return -1.0
        if propId == cv2.CAP_PROP_FOURCC:
            return self._format
        if propId == cv2.CAP_PROP_FPS:
            return self._fps
        if propId == cv2.CAP_PROP_POS_MSEC:
            return (self._stamp_ns + self.stamp_shift_ns) / NS_PER_MS
        return self.values.get(propId, -1.0)

    def grab(self) -> bool:
        if self.frames <= 0:
            return False
        self.frames -= 1
        period_ns = round(1e9 / self._fps)
        self._stamp_ns += period_ns
        if self.waiting:
            self.waiting -= 1
        else:
            self._stamp_ns = max(self._stamp_ns, self.clock.now_ns() - round(self.transfer_ms * NS_PER_MS) + period_ns)
            self.clock.sleep_until_ns(self._stamp_ns + round(self.transfer_ms * NS_PER_MS))
        return True

    def picture(self) -> Image:
        """What the sensor sees now."""
        return np.zeros((self._size[1], self._size[0], 3), dtype=np.uint8)

    def read(self) -> tuple[bool, object]:
        return (True, self.picture()) if self.grab() else (False, None)

    def release(self) -> None:
        self.released = True
