"""The one operating page among those that watch, and whether its key and its clutch are held."""

from dataclasses import dataclass

from common.clock import NS_PER_MS, NS_PER_S
from common.messages.clutch_latch import ClutchLatch
from common.messages.hand import ClutchKey

BEAT_TIMEOUT_NS = 200 * NS_PER_MS
MOST_AGE_NS = 400 * NS_PER_MS  # of the newest word of the console's that a page had heard when it sent a beat
ABANDONED_NS = 5 * NS_PER_S  # of silence, after which another page may take the seat


@dataclass(frozen=True, slots=True)
class Visitor:
    """A page that is connected: its number since the console started, and the address that it came from."""

    number: int
    address: str

    def __str__(self) -> str:
        return f"page {self.number} ({self.address})"


@dataclass(frozen=True, slots=True)
class SeatAnswer:
    """The answer to a request for the seat, with a sentence for the page."""

    done: bool
    sentence: str


class Seat:
    """Gives the seat to the first page, and to another only when it is given up, closed or silent for 5 s.

    Once an operator has given it up, nobody has it before a page takes it: not everybody who opens one operates.

    Holding counts while the operating page beats at least every 200 ms, and for 400 ms at most after the time of the
    console that it had heard by then: the way of a beat is part of that, so a key that was released is not held longer,
    however late all beats come. After any silence, a stop or a change of the page it counts only once the key was seen
    released. A clutch that was held then stays so, unseen, whichever page operates next. Where `open_` is false no page
    ever operates.
    """

    def __init__(self, *, open_: bool) -> None:
        self._open = open_
        self._beat_ns: int | None = None
        self._heard_ns: int | None = None
        self._down = self._released = False
        self._assist: str | None = None
        self._clutch = ClutchLatch()
        self._given_up = False
        self.occupant: Visitor | None = None

    def arrive(self, visitor: Visitor, now_ns: int) -> None:
        """A page has connected; it operates if no other page does, and nobody has given up the seat."""
        if self.occupant is None and not self._given_up:
            self.take(visitor, now_ns)

    def take(self, visitor: Visitor, now_ns: int) -> SeatAnswer:
        """Take the seat, or get the name of the page that has it."""
        if not self._open:
            return SeatAnswer(False, "this console only watches: it was started with operate = false")
        if self.occupant is not None and self.occupant != visitor and not self._abandoned(now_ns):
            return SeatAnswer(False, f"{self.occupant} operates; it has to leave the controls or be closed first")
        if self.occupant != visitor:
            self._sit(visitor, now_ns)
        return SeatAnswer(True, "this page operates")

    def leave(self, visitor: Visitor) -> SeatAnswer:
        """Give up the seat; no effect for a page that does not have it."""
        if self.occupant == visitor:
            self._sit(None, None)
            self._given_up = True
        return SeatAnswer(True, "this page only watches")

    def go(self, visitor: Visitor) -> None:
        """A page is gone, as when it is closed or loaded again; no effect for one that does not have the seat."""
        if self.occupant == visitor:
            self._sit(None, None)

    def beat(
        self,
        visitor: Visitor,
        now_ns: int,
        heard_ns: int | None,
        *,
        down: bool,
        assist: str | None = None,
        clutch: ClutchKey = ClutchKey.UP,
    ) -> None:
        """A page's heartbeat, with whether key and clutch are down, and the target for which it asks for the assist.

        `heard_ns` is the console's time that the page had heard when it sent this; None before it has heard any, when
        the beat is not older than the page's stay.
        """
        if visitor != self.occupant:
            return
        self._lapse(now_ns)
        self._beat_ns, self._down, self._assist = now_ns, down, assist
        if heard_ns is not None:
            self._heard_ns = min(heard_ns, now_ns)
        self._released = self._released or not down
        if clutch is not ClutchKey.UP or not self._is_late(now_ns):
            self._clutch.see(clutch)
        self._lapse(now_ns)

    def interrupt(self) -> None:
        """After a stop the key has to be pressed again."""
        self._released = False

    def reports(self, now_ns: int) -> bool:
        """Return whether a page operates and beats, early enough to count."""
        return self.occupant is not None and not self._is_silent(now_ns) and not self._is_late(now_ns)

    def late(self, now_ns: int) -> bool:
        """Return whether the operating page beats, but so late that it does not count."""
        return self.occupant is not None and not self._is_silent(now_ns) and self._is_late(now_ns)

    def heard_ago_ns(self, now_ns: int) -> int:
        """Return how old the console's newest word is that the operating page has answered, ns; 0 without a page."""
        return now_ns - self._heard_ns if self._heard_ns is not None else 0

    def silent_ns(self, now_ns: int) -> int:
        """Return how long ago the operating page's last beat came, ns; 0 without a page."""
        return now_ns - self._beat_ns if self._beat_ns is not None else 0

    def held(self, now_ns: int) -> bool:
        """Return whether the operating page holds its key at this instant."""
        self._lapse(now_ns)
        return self._down and self._released

    def assisted(self, now_ns: int) -> str | None:
        """The target for which the operating page holds the key of fine adjustment at this instant."""
        self._lapse(now_ns)
        return self._assist

    def clutch(self, now_ns: int) -> ClutchKey:
        """The clutch of the operating page at this instant."""
        self._lapse(now_ns)
        return self._clutch.key

    def _sit(self, visitor: Visitor | None, now_ns: int | None) -> None:
        self.occupant, self._beat_ns, self._heard_ns, self._assist = visitor, now_ns, now_ns, None
        self._down = self._released = self._given_up = False
        self._clutch.interrupt()

    def _lapse(self, now_ns: int) -> None:
        if self._is_silent(now_ns) or self._is_late(now_ns):
            self._released = self._down = False
            self._assist = None
            self._clutch.interrupt()

    def _abandoned(self, now_ns: int) -> bool:
        return self.silent_ns(now_ns) > ABANDONED_NS

    def _is_silent(self, now_ns: int) -> bool:
        return self.silent_ns(now_ns) > BEAT_TIMEOUT_NS

    def _is_late(self, now_ns: int) -> bool:
        return self._heard_ns is None or self.heard_ago_ns(now_ns) > MOST_AGE_NS
