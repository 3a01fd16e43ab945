"""A camera's picture as it goes to a page: a small header in JSON, then the JPEG as it came; pure."""

import struct

import msgspec

from common.clock import NS_PER_MS, ClockOffset
from common.messages.video import VideoFrame
from local_site.console.frame_slots import ViewFrame

LENGTH = struct.Struct("<H")


def view_frame(view: str, frame: VideoFrame, clock: ClockOffset | None) -> ViewFrame:
    """The frame of a view, its exposure translated to this host's clock; `clock` is the sender's, None if unknown."""
    exposed_ns = frame.capture_ns - clock.offset_ns if clock is not None and frame.capture_ns else None
    header = {
        "view": view,
        "seq": frame.seq,
        "capture_ms": exposed_ns / NS_PER_MS if exposed_ns is not None else None,
        "unsure_ms": clock.uncertainty_ns / NS_PER_MS if clock is not None else None,
        "estimated": frame.capture_estimated,
        "status": frame.status.value,
        "reason": frame.reason,
    }
    told = msgspec.json.encode(header)
    return ViewFrame(view, frame.seq, LENGTH.pack(len(told)) + told + frame.jpeg)
