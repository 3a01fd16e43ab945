"""Watches the robot: its connection, made again when it is lost, its newest state, and the time of that."""

from collections.abc import Callable

from common.clock import NS_PER_MS, NS_PER_S, Clock
from common.errors import DriverError
from remote_site.drivers.franka.robot_port import ArmState, MotionPort, RobotPort, UnreachableError

AGAIN_NS = NS_PER_S
SPAN_NS = 50 * NS_PER_MS
LEAP_NS = 20 * NS_PER_MS  # of one state's time beyond all that came before it: by itself it is wrong


class RobotTime:
    """Follows the offset between both clocks: the least of this span of time and of the one before it.

    The robot counts its own time in ms. A state cannot arrive before it was measured, so the least difference between
    arrival and the robot's time, over the last tenth of a second, is where its zero lies by the host's clock: late by
    the quickest transit, a fraction of a ms on a cable. The span is short because two clocks differ in rate, and a
    simulator's may stand still now and then.
    """

    def __init__(self) -> None:
        self._before_ns: int | None = None
        self._least_ns: int | None = None
        self._since_ns = 0
        self._stamp_ns = 0
        self._leapt = False

    def stamp(self, robot_ns: int, arrival_ns: int) -> int:
        """Compute when a state was measured, ns by the host's clock; never after it came, never before the last one.

        One whose time lies far ahead is no newer than the last; where the next one's does too, the robot's time has
        begun again.
        """
        offset_ns = arrival_ns - robot_ns
        self._leapt = not self._leapt and self._least_ns is not None and offset_ns < self._least_ns - LEAP_NS
        if self._leapt:
            return self._stamp_ns
        if self._least_ns is None or arrival_ns - self._since_ns > SPAN_NS:
            self._before_ns, self._least_ns, self._since_ns = self._least_ns, offset_ns, arrival_ns
        self._least_ns = min(self._least_ns, offset_ns)
        least_ns = self._least_ns if self._before_ns is None else min(self._least_ns, self._before_ns)
        self._stamp_ns = max(self._stamp_ns, robot_ns + least_ns)
        return self._stamp_ns


class RobotWatch:
    """To be read: the newest `state`, None before the first, and `stamp_ns`, when it was measured."""

    def __init__(self, connect: Callable[[], RobotPort], clock: Clock) -> None:
        self._connect, self._clock = connect, clock
        self._robot: RobotPort | None = None
        self._time = RobotTime()
        self.state: ArmState | None = None
        self.stamp_ns = 0

    def connected(self) -> RobotPort:
        """The robot; UnreachableError where there is no connection."""
        if self._robot is None:
            self._robot = self._connect()
        return self._robot

    def read(self, port: RobotPort | MotionPort) -> ArmState:
        """The robot's next state."""
        self.state = port.read()
        self.stamp_ns = self._time.stamp(self.state.t_ns, self._clock.now_ns())
        return self.state

    def forget(self) -> None:
        """The connection is lost: the next one is a new one, with a time of its own."""
        self._robot, self._time = None, RobotTime()

    def wait(self) -> None:
        """Wait until it is time to try to connect again."""
        self._clock.sleep_until_ns(self._clock.now_ns() + AGAIN_NS)


def connected_once(connect: Callable[[], RobotPort]) -> Callable[[], RobotPort]:
    """A connection whose first failure ends the process with its sentence; after a later one it is tried again."""
    seen = False

    def again() -> RobotPort:
        nonlocal seen
        try:
            robot = connect()
        except UnreachableError as error:
            if seen:
                raise
            raise DriverError(str(error)) from error
        seen = True
        return robot

    return again
