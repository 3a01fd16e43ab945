"""Which hand samples the robot obeys, and when each has reached its motion, however late; pure."""

from collections import deque

import msgspec

from common.messages import Obeyed

WAITING = 64  # samples on their way at most: two seconds of them


class ObeyedSamples:
    """Keeps the samples that were commanded until the motion shows them: a slow robot lags behind by several."""

    def __init__(self) -> None:
        self._newest: Obeyed | None = None
        self._moved: Obeyed | None = None
        self._waiting: deque[tuple[int, Obeyed]] = deque(maxlen=WAITING)

    def commanded(self, sample: Obeyed, command_seq: int) -> None:
        """A sample, by the first command that obeys it."""
        self._newest = sample
        self._waiting.append((command_seq, sample))

    def reached(self, command_seq: int | None, t_ns: int) -> None:
        """The newest command that the robot's motion shows, as measured at `t_ns`."""
        while command_seq is not None and self._waiting and self._waiting[0][0] <= command_seq:
            _, sample = self._waiting.popleft()
            self._moved = msgspec.structs.replace(sample, motion_ns=t_ns)
            if sample is self._newest:
                self._newest = self._moved

    def told(self) -> Obeyed | None:
        """What the next state says: a sample whose motion has become known, once; otherwise the newest."""
        moved, self._moved = self._moved, None
        return moved or self._newest
