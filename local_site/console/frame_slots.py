"""The frames that wait for one page: the newest of each view, sent only as fast as the page takes them; pure."""

from dataclasses import dataclass

IN_FLIGHT = 2  # one on its way while the other is painted; more would be a queue


@dataclass(frozen=True, slots=True)
class ViewFrame:
    """One picture on its way to a page: its view, its number, and the bytes as they are sent."""

    view: str
    seq: int
    payload: bytes


class FrameSlots:
    """Holds one frame per view; a newer one replaces it, and views take turns."""

    def __init__(self) -> None:
        self._waiting: dict[str, ViewFrame] = {}
        self._sent: dict[str, int] = {}
        self.dropped = 0

    def offer(self, frame: ViewFrame) -> None:
        """Take a frame; the one of this view that still waited is dropped."""
        self.dropped += frame.view in self._waiting
        self._waiting[frame.view] = frame

    def take(self) -> ViewFrame | None:
        """The next frame that may be sent now, None when nothing waits or the page is behind with all that wait."""
        ready = [view for view in self._sent if view in self._waiting and self._sent[view] < IN_FLIGHT]
        fresh = [view for view in self._waiting if view not in self._sent]
        if not ready and not fresh:
            return None
        view = (fresh or ready)[0]
        self._sent[view] = self._sent.pop(view, 0) + 1  # to the end: the view sent last comes last
        return self._waiting.pop(view)

    def taken(self, view: str) -> None:
        """The page has painted a frame of this view, or passed it over."""
        if self._sent.get(view, 0) > 0:
            self._sent[view] -= 1
