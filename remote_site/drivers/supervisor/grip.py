"""Whether the gripper has done what was commanded, holds an object, or does not answer; pure."""

from dataclasses import dataclass

from common.clock import NS_PER_MS
from common.messages.robot import GripperState, GripperStatus
from remote_site.drivers.driver import GripperReading

STILL_M = 0.0006  # apparent motion of a gripper at rest
STILL_NS = 150 * NS_PER_MS


@dataclass(frozen=True, slots=True)
class GripSettings:
    """Below `closed_m` the gripper is closed, above `open_m` open; it may take `timeout_ns`."""

    closed_m: float = 0.003
    open_m: float = 0.045
    timeout_ns: int = 2000 * NS_PER_MS


class GripWatch:
    """Watches the measured opening after each command: stable but not closed means that an object is held.

    The real gripper may report too early that it has finished, so the opening is watched until it is stable. A
    gripper that does not come to rest in time, or does not open, has timed out.
    """

    def __init__(self, settings: GripSettings) -> None:
        self._settings = settings
        self._wanted_open: bool | None = None
        self._moved = True  # at the start it may already be where it is wanted
        self._since_ns = self._still_ns = 0
        self._still_m = 0.0
        self.state: GripperState | None = None  # of the last reading, None before the first

    def observe(self, reading: GripperReading, now_ns: int, *, wanted_open: bool) -> None:
        """Update the state with a reading of the gripper and what it is commanded to do."""
        status = self.judge(now_ns, reading.opening_m, wanted_open=wanted_open)
        self.state = GripperState(reading.opening_m, reading.force_n, wanted_open, status)

    def judge(self, now_ns: int, opening_m: float, *, wanted_open: bool) -> GripperStatus:
        """The status at `now_ns` of a gripper of this opening that was commanded to open or to close."""
        if wanted_open is not self._wanted_open:
            self._moved = self._wanted_open is None
            self._wanted_open, self._since_ns = wanted_open, now_ns
            self._still_ns, self._still_m = now_ns, opening_m
        if abs(opening_m - self._still_m) > STILL_M:
            self._still_ns, self._still_m, self._moved = now_ns, opening_m, True
        settled = self._moved and now_ns - self._still_ns >= STILL_NS
        if settled and not (wanted_open and opening_m < self._settings.open_m):
            return self._reached(opening_m)
        late = now_ns - self._since_ns > self._settings.timeout_ns
        return GripperStatus.TIMED_OUT if late else GripperStatus.MOVING

    def _reached(self, opening_m: float) -> GripperStatus:
        if self._wanted_open:
            return GripperStatus.OPEN
        return GripperStatus.CLOSED if opening_m <= self._settings.closed_m else GripperStatus.HOLDING
