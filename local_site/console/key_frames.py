"""Asks the remote site for key frames: at once, again while none comes, and once for all pages."""

from collections.abc import Callable

from common.clock import NS_PER_MS
from common.messages.video import KeyFrameRequest

REPEAT_NS = 100 * NS_PER_MS


class KeyFrames:
    """The requests of one console, sent through `send`."""

    def __init__(self, send: Callable[[KeyFrameRequest], object]) -> None:
        self._send = send
        self._sent_ns: dict[str, int] = {}

    def ask(self, camera: str, after_seq: int, now_ns: int) -> None:
        """A page cannot decode this camera's picture of the number `after_seq`; called for each that comes."""
        sent_ns = self._sent_ns.get(camera)
        if sent_ns is None or now_ns - sent_ns >= REPEAT_NS:
            self._sent_ns[camera] = now_ns
            self._send(KeyFrameRequest(camera=camera, after_seq=after_seq))
