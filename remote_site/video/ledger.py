"""What was sent of one camera, what of it has come to the console, and how old that was. Pure."""

from collections import deque
from dataclasses import dataclass

from common.clock import NS_PER_S
from common.messages.video import ViewCame
from remote_site.video.carrying import News

MOST_COMING = 256
AGE_BUCKET_NS = 2 * NS_PER_S
AGE_BUCKETS = 10
SMOOTHING = 0.3
TOO_OLD_MS = 250.0  # late, however old the quickest are: a link that was full at first shows no quick ones


@dataclass(frozen=True, slots=True)
class _Sent:
    seq: int
    size: int


class Ledger:
    """One camera's account; bytes count as carried once a picture sent with or after them has come.

    `reference_bytes` is what a picture of quality 80 at full size takes, None before the first; `sent_ns` is when the
    last one was sent.
    """

    def __init__(self) -> None:
        self.reference_bytes: float | None = None
        self.sent_ns = 0
        self._coming: deque[_Sent] = deque(maxlen=MOST_COMING)
        self._least_ages: deque[tuple[int, float]] = deque(maxlen=AGE_BUCKETS)
        self._come_seq = -1
        self._sent_bytes = 0

    def send(self, seq: int, size: int, relative_bytes: float, now_ns: int) -> None:
        """A picture of `size` bytes went out, made by a setting whose pictures are so large beside the reference."""
        self._coming.append(_Sent(seq, size))
        self.sent_ns = now_ns
        self._sent_bytes += size
        reference = size / relative_bytes
        known = reference if self.reference_bytes is None else self.reference_bytes
        self.reference_bytes = known + SMOOTHING * (reference - known)

    def come(self, came: ViewCame, now_ns: int) -> News | None:
        """The news of this camera; None when nothing new has come."""
        if came.seq <= self._come_seq:
            return None
        self._come_seq = came.seq
        carried, sent, self._sent_bytes = 0, self._sent_bytes, 0
        while self._coming and self._coming[0].seq <= came.seq:
            carried += self._coming.popleft().size
        least_ms, waiting = self._least_age(came.age_ms, now_ns), sum(one.size for one in self._coming)
        return News(sent, carried, waiting, max(came.age_ms - least_ms, came.age_ms - TOO_OLD_MS), least_ms)

    def forget(self) -> None:
        """Another console reports, or none: nothing that it has shown counts any more."""
        self._coming.clear()
        self._least_ages.clear()
        self._come_seq = -1
        self._sent_bytes = 0

    def _least_age(self, age_ms: float, now_ns: int) -> float:
        """The least age of the last twenty seconds: what the way takes when nothing waits."""
        bucket = now_ns // AGE_BUCKET_NS
        while self._least_ages and self._least_ages[0][0] <= bucket - AGE_BUCKETS:
            self._least_ages.popleft()
        if self._least_ages and self._least_ages[-1][0] == bucket:
            self._least_ages[-1] = (bucket, min(age_ms, self._least_ages[-1][1]))
        else:
            self._least_ages.append((bucket, age_ms))
        return min(age for _, age in self._least_ages)
