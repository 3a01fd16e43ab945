"""Stands in for the operator's views where no camera is used: the console gets the reason."""

from collections.abc import Mapping

from common.clock import NS_PER_MS
from common.messages.video import CameraStatus, Codec, VideoFrame
from local_site.preview.preview import MAX_REASON, PreviewSink

PERIOD_NS = 250 * NS_PER_MS


class NoCamera:
    """Says of each view, by its name in `wires`, why there is none, while somebody looks."""

    def __init__(self, wires: Mapping[str, PreviewSink], reason: str) -> None:
        self._wires, self._reason = wires, reason[:MAX_REASON]
        self._seq = 0
        self._due_ns = 0

    def tell(self, now_ns: int) -> None:
        """Say it, if it is time."""
        if now_ns < self._due_ns:
            return
        self._due_ns = now_ns + PERIOD_NS
        self._seq += 1
        for view, wire in self._wires.items():
            if wire.has_listener:
                wire.put(self._frame(view))

    def _frame(self, view: str) -> VideoFrame:
        return VideoFrame(
            camera=view,
            seq=self._seq,
            capture_ns=0,
            capture_estimated=False,
            status=CameraStatus.MISSING,
            reason=self._reason,
            width=0,
            height=0,
            codec=Codec.JPEG,
            key=False,
            data=b"",
        )
