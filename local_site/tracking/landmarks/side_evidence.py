"""Which hand it is, a right or a left one, by what all views have shown over the last instants."""

from collections import deque
from statistics import fmean

REMEMBERED = 15  # instants: a wrong run of one view lasts five at most
ENOUGH, ENOUGH_IF_CLEAR = 8, 3
CLEAR = 0.3  # from undecided


class SideEvidence:
    """The mean of what the views say, from 0, a left hand, to 1, a right one."""

    def __init__(self) -> None:
        self._seen: deque[float] = deque(maxlen=REMEMBERED)

    def add(self, right: float) -> None:
        """Take what the views of one instant say."""
        self._seen.append(right)

    @property
    def right(self) -> float | None:
        """The mean so far, None before it can be trusted."""
        if not self._seen:
            return None
        mean = fmean(self._seen)
        needed = ENOUGH_IF_CLEAR if abs(mean - 0.5) > CLEAR else ENOUGH
        return mean if len(self._seen) >= needed else None

    def supports(self, right_arm: bool) -> bool:
        """Whether this may be a hand of that arm; true also while too little has been seen."""
        right = self.right
        return right is None or (right > 0.5) == right_arm

    def forget(self) -> None:
        """Begin again with another hand."""
        self._seen.clear()
