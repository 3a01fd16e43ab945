"""The path of the tool's target: where it was predicted of late, and all samples before; pure."""

from collections import deque

import numpy as np

from common.clock import NS_PER_S
from common.geometry import Array

MOST_SAMPLES = 1024  # more than the longest delay's, also of cameras at 120 Hz
NARROWEST_S, WIDEST_S, WIDENED = 0.06, 0.15, 0.4  # of what is averaged about a place: of the delay, within bounds
ENOUGH = 1.25  # times the way to the second sample on either side, so that a parabola is determined
PREDICTED = 2.5  # sample intervals, within which the path goes over from predictions to samples
LEARNED = 0.1  # of a new interval
FIRST_INTERVAL_S = 1 / 30


class TargetPath:
    """Poses (6,) of the tool, position in m and rotation vector in rad, by the hand's time."""

    def __init__(self, dt: float) -> None:
        self._dt = dt
        self.clear()

    def clear(self) -> None:
        """Forget all."""
        self._samples: deque[tuple[int, Array]] = deque(maxlen=MOST_SAMPLES)
        self._predicted: deque[tuple[Array, Array]] = deque(maxlen=round(1.0 / self._dt))
        self._interval_s = FIRST_INTERVAL_S

    def add(self, t_ns: int, pose: Array) -> None:
        """Take a sample (6,); one that is not later than the last is left out."""
        if self._samples and t_ns <= self._samples[-1][0]:
            return
        if self._samples:
            interval_s = min((t_ns - self._samples[-1][0]) / NS_PER_S, 1.0)
            self._interval_s += LEARNED * (interval_s - self._interval_s)
        self._samples.append((t_ns, pose))

    def predict(self, pose: Array, rate: Array) -> None:
        """Take what is predicted (6,) for this tick, and its rate (6,) per s."""
        self._predicted.append((pose, rate))

    def at(self, hand_ns: int, delay_s: float) -> tuple[Array, Array]:
        """Compute the pose (6,) and its rate (6,) a time before the one predicted last, which is of `hand_ns`.

        Predictions overshoot where the hand turns. So the longer the delay, the more samples count instead, and the
        more of them are averaged.
        """
        pose, rate = self._predicted_at(delay_s)
        share = min(delay_s / (PREDICTED * self._interval_s), 1.0)
        averaged = self._averaged(hand_ns - round(delay_s * NS_PER_S), delay_s) if share > 0.0 else None
        if averaged is None:
            return pose, rate
        return (1.0 - share) * pose + share * averaged[0], (1.0 - share) * rate + share * averaged[1]

    def _predicted_at(self, delay_s: float) -> tuple[Array, Array]:
        newest = len(self._predicted) - 1
        before = min(delay_s / self._dt, float(newest))
        k, part = int(before), before % 1.0
        (pose, rate), (earlier, earlier_rate) = self._predicted[newest - k], self._predicted[max(newest - k - 1, 0)]
        return pose + part * (earlier - pose), rate + part * (earlier_rate - rate)

    def _averaged(self, t_ns: int, delay_s: float) -> tuple[Array, Array] | None:
        """A parabola through the samples about a time, nearer ones counting more; None where there are too few."""
        after = self._first_after(t_ns)
        if after < 2 or after > len(self._samples) - 1:
            return None
        later = min(after + 1, len(self._samples) - 1)
        second_s = max(t_ns - self._samples[after - 2][0], self._samples[later][0] - t_ns) / NS_PER_S
        width = max(ENOUGH * second_s, min(max(NARROWEST_S, WIDENED * delay_s), WIDEST_S))
        around = [(t, pose) for t, pose in self._around(after) if abs(t - t_ns) < width * NS_PER_S]
        since = np.array([(t - t_ns) / NS_PER_S for t, _ in around])
        weight = (1.0 - (since / width) ** 2) ** 2
        powers = since ** np.arange(3)[:, None]  # (3, k)
        weighted = weight * powers
        found = np.linalg.solve(weighted @ powers.T, weighted @ np.array([pose for _, pose in around]))
        return found[0], found[1]

    def _first_after(self, t_ns: int) -> int:
        """The number of the first sample after a time; as many as there are if none is."""
        k = len(self._samples)
        while k > 0 and self._samples[k - 1][0] > t_ns:
            k -= 1
        return k

    def _around(self, k: int) -> list[tuple[int, Array]]:
        reach = max(2, round(WIDEST_S / max(self._interval_s, self._dt)) + 2)
        return [self._samples[i] for i in range(max(k - reach, 0), min(k + reach, len(self._samples)))]
