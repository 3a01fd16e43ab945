"""When the simulated operator began to move: one time that several processes share, unset until it is known."""

import mmap

import numpy as np

from common.clock import NS_PER_S

UNSET = -1


class Beginning:
    """The beginning of the motion, ns; processes forked later see it as soon as it is set."""

    def __init__(self) -> None:
        self._t_ns = np.frombuffer(mmap.mmap(-1, 8), np.int64)
        self._t_ns[0] = UNSET

    def set(self, t_ns: int) -> None:
        """The motion begins at this time; it begins only once."""
        if self._t_ns[0] == UNSET:
            self._t_ns[0] = t_ns

    def elapsed_s(self, t_ns: int) -> float:
        """How long the operator has been moving at a time, s: zero before the beginning."""
        begun_ns = int(self._t_ns[0])
        return 0.0 if begun_ns == UNSET else max(0.0, (t_ns - begun_ns) / NS_PER_S)
