"""Pictures sent of each camera, what of them has come to the console, and how long that took; pure."""

import statistics
from collections import deque
from collections.abc import Sequence
from dataclasses import dataclass

from common.clock import NS_PER_MS, NS_PER_S
from common.messages.video import Codec, VideoFrame, ViewCame
from remote_site.video.streaming.setting import StreamSetting

MOST_WAITING = 256
SMOOTHING = 0.3
ALL_CAME = 0.85  # of the pictures: one may just have been too late for the count


@dataclass(frozen=True, slots=True)
class Arrivals:
    """The figures of one report about the pictures.

    Since the last report `sent_bytes` went out and `carried_bytes` came; `waiting_bytes` are still on their way.
    `delay_ms` is what the newest that came took from here to the console, and `round_trip_ms` what passed from sending
    it to the report; `overdue_ms` has passed since the oldest that has not come was sent, 0 without one. `held_back` is
    whether pictures were left out because earlier ones still waited in this host; they count as sent. Of the times,
    `waited_ms` may have been spent waiting for a processor: that is no queue of the link.
    """

    sent_bytes: int
    carried_bytes: int
    waiting_bytes: int
    delay_ms: float
    round_trip_ms: float
    overdue_ms: float
    held_back: bool = False
    waited_ms: float = 0.0


@dataclass(frozen=True, slots=True)
class _Sent:
    """One picture: its number, its bytes, when it was exposed and when sent."""

    seq: int
    size: int
    capture_ns: int
    sent_ns: int


class SentPictures:
    """The pictures sent of one camera; bytes count as carried once a picture sent with or after them has come.

    Where buffers are full pictures are dropped on the way: of the bytes only the fraction counts that came of the last
    second's pictures.

    `reference_bytes` is what a JPEG of quality 80 at full size takes, None before the first; `pixels` are those of a
    full picture, and `sent_ns` is when the last one was sent.
    """

    def __init__(self) -> None:
        self.reference_bytes: float | None = None
        self.pixels: int | None = None
        self.sent_ns = self._last_bytes = 0
        self._waiting: deque[_Sent] = deque(maxlen=MOST_WAITING)
        self.forget()

    def forget(self) -> None:
        """Another console reports, or none: nothing that the last one has shown counts any more."""
        self._newest: _Sent | None = None
        self._passed_ns: deque[int] = deque(maxlen=MOST_WAITING)  # told times may stand still
        self._sent_bytes = 0
        self._held_back = False

    def send(self, frame: VideoFrame, setting: StreamSetting, now_ns: int) -> None:
        """A picture of this setting went out."""
        size = self._last_bytes = len(frame.data)
        self._waiting.append(_Sent(frame.seq, size, frame.capture_ns, now_ns))
        self.sent_ns, self.pixels = now_ns, round(frame.width * frame.height / setting.scale**2)
        self._sent_bytes += size
        if frame.codec is not Codec.JPEG:
            return
        reference = size / setting.relative_bytes
        known = reference if self.reference_bytes is None else self.reference_bytes
        self.reference_bytes = known + SMOOTHING * (reference - known)

    def hold_back(self) -> None:
        """A picture would have gone out now, but the last one still waits in this host."""
        self._held_back = True
        self._sent_bytes += self._last_bytes

    def come(self, came: ViewCame, told_ns: int) -> Arrivals | None:
        """Take in what a console reported at a time of this camera; None where that is about no picture known here."""
        is_first, carried = self._newest is None, 0
        while self._waiting and self._waiting[0].seq <= came.seq:
            self._newest = self._waiting.popleft()
            carried += self._newest.size
            self._passed_ns.append(told_ns)
        if self._newest is None or came.seq < self._newest.seq:
            return None
        if is_first:
            self._sent_bytes = carried = 0  # some of it was sent before the console was there
            self._passed_ns.clear()
        newest, (sent, self._sent_bytes) = self._newest, (self._sent_bytes, 0)
        held_back, self._held_back = self._held_back, False
        told_ns = max(told_ns, newest.sent_ns)  # nobody tells of a picture before it was sent
        on_their_way = [one for one in self._waiting if one.sent_ns <= told_ns]
        return Arrivals(
            sent_bytes=sent,
            carried_bytes=round(carried * self._share(came.fps, told_ns)),
            waiting_bytes=sum(one.size for one in on_their_way),
            delay_ms=came.age_ms - (newest.sent_ns - newest.capture_ns) / NS_PER_MS,
            round_trip_ms=(told_ns - newest.sent_ns) / NS_PER_MS,
            overdue_ms=(told_ns - on_their_way[0].sent_ns) / NS_PER_MS if on_their_way else 0.0,
            held_back=held_back,
        )

    def _share(self, came_fps: float, told_ns: int) -> float:
        """Compute the fraction of the last second's pictures that has come, if this is how many came in a second."""
        while self._passed_ns and self._passed_ns[0] <= told_ns - NS_PER_S:
            self._passed_ns.popleft()
        passed = len(self._passed_ns)
        return came_fps / passed if came_fps < ALL_CAME * passed else 1.0


def together(arrivals: Sequence[Arrivals], waited_ms: float = 0.0) -> Arrivals:
    """All cameras as one: sums of bytes, medians of times, so that one late camera is not a late link.

    `waited_ms` is for how long the hosts have lately kept the pictures waiting for a processor.
    """
    return Arrivals(
        sum(one.sent_bytes for one in arrivals),
        sum(one.carried_bytes for one in arrivals),
        sum(one.waiting_bytes for one in arrivals),
        statistics.median(one.delay_ms for one in arrivals),
        statistics.median(one.round_trip_ms for one in arrivals),
        statistics.median(one.overdue_ms for one in arrivals),
        any(one.held_back for one in arrivals),
        waited_ms,
    )
