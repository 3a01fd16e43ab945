"""Arms that take positions, on a simulated servo: good ones, and ones that are bad in one thing each."""

import math
from collections.abc import Callable

import numpy as np

from common.clock import NS_PER_MS, NS_PER_S, Clock, FakeClock
from common.geometry import Array
from remote_site.drivers.conformance.trial import DriverStand
from remote_site.drivers.driver import DriverSetup
from remote_site.drivers.position_arm.arm import MeasuredPositions, PositionArm, PositionArmWithGripper, Positions
from remote_site.drivers.position_arm.driver import PositionArmDriver
from remote_site.kinematics.joints import JointMotion
from remote_site.safety.stopping import stopping
from tests.contracts.driver_stands import CONFIG, SETUP

LAG_S = 0.02


class ServoArm(PositionArm):
    """Goes to its goal with a lag of the first order; it cannot brake, only hold."""

    joints = 6
    rate_hz = 100.0
    lag_ms = 3000 * LAG_S
    writes_stop = True

    lag_s = LAG_S

    def __init__(self, clock: Clock) -> None:
        self.clock, self.calls = clock, list[str]()
        self.q = self.goal = np.array(CONFIG.robot.start)
        self._moved_ns = clock.now_ns()

    def read(self) -> Positions | MeasuredPositions | None:
        self.calls.append("read")
        self.move()
        return self.q

    def write(self, positions: Array) -> None:
        self.calls.append("write")
        self.move()
        self.goal = positions

    def stop(self) -> None:
        self.calls.append("stop")
        self.move()
        self.goal = self.q

    def close(self) -> None:
        self.calls.append("close")

    def move(self) -> None:
        """Let the arm move until now."""
        now_ns = self.clock.now_ns()
        elapsed_s, self._moved_ns = (now_ns - self._moved_ns) / NS_PER_S, now_ns
        self.q = self.goal + (self.q - self.goal) * math.exp(-elapsed_s / self.lag_s)


class BrakingArm(ServoArm):
    """Brakes by itself, within the limits that it was configured with."""

    writes_stop = False

    def configure(self, setup: DriverSetup) -> None:
        self._limits = setup.limits
        self._speed = np.zeros(6)
        self._stop: tuple[JointMotion, int] | None = None

    def write(self, positions: Array) -> None:
        self._speed = (positions - self.goal) * self.rate_hz
        self._stop = None
        super().write(positions)

    def stop(self) -> None:
        self.calls.append("stop")
        if self._stop is None:
            self._stop = JointMotion(self.goal, self._speed, np.zeros(6)), self.clock.now_ns()

    def move(self) -> None:
        if self._stop is not None:
            motion, since_ns = self._stop
            self.goal = stopping(motion, self._limits, (self.clock.now_ns() - since_ns) / NS_PER_S).q
        super().move()


class GripperArm(ServoArm, PositionArmWithGripper):
    """Has a gripper that moves at 0.1 m/s, found half open."""

    goal_m = opening_m = 0.04
    opened_ns = 0
    most_n = 0.0

    def open_gripper(self) -> None:
        self.calls.append("open")
        self.goal_m = 0.08

    def close_gripper(self, most_n: float) -> None:
        self.calls.append("close_gripper")
        self.goal_m, self.most_n = 0.0, most_n

    def gripper_opening_m(self) -> float | None:
        now_ns, before_ns = self.clock.now_ns(), self.opened_ns or self.clock.now_ns()
        step_m, self.opened_ns = 0.1 * (now_ns - before_ns) / NS_PER_S, now_ns
        self.opening_m += float(np.clip(self.goal_m - self.opening_m, -step_m, step_m))
        return self.opening_m


class Stamped(ServoArm):
    """Is measured every 20 ms, and gives the time of that."""

    newest: MeasuredPositions | None = None

    def read(self) -> Positions | MeasuredPositions | None:
        super().read()
        now_ns = self.clock.now_ns()
        if self.newest is None or now_ns - self.newest.t_ns >= 20 * NS_PER_MS:
            self.newest = MeasuredPositions(self.q, now_ns)
        return self.newest


class StampedEarly(ServoArm):
    """Stamps what it measures with a time of long before, as a call does that takes 80 ms."""

    rate_hz, lag_ms = 25.0, 160.0

    def read(self) -> Positions | MeasuredPositions | None:
        super().read()
        return MeasuredPositions(self.q, self.clock.now_ns() - 80 * NS_PER_MS)


