"""State of the grip: done as commanded, holding an object, or without an answer; pure."""

from dataclasses import dataclass

from common.clock import NS_PER_MS
from common.messages.robot import GripperCommand, GripperState, GripperStatus
from remote_site.drivers.driver import GripperReading

STILL_M = 0.0006  # apparent motion of a gripper at rest
STILL_NS = 150 * NS_PER_MS
AT_REST = frozenset({GripperStatus.OPEN, GripperStatus.CLOSED, GripperStatus.HOLDING})
MAY_BE_THERE = {  # what a gripper was before it is commanded, that it need not move
    GripperCommand.OPEN: (None, GripperStatus.UNKNOWN, GripperStatus.OPEN),
    GripperCommand.CLOSED: (None, GripperStatus.UNKNOWN, GripperStatus.CLOSED, GripperStatus.HOLDING),
}


@dataclass(frozen=True, slots=True)
class GripSettings:
    """Below `closed_m` the gripper is closed, above `open_m` open; it may take `timeout_ns`.

    A gripper at rest whose measured force is `held_n` or more holds an object, unless it is closed.
    """

    closed_m: float = 0.003
    open_m: float = 0.045
    timeout_ns: int = 2000 * NS_PER_MS
    held_n: float = 2.5


class GripWatch:
    """Watches the measured opening after each command: stable but not closed means that an object is held.

    The real gripper may report too early that it has finished, so the opening is watched until it is stable. A
    gripper that does not come to rest in time, or does not open, has timed out. With KEEP nothing can time out: what
    the last command has reached remains true until the opening changes, and otherwise opening and force alone decide;
    what they do not show is unknown.
    """

    def __init__(self, settings: GripSettings) -> None:
        self._settings = settings
        self._command = GripperCommand.KEEP
        self._before: GripperStatus | None = None  # when the command was given
        self._moved = False  # since then
        self._since_ns = self._still_ns = 0
        self._still_m: float | None = None
        self.state: GripperState | None = None  # of the last reading, None without one

    def observe(self, reading: GripperReading | None, now_ns: int, command: GripperCommand) -> None:
        """Update the state with a reading of the gripper, if there is one, and what it is commanded to do."""
        if reading is None:
            self.state, self._still_m = None, None
            return
        if command is not self._command:
            self._command, self._since_ns, self._moved = command, now_ns, False
            self._before = self.state.status if self.state is not None else None
            self._still_ns = now_ns
        if self._still_m is None:
            self._still_ns, self._still_m = now_ns, reading.opening_m
        elif abs(reading.opening_m - self._still_m) > STILL_M:
            self._still_ns, self._still_m, self._moved = now_ns, reading.opening_m, True
        status = self._kept(reading, now_ns) if command is GripperCommand.KEEP else self._reached(reading, now_ns)
        self.state = GripperState(reading.opening_m, reading.force_n, command, status)

    def _kept(self, reading: GripperReading, now_ns: int) -> GripperStatus:
        """The status without a command in force."""
        if self._before in AT_REST and not self._moved:
            return self._before
        if now_ns - self._still_ns < STILL_NS:
            return GripperStatus.MOVING
        if reading.opening_m <= self._settings.closed_m:
            return GripperStatus.CLOSED
        if reading.force_n is not None and reading.force_n >= self._settings.held_n:
            return GripperStatus.HOLDING
        return GripperStatus.OPEN if reading.opening_m >= self._settings.open_m else GripperStatus.UNKNOWN

    def _reached(self, reading: GripperReading, now_ns: int) -> GripperStatus:
        """Tell how far the command to open or to close has been executed."""
        opens = self._command is GripperCommand.OPEN
        answered = self._moved or self._before in MAY_BE_THERE[self._command]
        settled = answered and now_ns - self._still_ns >= STILL_NS
        if settled and opens and reading.opening_m >= self._settings.open_m:
            return GripperStatus.OPEN
        if settled and not opens:
            return GripperStatus.CLOSED if reading.opening_m <= self._settings.closed_m else GripperStatus.HOLDING
        late = now_ns - self._since_ns > self._settings.timeout_ns
        return GripperStatus.TIMED_OUT if late else GripperStatus.MOVING
