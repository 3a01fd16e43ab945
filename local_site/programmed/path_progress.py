"""Progress of a run on its path: in steps or through, back too, standing where the gripper acts; pure."""

import math
from enum import StrEnum

from common.geometry import Array
from common.messages.robot import GripperCommand, GripperState, GripperStatus
from local_site.programmed.tool_trajectory import GripperAction, ToolTrajectory

DONE = {
    GripperCommand.OPEN: (GripperStatus.OPEN,),
    GripperCommand.CLOSED: (GripperStatus.CLOSED, GripperStatus.HOLDING),
}
SLOWEST, FASTEST, FASTER = 0.1, 2.0, 1.25
PAUSED = "paused: p goes on, n to the next way point"
SETTLE_S = 0.6  # the arm comes to rest before the gripper acts
ACCELERATION_PER_S = 4.0  # of the path's time: a quarter of a second from rest to the path's own speed
NEAR_S = 1e-3
LEAST_RATE = 0.02  # the last way to a stop does not take for ever


class PathClock:
    """The path's time `t_s`, which goes on by `rate` seconds a second, below 0 backwards."""

    def __init__(self) -> None:
        self.t_s = self.rate = 0.0

    def begin(self, t_s: float) -> None:
        """Stand at a time of the path."""
        self.t_s, self.rate = t_s, 0.0

    def advance(self, elapsed_s: float, speed: float, stop_at_s: float | None) -> bool:
        """Go on for `elapsed_s` towards `stop_at_s`, at most `speed` times as fast as the path; whether it is there.

        Without a place to stop at, the path's time slows down and stands.
        """
        wanted = 0.0 if stop_at_s is None else self._towards(stop_at_s, speed)
        most = ACCELERATION_PER_S * elapsed_s
        self.rate += min(max(wanted - self.rate, -most), most)
        before_s, self.t_s = self.t_s, self.t_s + self.rate * elapsed_s
        if stop_at_s is None:
            return False
        passed = (before_s - stop_at_s) * (self.t_s - stop_at_s) <= 0.0
        if passed or abs(self.t_s - stop_at_s) < NEAR_S:
            self.t_s, self.rate = stop_at_s, 0.0
            return True
        return False

    def _towards(self, stop_at_s: float, speed: float) -> float:
        """The rate from which the time can still come to rest at `stop_at_s`."""
        left_s = stop_at_s - self.t_s
        return math.copysign(min(speed, max(math.sqrt(ACCELERATION_PER_S * abs(left_s)), LEAST_RATE)), left_s)


class RunOrder(StrEnum):
    """The operator's orders to a run besides holding the key."""

    PAUSE = "pause"
    NEXT = "next"
    BACK = "back"
    FASTER = "faster"
    SLOWER = "slower"


class PathProgress:
    """The place of a run on its path, at `speed` times the path's own; `stepwise` stops at each way point.

    `why` says in words why it stands, empty while it goes on.
    """

    def __init__(self, path: ToolTrajectory, speed: float, *, stepwise: bool) -> None:
        self._path, self.speed, self._stepwise = path, speed, stepwise
        self._clock = PathClock()
        self.begin()

    def begin(self) -> None:
        """Stand at the path's beginning."""
        self._clock.begin(0.0)
        self._due = 0
        self._rested_s = 0.0
        self._paused, self._mark, self.why = False, self._next_mark() if self._stepwise else None, ""

    @property
    def is_done(self) -> bool:
        """Return whether the whole path lies behind."""
        return self._clock.t_s >= self._path.duration_s and self._due == len(self._path.actions)

    @property
    def target(self) -> Array:
        """The tool's pose (4 x 4) where the run stands."""
        return self._path.base_T_tool(self._clock.t_s)

    @property
    def grips(self) -> bool:
        """Return whether the gripper acts anywhere on the path."""
        return bool(self._path.actions)

    @property
    def acts(self) -> bool:
        """Return whether the tool has come to rest where the gripper acts."""
        return self._rested_s >= SETTLE_S

    @property
    def way_point(self) -> int:
        """The number of the way point, from 1, that it has come from."""
        return sum(mark <= self._clock.t_s + NEAR_S for mark in self._path.marks)

    @property
    def way_points(self) -> int:
        """Return how many way points the path has."""
        return len(self._path.marks)

    def order(self, order: RunOrder) -> None:
        """Do what the operator orders; at a path's end there is nothing to go on to."""
        if order in (RunOrder.FASTER, RunOrder.SLOWER):
            factor = FASTER if order is RunOrder.FASTER else 1.0 / FASTER
            self.speed = min(max(self.speed * factor, SLOWEST), FASTEST)
        elif order is RunOrder.PAUSE:
            self._paused = not self._paused
            self._mark = self._next_mark() if self._stepwise else None
        else:
            self._paused, self._rested_s = False, 0.0
            self._mark = self._next_mark() if order is RunOrder.NEXT else self._last_mark()
            if order is RunOrder.BACK:
                self._due = sum(action.t_s < self._mark - NEAR_S for action in self._path.actions)

    def stand(self) -> None:
        """The arm does not follow: stand at once, and come to rest again before the gripper acts."""
        self._clock.begin(self._clock.t_s)
        self._rested_s = 0.0

    def advance(self, elapsed_s: float, gripper: GripperState | None, hindered: str) -> GripperCommand | None:
        """Go on for `elapsed_s`, unless the arm is hindered; what the gripper is to do now, None for nothing."""
        self.why = hindered or (PAUSED if self._paused else "")
        if self.why:
            self._clock.advance(elapsed_s, self.speed, None)
            return None
        action = self._path.actions[self._due] if self._due < len(self._path.actions) else None
        ends = [stop_s for stop_s in (self._mark, action.t_s if action else None) if stop_s is not None]
        backwards = self._mark is not None and self._mark < self._clock.t_s
        stop_s = self._mark if backwards else min([*ends, self._path.duration_s])
        is_there = self._clock.advance(elapsed_s, self.speed, stop_s)
        if is_there and action is not None and stop_s == action.t_s and not backwards:
            return self._act(action, elapsed_s, gripper)
        if is_there and stop_s == self._mark:
            self._paused, self._mark = not self.is_done, None
        return None

    def _act(self, action: GripperAction, elapsed_s: float, gripper: GripperState | None) -> GripperCommand | None:
        """Rest, command, wait for the gripper, dwell; then the path goes on."""
        self.why = f"the gripper is to be {action.command.value}"
        if not self.acts:
            self._rested_s += elapsed_s
            return None
        if not _has_done(gripper, action.command):
            self._rested_s = SETTLE_S
            return action.command
        self._rested_s += elapsed_s
        if self._rested_s >= SETTLE_S + action.dwell_s:
            self._due, self._rested_s = self._due + 1, 0.0
        return None

    def _next_mark(self) -> float:
        later = [mark for mark in self._path.marks if mark > self._clock.t_s + NEAR_S]
        return min([*later, self._path.duration_s])

    def _last_mark(self) -> float:
        earlier = [mark for mark in self._path.marks if mark < self._clock.t_s - NEAR_S]
        return max([*earlier, 0.0])


def _has_done(gripper: GripperState | None, command: GripperCommand) -> bool:
    if gripper is None or gripper.commanded not in (command, GripperCommand.KEEP):
        return False
    return gripper.status in DONE.get(command, ())
