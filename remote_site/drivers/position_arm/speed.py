"""Joint speeds from positions alone: the difference over a window of time; pure."""

from collections import deque

from common.clock import NS_PER_S
from common.geometry import Array


class SpeedOverWindow:
    """The mean speed since the newest positions that are at least `window_ns` old.

    That is the difference smoothed by a moving average: it shows the speed of half a window ago, and passes changes
    of it up to 0.44 / window (-3 dB). One count of an encoder more or less changes it by a count per window, at most.
    """

    def __init__(self, window_ns: int) -> None:
        self._window_ns = window_ns
        self._measured: deque[tuple[int, Array]] = deque()

    def add(self, t_ns: int, q: Array) -> Array | None:
        """The speeds (n,) in rad/s at new positions (n,) in rad; None until they cover a window.

        `t_ns` is later than at the last call.
        """
        measured = self._measured
        measured.append((t_ns, q))
        while len(measured) > 1 and measured[1][0] <= t_ns - self._window_ns:
            measured.popleft()
        first_ns, first = measured[0]
        if t_ns - first_ns < self._window_ns:
            return None
        speeds: Array = (q - first) * (NS_PER_S / (t_ns - first_ns))
        return speeds
