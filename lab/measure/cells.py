"""Cells that one router carries: 1, 2, 4, 8, 16 in parallel, with hands and scaled video: latency, CPU, memory."""

import time
from collections.abc import Sequence
from contextlib import ExitStack

import numpy as np

from common.clock import NS_PER_MS
from common.link.channel_feeds import ChannelFeeds
from common.link.channels import CAMERA, HAND, ChannelSession
from common.link.transport import open_link
from common.messages.hand import HandArm, TrackingStatus
from common.messages.video import Codec, VideoFrame
from farhand.loopback.site_process import SiteProcess, free_ports, module_command, options_of
from lab.measure.video.link import live_frame
from lab.stage.processes import cpu_s, memory_mb
from remote_site.video.streaming.encoding import Encoded

COUNTS = (1, 2, 4, 8, 16)
SECONDS = 5.0
SETTLE_S = 1.5
RATE_HZ = 30.0
OPERATOR = "anna"
VIEWS = ("front_high", "front_low", "side", "gripper")
TICKS_PER_PICTURE = 2
PICTURE_BYTES = 2_800  # larger ones would take shared memory on one host; this makes 1.4 Mbit/s per cell
PICTURE = Encoded(Codec.JPEG, True, 320, 240, bytes(PICTURE_BYTES))

Figures = dict[str, float]


def measure(counts: Sequence[int] = COUNTS, seconds: float = SECONDS) -> Figures:
    """For each number of cells: age of hands and pictures on arrival, the fraction that arrived, the router's load."""
    return {f"{name}_{count}": value for count in counts for name, value in run(count, seconds).items()}


def run(count: int, seconds: float) -> Figures:
    """One router as a process, and the sites of all cells in this one."""
    endpoint, cells = f"tcp/127.0.0.1:{free_ports(1)[0]}", [f"cell-{k}" for k in range(count)]
    options = options_of([f'listen=["{endpoint}"]'])  # without certificates a router passes on every cell's messages
    router = SiteProcess("router", module_command("farhand", "router", *options), {})
    try:
        with ExitStack() as stack:
            played = [LinkedCell(cell, endpoint, stack) for cell in cells]
            _play(played, SETTLE_S)
            for cell in played:
                cell.forget()
            used_s, began = cpu_s(router.pid), time.monotonic()
            _play(played, seconds)
            load = (cpu_s(router.pid) - used_s) / (time.monotonic() - began)
            return _figures(played) | {"router_cpu": load, "router_mb": memory_mb(router.pid)}
    finally:
        router.end()


class LinkedCell:
    """Both sites of a cell: the local one sends the hand and receives the pictures, the remote one the reverse."""

    def __init__(self, name: str, endpoint: str, stack: ExitStack) -> None:
        feeds = ChannelFeeds()
        stack.callback(feeds.join)  # once the links are closed
        remote, video = (
            stack.enter_context(open_link(connect=(endpoint,), through_router=True, sessions=[session]))
            for session in ChannelSession
        )
        local = stack.enter_context(open_link(connect=(endpoint,), sessions=list(ChannelSession)))
        self._hand = local.publisher(HAND, name, operator=OPERATOR)
        self._cameras = {view: video.publisher(CAMERA, name, view) for view in VIEWS}
        self.forget()
        feeds.add(remote.latest(HAND, name), self._take_hand)
        for view in VIEWS:
            feeds.add(local.latest(CAMERA, name, view), self._take_picture)

    def _take_hand(self, hand: HandArm, now_ns: int) -> None:
        self.hand_ages_ms.append((now_ns - hand.capture_ns) / NS_PER_MS)

    def _take_picture(self, frame: VideoFrame, now_ns: int) -> None:
        self.picture_ages_ms.append((now_ns - frame.capture_ns) / NS_PER_MS)

    def forget(self) -> None:
        """Count again from here: what arrived while the sites found each other does not count."""
        self.hand_ages_ms: list[float] = []
        self.picture_ages_ms: list[float] = []
        self.sent_hands = self.sent_pictures = 0

    def tick(self, number: int) -> None:
        """Send a hand, and every other time four pictures."""
        self.sent_hands += 1
        self._hand.put(_hand(number))
        if number % TICKS_PER_PICTURE == 0:
            self.sent_pictures += len(self._cameras)
            for view, camera in self._cameras.items():
                camera.put(live_frame(view, number, time.monotonic_ns(), PICTURE))


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
