"""The scripted hand before real cameras: a little of its path is always under way to them, and cannot be taken back."""

import threading

from common.clock import NS_PER_MS, NS_PER_S
from common.geometry import Array
from lab.visual_operator.at_console.led_pose import LedPose
from lab.visual_operator.hand import Motor, ScriptedHand

AHEAD_NS, STEP_NS = 150 * NS_PER_MS, 10 * NS_PER_MS
MOST_POSES = 64  # at once


class FilmedHand(ScriptedHand):
    """A scripted hand that begins nothing before what has been taken of its path; for two threads.

    Its seconds count from `start_ns`. `late` counts how often its path was taken after the last pose was over.
    """

    def __init__(self, motor: Motor, seed: int, start_ns: int) -> None:
        super().__init__(motor, seed)
        self._start_ns, self._taken_ns = start_ns, start_ns - STEP_NS
        self._lock = threading.Lock()
        self.late = 0

    def move(self, start_s: float, offset: Array, turn: Array) -> float:
        """Begin a movement then, or as soon as it can; when it ends, s."""
        with self._lock:
            return super().move(max(start_s, self._taken_s), offset, turn)

    def open_at(self, start_s: float) -> float:
        """Open the hand then, or as soon as it can, and close it; when it is closed again, s."""
        with self._lock:
            return super().open_at(max(start_s, self._taken_s))

    def take(self, now_ns: int) -> list[LedPose]:
        """The next poses of its path, until a little after now."""
        with self._lock:
            self.late += self._start_ns < self._taken_ns < now_ns
            poses: list[LedPose] = []
            while self._taken_ns < now_ns + AHEAD_NS and len(poses) < MOST_POSES:
                self._taken_ns += STEP_NS
                poses.append(self._pose(self._taken_ns))
            return poses

    @property
    def _taken_s(self) -> float:
        return (self._taken_ns - self._start_ns) / NS_PER_S

    def _pose(self, t_ns: int) -> LedPose:
        t_s = (t_ns - self._start_ns) / NS_PER_S
        offset, turn, openness = self.at(t_s)
        (x, y, z), (u, v, w), openings = offset.tolist(), turn.tolist(), self.openings_until(t_s)
        return LedPose(t_ns=t_ns, offset=(x, y, z), turn=(u, v, w), openness=openness, openings=openings)
