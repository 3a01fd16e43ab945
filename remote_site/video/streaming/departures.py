"""Cameras whose pictures have waited in this host for too long: another one behind them would only come old."""

from collections import defaultdict, deque

from common.clock import NS_PER_MS
from remote_site.video.streaming.link_rate import LATE_MS

FRAMING_BYTES = 512  # of a message beside its picture, at most: key, names, numbers, encryption
LATE_NS = round(LATE_MS * NS_PER_MS)


class Departures:
    """The bytes put of each camera and when, against what the transport has not sent yet.

    TCP keeps what its congestion control does not let go, up to hundreds of kB. While it pauses, pictures that are put
    wait one behind the other, and come all at once and late, when they overflow the next router's queue. So pictures
    are left out while an earlier one of the camera is late already, and the one that goes then is new. A shorter queue
    may stand: from one that is empty the congestion control would learn only how little is sent.
    """

    def __init__(self) -> None:
        self._put_bytes = 0
        self._young: defaultdict[str, deque[tuple[int, int]]] = defaultdict(deque)
        self._late_end: defaultdict[str, int] = defaultdict(int)

    def put(self, camera: str, picture_bytes: int, now_ns: int) -> None:
        """A picture of a camera was given to the transport."""
        self._put_bytes += picture_bytes + FRAMING_BYTES
        self._young[camera].append((now_ns, self._put_bytes))

    def waits(self, camera: str, unsent_bytes: int, now_ns: int) -> bool:
        """Return whether a picture that the camera put so long ago is not wholly sent, by what is unsent of all."""
        young = self._young[camera]
        while young and young[0][0] <= now_ns - LATE_NS:
            self._late_end[camera] = young.popleft()[1]
        return unsent_bytes > self._put_bytes - self._late_end[camera]
