"""How many cells one router carries: 1, 2, 4, 8, 16 at once, with hands and scaled video: latency, CPU, memory."""

import os
import subprocess
import sys
import threading
import time
from collections.abc import Callable, Sequence
from contextlib import ExitStack
from functools import partial
from pathlib import Path

import numpy as np

from common.clock import NS_PER_MS
from common.link.channels import CAMERA, HAND
from common.link.transport import Link, open_link
from common.messages.hand import HandArm, TrackingStatus
from common.messages.video import CameraStatus, VideoFrame
from farhand.loopback.site_process import free_ports

COUNTS = (1, 2, 4, 8, 16)
SECONDS = 5.0
SETTLE_S = 1.5
START_S = 30.0
RATE_HZ = 30.0
VIEWS = ("front_high", "front_low", "side", "gripper")
TICKS_PER_PICTURE = 2
PICTURE_BYTES = 2_800  # larger ones would pass by shared memory on one host; this makes 1.4 Mbit/s a cell
KB_PER_MB = 1024
TICKS_PER_S = os.sysconf("SC_CLK_TCK")

Figures = dict[str, float]


def measure(counts: Sequence[int] = COUNTS, seconds: float = SECONDS) -> Figures:
    """For each number of cells: the hand's and the pictures' age on arrival, the share that came, the router's load."""
    return {f"{name}_{count}": value for count in counts for name, value in run(count, seconds).items()}


def run(count: int, seconds: float) -> Figures:
    """One router as a process, and the sites of all cells in this one."""
    endpoint, cells = f"tcp/127.0.0.1:{free_ports(1)[0]}", [f"cell-{k}" for k in range(count)]
    settings = [f'listen=["{endpoint}"]', f"cells={cells}"]
    arguments = [part for setting in settings for part in ("--set", setting)]
    router = subprocess.Popen([sys.executable, "-m", "farhand", "router", *arguments], stderr=subprocess.DEVNULL)  # noqa: S603  # our own program
    try:
        with ExitStack() as stack:
            played = [LinkedCell(cell, endpoint, stack) for cell in cells]
            _play(played, SETTLE_S)
            for cell in played:
                cell.forget()
            used_s, began = _used_s(router.pid), time.monotonic()
            _play(played, seconds)
            load = (_used_s(router.pid) - used_s) / (time.monotonic() - began)
            return _figures(played) | {"router_cpu": load, "router_mb": _memory_mb(router.pid)}
    finally:
        router.terminate()
        router.wait(START_S)


class LinkedCell:
    """Both sites of a cell: one sends the hand and hears the pictures, the other the other way round."""

    def __init__(self, name: str, endpoint: str, stack: ExitStack) -> None:
        remote, video = (
            stack.enter_context(open_link(connect=(endpoint,), through_router=True)) for _ in ("control", "video")
        )
        local = stack.enter_context(open_link(connect=(endpoint,)))
        self._hand = local.publisher(HAND, name)
        self._cameras = [video.publisher(CAMERA, name, view) for view in VIEWS]
        self.hand_ages_ms: list[float] = []
        self.picture_ages_ms: list[float] = []
        self.sent_hands = self.sent_pictures = 0
        self._listen(remote, name)
        for view in VIEWS:
            pictures = local.latest(CAMERA, name, view)
            _begin(partial(pictures.feed, self._take_picture))

    def _listen(self, remote: Link, name: str) -> None:
        hands = remote.latest(HAND, name)
        _begin(partial(hands.feed, self._take_hand))

    def _take_hand(self, hand: HandArm, now_ns: int) -> None:
        self.hand_ages_ms.append((now_ns - hand.capture_ns) / NS_PER_MS)

    def _take_picture(self, frame: VideoFrame, now_ns: int) -> None:
        self.picture_ages_ms.append((now_ns - frame.capture_ns) / NS_PER_MS)

    def forget(self) -> None:
        """What came while the sites found each other does not count."""
        self.hand_ages_ms, self.picture_ages_ms = [], []
        self.sent_hands = self.sent_pictures = 0

    def tick(self, number: int) -> None:
        """Send a hand, and every other time four pictures."""
        self.sent_hands += 1
        self._hand.put(_hand(number))
        if number % TICKS_PER_PICTURE == 0:
            self.sent_pictures += len(self._cameras)
            for view, camera in zip(VIEWS, self._cameras, strict=True):
                camera.put(_picture(view, number))


def _play(cells: list[LinkedCell], seconds: float) -> None:
    """All cells tick 30 times a second, one after the other within the period."""
    began = time.monotonic()
    for number in range(round(seconds * RATE_HZ)):
        for k, cell in enumerate(cells):
            due = began + (number + k / len(cells)) / RATE_HZ
            time.sleep(max(0.0, due - time.monotonic()))
            cell.tick(number)


def _figures(cells: list[LinkedCell]) -> Figures:
    hands = [age for cell in cells for age in cell.hand_ages_ms]
    pictures = [age for cell in cells for age in cell.picture_ages_ms]
    return {
        "hand_p50_ms": float(np.median(hands)),
        "hand_p99_ms": float(np.percentile(hands, 99)),
        "hands_arrived": len(hands) / sum(cell.sent_hands for cell in cells),
        "picture_p50_ms": float(np.median(pictures)),
        "pictures_arrived": len(pictures) / sum(cell.sent_pictures for cell in cells),
    }


def _begin(listen: Callable[[], None]) -> None:
    threading.Thread(target=listen, daemon=True).start()


def _hand(number: int) -> HandArm:
    point = (0.1, 0.2, 0.3)
    return HandArm(
        session=1,
        seq=number,
        capture_ns=time.monotonic_ns(),
        elbow=point,
        wrist=point,
        index=point,
        thumb=point,
        status=TrackingStatus.TRACKED,
        reason="",
        thumb_inferred=False,
        hand_open=False,
        gripper_toggles=0,
    )


def _picture(view: str, number: int) -> VideoFrame:
    return VideoFrame(
        camera=view,
        seq=number,
        capture_ns=time.monotonic_ns(),
        capture_estimated=False,
        status=CameraStatus.LIVE,
        reason="",
        width=320,
        height=240,
        jpeg=bytes(PICTURE_BYTES),
    )


def _used_s(pid: int) -> float:
    fields = Path(f"/proc/{pid}/stat").read_text().rpartition(")")[2].split()
    return (int(fields[11]) + int(fields[12])) / TICKS_PER_S


def _memory_mb(pid: int) -> float:
    lines = Path(f"/proc/{pid}/status").read_text().splitlines()
    return next(float(line.split()[1]) for line in lines if line.startswith("VmRSS")) / KB_PER_MB
