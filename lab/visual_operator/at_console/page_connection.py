"""The connection of the operator's page: what the console sends is taken, key and settings go back, the hand is led."""

import socket
import threading
import time
from collections.abc import Callable
from pathlib import Path
from typing import Self

import msgspec
from websockets.exceptions import ConnectionClosed
from websockets.sync.client import ClientConnection, connect
from websockets.typing import Origin

from common.clock import NS_PER_MS
from common.errors import TransportError
from common.messages.hand import Intent, OperatorSettings
from lab.visual_operator.at_console.console_page import ConsolePage
from lab.visual_operator.at_console.led_pose import LedPose

BEAT_S, BEATS_PER_REPORT = 0.05, 2
STEER_AGAIN_NS = 500 * NS_PER_MS
ATTEMPTS, AGAIN_S = 100, 0.1
JOIN_S = 2.0


class PageConnection:
    """Keeps `page` up to date while the block lasts, and beats 20 times a second as a page does.

    `intent` is the operator's, sent with each beat; `hand` gives the next poses of its hand at a time (ns).
    """

    def __init__(self, port: int, led_by: str, page: ConsolePage) -> None:
        self.page = page
        self.intent = Intent()
        self.hand: Callable[[int], list[LedPose]] = lambda _now_ns: []
        self._socket = _opened(port)
        self._led_by = Path(led_by)
        self._hand_socket = socket.socket(socket.AF_UNIX, socket.SOCK_DGRAM)
        self._steered_ns = 0
        self._over = threading.Event()
        self._threads = [threading.Thread(target=run, daemon=True) for run in (self._receive, self._beat)]

    def __enter__(self) -> Self:
        self._socket.__enter__()
        for thread in self._threads:
            thread.start()
        return self

    def __exit__(self, *_: object) -> None:
        self._over.set()
        self._socket.__exit__(None, None, None)
        for thread in self._threads:
            thread.join(JOIN_S)
        self._hand_socket.close()

    @property
    def is_over(self) -> bool:
        """Return whether the console has closed the connection."""
        return self._over.is_set()

    def _receive(self) -> None:
        try:
            for message in self._socket:
                if isinstance(message, str):
                    self.page.take_text(message)
                else:
                    view = self.page.take_picture(message, time.monotonic_ns())
                    self._say(type="taken", view=view)
        except ConnectionClosed:
            pass
        finally:
            self._over.set()

    def _beat(self) -> None:
        beats = 0
        while not self._over.wait(BEAT_S):
            try:
                self._beat_once(reports=beats % BEATS_PER_REPORT == 0)
            except ConnectionClosed:
                return
            beats += 1

    def _beat_once(self, *, reports: bool) -> None:
        intent, now_ns = self.intent, time.monotonic_ns()
        if poses := self.hand(now_ns):
            for camera in self._led_by.parent.glob(f"{self._led_by.name}.*"):
                self._hand_socket.sendto(msgspec.json.encode(poses), str(camera))
        if intent.settings is not None:
            self._steer(intent.settings, now_ns)
        self._say(
            type="beat",
            page_ms=now_ns / NS_PER_MS,
            heard_ms=self.page.heard_ms,
            down=intent.hold,
            assist=intent.assist,
        )
        if reports:
            self._say(type="shown", h264=False, views=self.page.painted)

    def _steer(self, wanted: OperatorSettings, now_ns: int) -> None:
        """Set what the page does not show as wanted, and again where that has not helped."""
        changes = changed(self.page.settings, wanted)
        if changes and now_ns - self._steered_ns > STEER_AGAIN_NS:
            self._steered_ns = now_ns
            self._say(type="steer", **changes)

    def _say(self, **fields: object) -> None:
        self._socket.send(msgspec.json.encode(fields).decode())


def changed(shown: OperatorSettings | None, wanted: OperatorSettings) -> dict[str, object]:
    """Return what a page has to change of the settings that it shows; nothing while it shows none."""
    if shown is None:
        return {}
    before, after = msgspec.to_builtins(shown), msgspec.to_builtins(wanted)
    scales = {name: after[name] for name in ("scale", "rotation_scale") if after[name] != before[name]}
    locks = {name: to for name, to in after["locks"].items() if to != before["locks"][name]}
    return {**scales, **({"locks": locks} if locks else {})}


def _opened(port: int) -> ClientConnection:
    """The page's connection, as soon as the console is there; TransportError when it does not come."""
    for _ in range(ATTEMPTS):
        try:
            return connect(f"ws://127.0.0.1:{port}/page", origin=Origin(f"http://127.0.0.1:{port}"), max_size=None)
        except ConnectionRefusedError:
            time.sleep(AGAIN_S)
    raise TransportError(f"no console serves a page at port {port}; start one with: farhand console")
