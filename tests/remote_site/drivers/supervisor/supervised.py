"""A supervisor around a kinematic robot that can be given faults, and control that plans towards a goal."""

from collections.abc import Callable
from dataclasses import replace
from typing import Self

import numpy as np

from common.clock import NS_PER_MS, FakeClock
from common.geometry import Array
from common.messages.robot import GripperCommand
from remote_site.drivers.driver import Capabilities, DriverSetup, GripperReading, JointCommand, RobotReading
from remote_site.drivers.faults import RobotFault
from remote_site.drivers.kinematic import KinematicDriver
from remote_site.drivers.supervisor.grip import GripSettings, GripWatch
from remote_site.drivers.supervisor.orders import DriverOrder
from remote_site.drivers.supervisor.supervisor import DriverSupervisor
from remote_site.kinematics.joints import JointMotion
from remote_site.motion.jerk_limited import JerkLimitedTracker
from tests.remote_site.remote_loop import arm

MODEL, LIMITS = arm()
DT = 0.004
START = np.radians([0.0, 0.0, -45.0, 0.0, -45.0, 0.0])
SETUP = DriverSetup(MODEL.joint_names, LIMITS, DT, 50 * NS_PER_MS, start=START)


class TroubledRobot(KinematicDriver):
    """A kinematic robot that can be given faults, and that keeps what was written."""

    def __init__(self, clock: FakeClock, rate_hz: float, lag_ms: float, *, holds: bool) -> None:
        super().__init__(clock)
        self.fake_clock, self.rate_hz, self.lag_ms, self.holds = clock, rate_hz, lag_ms, holds
        self.written: list[JointCommand] = []
        self.trouble: RobotFault | None = None
        self.opening_m: float | None = None
        self.raises: dict[str, BaseException] = {}  # by the name of the call
        self.slow_ms, self.stops, self.activations, self.off_rad = 0.0, 0, 0, 0.0
        self.spoil: Callable[[RobotReading], RobotReading] = lambda reading: reading

    @property
    def capabilities(self) -> Capabilities:
        return Capabilities(
            self.rate_hz, None, gripper=True, force=False, watchdog_ms=None, lag_ms=self.lag_ms, holds=self.holds
        )

    def activate(self, q0: Array) -> None:
        self.activations += 1
        self._raise("activate")
        super().activate(q0 + self.off_rad)

    def read(self) -> RobotReading:
        self.fake_clock.advance_ms(self.slow_ms)
        self._raise("read")
        reading = super().read()
        gripper = GripperReading(self.opening_m, None) if self.opening_m is not None else None
        return self.spoil(replace(reading, gripper=gripper, fault=self.trouble or reading.fault))

    def write(self, command: JointCommand) -> JointCommand:
        self._raise("write")
        self.written.append(command)
        return super().write(command)

    def stop(self) -> None:
        self.stops += 1
        self._raise("stop")
        super().stop()

    def _raise(self, call: str) -> None:
        if call in self.raises:
            raise self.raises[call]


class Mark:
    """Keeps every mark of a call's begin and end."""

    def __init__(self) -> None:
        self.seen: list[int] = []

    def set(self, since_ns: int) -> None:
        self.seen.append(since_ns)


class Supervised:
    """A supervised robot on stepped time, and control that plans towards a goal."""

    def __init__(self, rate_hz: float = 1000.0, lag_ms: float = 0.0, *, holds: bool = False) -> None:
        self.clock = FakeClock(1_000 * NS_PER_MS)
        self.robot, self.mark = TroubledRobot(self.clock, rate_hz, lag_ms, holds=holds), Mark()
        self.robot.configure(SETUP)
        self.supervisor = DriverSupervisor(self.robot, SETUP, self.clock, self.mark, GripWatch(GripSettings()))
        self.tracker = JerkLimitedTracker(LIMITS, DT)
        self.activation = self.seq = 0
        self.sent = JointMotion.at_rest(START)

    @property
    def motion(self) -> JointMotion:
        """What is commanded now."""
        return self.supervisor.commanded.motion

    @property
    def stop_count(self) -> int:
        return self.supervisor.commanded.stop_count

    def fault(self) -> RobotFault:
        """The fault, which there is."""
        assert self.supervisor.fault is not None
        return self.supervisor.fault

    def turn(self, *orders: DriverOrder, ms: float = 2.0) -> None:
        """One turn of the driver's process after `ms`."""
        self.clock.advance_ms(ms)
        self.supervisor.take(orders, self.clock.now_ns())
        self.supervisor.step(self.clock.now_ns())

    def turns(self, count: int) -> None:
        for _ in range(count):
            self.turn()

    def activate(self, q: Array = START) -> Self:
        self.activation += 1
        self.sent = JointMotion.at_rest(q)
        self.turn(self.order(self.sent))
        return self

    def order(
        self, motion: JointMotion, *, run: bool = True, gripper: GripperCommand = GripperCommand.KEEP
    ) -> DriverOrder:
        self.seq += 1
        command = JointCommand(self.seq, self.clock.now_ns(), motion.q, motion.dq, motion.ddq, gripper)
        return DriverOrder(self.activation, run, self.stop_count, command)

    def plan(self) -> JointMotion:
        """The next tick's motion from what was sent, towards the first joint at 0.8 rad."""
        goal = START.copy()
        goal[0] += 0.8
        self.tracker.reset(self.sent)
        planned = self.tracker.track(JointMotion.at_rest(goal))
        assert isinstance(planned, JointMotion)
        return planned

    def command(self, motion: JointMotion | None = None, *, gripper: GripperCommand = GripperCommand.KEEP) -> None:
        """One tick of control and the turn that its order causes."""
        self.sent = motion or self.plan()
        self.clock.advance_ms(4)
        self.turn(self.order(self.sent, gripper=gripper), ms=0)

    def commands(self, count: int) -> None:
        for _ in range(count):
            self.command()

    def stop_at(self, ms: float = 0.0) -> JointMotion:
        """Where the stop under way is `ms` from now."""
        stop = self.supervisor.commanded.stop
        assert stop is not None
        return stop.at(self.clock.now_ns() + round(ms * NS_PER_MS))

    def stumble(self, ms: float) -> None:
        """Control is silent for this long, the driver's process continues."""
        while ms > 0:
            self.turn(ms=min(ms, 2.0))
            ms -= 2.0

    def moving(self, ticks: int = 60) -> Self:
        """Activated, and the first joint above 1 rad/s."""
        self.activate().commands(ticks)
        assert self.motion.dq[0] > 1.0
        return self


def assert_smooth(robot: TroubledRobot) -> None:
    """What was written is within the limits, by the times of the commands."""
    t = np.array([c.t_ns for c in robot.written]) / 1e9
    q, dq, ddq = (np.array([getattr(c, key) for c in robot.written]) for key in ("q", "dq", "ddq"))
    steps = np.diff(t)[:, None]
    assert (np.abs(dq) <= LIMITS.velocity * 1.0001).all()
    assert (np.abs(ddq) <= LIMITS.acceleration * 1.0001).all()
    assert (np.abs(np.diff(ddq, axis=0)) <= LIMITS.jerk * steps * 1.001 + 1e-9).all()
    assert (np.abs(np.diff(q, axis=0)) <= LIMITS.velocity * steps * 1.0001).all()
