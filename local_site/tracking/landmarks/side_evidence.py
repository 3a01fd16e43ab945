"""Evidence of the hand's side, right or left: what all views have shown over the last instants."""

from collections import deque
from statistics import fmean

REMEMBERED = 30  # instants: a wrong run of one view lasts five at most
ENOUGH, ENOUGH_IF_CLEAR = 8, 3
SURE, CLEAR = 0.05, 0.3  # from undecided


class SideEvidence:
    """The mean of what speaks for the operator's side, from 0, the other one, to 1."""

    def __init__(self) -> None:
        self._seen: deque[float] = deque(maxlen=REMEMBERED)

    def add(self, for_side: float) -> None:
        """Take what one instant shows."""
        self._seen.append(for_side)

    @property
    def is_sure(self) -> bool:
        """Return whether enough has been seen to take the hand for the operator's."""
        beyond = fmean(self._seen) - 0.5 if self._seen else 0.0
        return beyond > SURE and len(self._seen) >= (ENOUGH_IF_CLEAR if beyond > CLEAR else ENOUGH)

    @property
    def is_other(self) -> bool:
        """Return whether enough has been seen to take it for the other hand."""
        return len(self._seen) >= ENOUGH_IF_CLEAR and fmean(self._seen) < 0.5

    def forget(self) -> None:
        """Begin again with another hand."""
        self._seen.clear()