class Sparing(Stamped):
    """The same, and says that nothing is new."""

    given: MeasuredPositions | None = None

    def read(self) -> Positions | MeasuredPositions | None:
        before = self.newest
        super().read()
        return self.newest.q if self.newest is not before and self.newest is not None else None


class Frozen(ServoArm):
    """Reads what it has read first, as from a link that is dead."""

    first: Array | None = None

    def read(self) -> Positions | MeasuredPositions | None:
        super().read()
        self.first = self.q if self.first is None else self.first
        return self.first


class Silent(ServoArm):
    """Has nothing new any more once it was commanded."""

    def read(self) -> Positions | MeasuredPositions | None:
        return None if "write" in self.calls else super().read()


class NotANumber(ServoArm):
    """Loses a joint."""

    def read(self) -> Positions | MeasuredPositions | None:
        super().read()
        return np.where(np.arange(6) == 2, math.nan, self.q)


class OneShort(ServoArm):
    """Reads five of its six joints."""

    def read(self) -> Positions | MeasuredPositions | None:
        super().read()
        return self.q[:5]


class InDegrees(ServoArm):
    """Reads and takes degrees."""

    def read(self) -> Positions | MeasuredPositions | None:
        super().read()
        return np.degrees(self.q)

    def write(self, positions: Array) -> None:
        super().write(np.radians(positions))


class Speechless(ServoArm):
    """Cannot be read."""

    def read(self) -> Positions | MeasuredPositions | None:
        raise ConnectionError("no answer from 10.0.0.7")


class Unwritable(ServoArm):
    """Cannot be commanded."""

    def write(self, positions: Array) -> None:
        raise OSError(5, f"lost {len(positions)} values")


class Late(ServoArm):
    """Follows a tenth of a second later than it declares."""

    def __init__(self, clock: Clock) -> None:
        super().__init__(clock)
        self._waiting: list[tuple[int, Array]] = []

    def write(self, positions: Array) -> None:
        self._waiting.append((self.clock.now_ns() + NS_PER_S // 10, positions))

    def read(self) -> Positions | MeasuredPositions | None:
        while self._waiting and self._waiting[0][0] <= self.clock.now_ns():
            super().write(self._waiting.pop(0)[1])
        return super().read()


class Gliding(BrakingArm):
    """Goes on at its last speed when nothing is written, and its stop does nothing."""

    def stop(self) -> None:
        return

    def move(self) -> None:
        elapsed_s = (self.clock.now_ns() - self._moved_ns) / NS_PER_S
        self.goal = self.goal + getattr(self, "_speed", 0.0) * elapsed_s
        super().move()


class Waiting(ServoArm):
    """Waits 10 ms for its robot in each call, on a clock that this moves."""

    wait_ms = 10.0

    def read(self) -> Positions | MeasuredPositions | None:
        self.clock.sleep_until_ns(self.clock.now_ns() + round(self.wait_ms * NS_PER_MS))
        return super().read()

    def write(self, positions: Array) -> None:
        self.clock.sleep_until_ns(self.clock.now_ns() + round(self.wait_ms * NS_PER_MS))
        super().write(positions)


class StopsHard(ServoArm):
    """Holds where it is at once, and says that this is a stop."""

    writes_stop = False


class StopsNothing(ServoArm):
    """Says that it brakes, and goes on to where it was sent last, as hard as it can."""

    writes_stop = False
    lag_s = 0.002

    def stop(self) -> None:
        return


class CannotStop(ServoArm):
    """Its stop fails."""

    writes_stop = False

    def stop(self) -> None:
        raise NotImplementedError("stop")


class Jumpy(ServoArm):
    """Flickers by more than its speeds are smoothed."""

    rng = np.random.default_rng(7)

    def read(self) -> Positions | MeasuredPositions | None:
        super().read()
        return self.q + self.rng.normal(0.0, 0.004, 6)


def position_stand(make: Callable[[Clock], PositionArm]) -> DriverStand:
    """A stand whose arm is one and the same, for each driver."""
    clock = FakeClock(NS_PER_S)
    arm = make(clock)
    return DriverStand(clock, SETUP, lambda: PositionArmDriver(arm, clock), CONFIG.robot.start)
