"""How far a run has come on its path: in steps or through, back too, standing where the gripper acts; pure."""

from enum import StrEnum

from common.geometry import Array
from common.messages.robot import GripperCommand, GripperState, GripperStatus
from local_site.programmed.path_clock import NEAR_S, PathClock
from local_site.programmed.tool_trajectory import GripperAction, ToolTrajectory

DONE = {
    GripperCommand.OPEN: (GripperStatus.OPEN,),
    GripperCommand.CLOSED: (GripperStatus.CLOSED, GripperStatus.HOLDING),
}
SLOWEST, FASTEST, FASTER = 0.1, 2.0, 1.25
PAUSED = "paused: p goes on, n to the next way point"
SETTLE_S = 0.6  # the arm comes to rest before the gripper acts


class RunOrder(StrEnum):
    """What the operator may order of a run besides holding the key."""

    PAUSE = "pause"
    NEXT = "next"
    BACK = "back"
    FASTER = "faster"
    SLOWER = "slower"


class PathProgress:
    """Where a run stands on its path, at `speed` times the path's own; `stepwise` stops at each way point.

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
        """Whether the whole path lies behind."""
        return self._clock.t_s >= self._path.duration_s and self._due == len(self._path.actions)

    @property
    def target(self) -> Array:
        """The tool's pose (4 x 4) where the run stands."""
        return self._path.base_T_tool(self._clock.t_s)

    @property
    def grips(self) -> bool:
        """Whether the gripper acts anywhere on the path."""
        return bool(self._path.actions)

    @property
    def acts(self) -> bool:
        """Whether the tool has come to rest where the gripper acts."""
        return self._rested_s >= SETTLE_S

    @property
    def way_point(self) -> int:
        """The number of the way point, from 1, that it has come from."""
        return sum(mark <= self._clock.t_s + NEAR_S for mark in self._path.marks)

    @property
    def way_points(self) -> int:
        """How many way points the path has."""
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
        """The arm does not follow: stand at once, and come to rest anew before the gripper acts."""
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
