"""Camera frames for pages: as bytes, and of each view what can be decoded, only as fast as a page takes it."""

import struct
from collections import deque
from dataclasses import dataclass, field

import msgspec

from common.clock import NS_PER_MS, ClockOffset
from common.messages.continuity import Continuity
from common.messages.video import VideoFrame

MOST_WAITING = 16  # half a second
IN_FLIGHT = 2  # one in transit while the other is painted; more would be a queue
LENGTH = struct.Struct("<H")


@dataclass(frozen=True, slots=True)
class ViewFrame:
    """One message of a view for a page: its number, whether it has a picture, a key one, and the bytes to send."""

    view: str
    seq: int
    is_picture: bool
    key: bool
    payload: bytes


def view_frame(view: str, frame: VideoFrame, clock: ClockOffset | None) -> ViewFrame:
    """A camera's frame for pages: the length of a JSON header, the header, then the picture as it came.

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
            "codec": frame.codec.value,
            "key": frame.key,
        }
    )
    return ViewFrame(view, frame.seq, bool(frame.data), frame.key, LENGTH.pack(len(header)) + header + frame.data)


@dataclass
class _ViewSlot:
    """One view's frames for a page: those that wait, how many it has not painted yet, what it can decode."""

    waiting: deque[ViewFrame] = field(default_factory=deque)
    in_flight: int = 0
    continuity: Continuity = field(default_factory=Continuity)

    def offer(self, frame: ViewFrame) -> bool:
        if not self.continuity.take(frame.seq, is_picture=frame.is_picture, key=frame.key):
            return False
        if frame.key:
            self.waiting.clear()
        if len(self.waiting) == MOST_WAITING:
            self.waiting.clear()
            self.continuity.interrupt()
            return False
        self.waiting.append(frame)
        return True


class FrameSlots:
    """Holds each view's frames for one page, and views take turns.

    A picture that needs no other replaces all that wait. A page that is too slow for the others gets none until a key
    frame, and so does one that has missed any.
    """

    def __init__(self) -> None:
        self._slots: dict[str, _ViewSlot] = {}

    def offer(self, frame: ViewFrame) -> bool:
        """Take a frame; False for one that the page could not decode."""
        return self._slots.setdefault(frame.view, _ViewSlot()).offer(frame)

    def take(self) -> ViewFrame | None:
        """The next frame that may be sent now; None when nothing waits, or the page is behind with all that wait."""
        view = next((v for v, slot in self._slots.items() if slot.waiting and slot.in_flight < IN_FLIGHT), None)
        if view is None:
            return None
        slot = self._slots[view] = self._slots.pop(view)  # to the end: the view sent last comes last
        slot.in_flight += 1
        return slot.waiting.popleft()

    def taken(self, view: str) -> None:
        """The page has painted a frame of this view, or skipped it."""
        slot = self._slots.get(view)
        if slot is not None and slot.in_flight > 0:
            slot.in_flight -= 1

    def interrupt(self, view: str) -> None:
        """The page could not decode a frame of this view."""
        if view in self._slots:
            self._slots[view].waiting.clear()
            self._slots[view].continuity.interrupt()

    def wants_after(self, view: str) -> int | None:
        """The number of the picture after which this page needs a key frame of a view; None without need."""
        slot = self._slots.get(view)
        return None if slot is None else slot.continuity.wants_after
