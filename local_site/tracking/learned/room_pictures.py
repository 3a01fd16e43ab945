"""Which pictures show the room without the arm: those before the first hand, but for the last, in which it came in."""

from collections import deque

from local_site.tracking.tracker import Views

COMES_IN = 8  # pairs in which an arm may be in the pictures before its hand is found
WANTED = 30  # about a second


class RoomPictures:
    """Holds pairs of pictures back until they are certainly without an arm."""

    def __init__(self) -> None:
        self._held: deque[Views] = deque()
        self._taken = 0

    @property
    def is_learning(self) -> bool:
        """Whether more pictures of the room are wanted."""
        return self._taken < WANTED

    def take(self, views: Views) -> Views | None:
        """Take a pair without a hand; one that is old enough, while more are wanted."""
        if not self.is_learning:
            return None
        self._held.append(views)
        if len(self._held) <= COMES_IN:
            return None
        self._taken += 1
        return self._held.popleft()

    def forget(self) -> None:
        """Drop what is held: an arm has come in."""
        self._held.clear()
