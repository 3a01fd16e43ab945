"""Camera frames for pages: as bytes, and the newest of each view sent only as fast as a page takes them."""

import struct
from dataclasses import dataclass

import msgspec

from common.clock import NS_PER_MS, ClockOffset
from common.messages.video import VideoFrame

IN_FLIGHT = 2  # one in transit while the other is painted; more would be a queue
LENGTH = struct.Struct("<H")


@dataclass(frozen=True, slots=True)
class ViewFrame:
    """One picture to be sent to a page: its view, its number, and the bytes as they are sent."""

    view: str
    seq: int
    payload: bytes


def view_frame(view: str, frame: VideoFrame, clock: ClockOffset | None) -> ViewFrame:
    """A camera's frame for pages: the length of a JSON header, the header, then the JPEG as it came.

    The exposure is translated to this host's clock; `clock` is the sender's offset, None if unknown.
    """
    exposed_ns = frame.capture_ns - clock.offset_ns if clock is not None and frame.capture_ns else None
    header = msgspec.json.encode(
        {
            "view": view,
            "seq": frame.seq,
            "capture_ms": exposed_ns / NS_PER_MS if exposed_ns is not None else None,
            "unsure_ms": clock.uncertainty_ns / NS_PER_MS if clock is not None else None,
            "estimated": frame.capture_estimated,
            "status": frame.status.value,
            "reason": frame.reason,
        }
    )
    return ViewFrame(view, frame.seq, LENGTH.pack(len(header)) + header + frame.jpeg)


class FrameSlots:
    """Holds one frame per view for one page; a newer one replaces it, and views take turns."""

    def __init__(self) -> None:
        self._waiting: dict[str, ViewFrame] = {}
        self._sent: dict[str, int] = {}

    def offer(self, frame: ViewFrame) -> None:
        """Take a frame; an older one of this view that still waits is dropped."""
        self._waiting[frame.view] = frame

    def take(self) -> ViewFrame | None:
        """The next frame that may be sent now; None when nothing waits, or the page is behind with all that wait."""
        ready = [view for view in self._sent if view in self._waiting and self._sent[view] < IN_FLIGHT]
        fresh = [view for view in self._waiting if view not in self._sent]
        if not ready and not fresh:
            return None
        view = (fresh or ready)[0]
        self._sent[view] = self._sent.pop(view, 0) + 1  # to the end: the view sent last comes last
        return self._waiting.pop(view)

    def taken(self, view: str) -> None:
        """The page has painted a frame of this view, or skipped it."""
        if self._sent.get(view, 0) > 0:
            self._sent[view] -= 1
