"""The soak test's robots on stepped time, and a driver that injects exceptions, late calls and faults into theirs."""

from collections.abc import Callable
from dataclasses import dataclass, field, replace
from random import Random

from common.clock import NS_PER_MS, FakeClock
from common.errors import DriverError
from common.geometry import Array
from lab.stage.stepped.robots import BEGIN_NS, SteppedCell, SteppedClock, SteppedController, SteppedRobot
from remote_site.config import RemoteConfig
from remote_site.drivers.c500c.emulator import Emulated
from remote_site.drivers.driver import Capabilities, Driver, DriverSetup, JointCommand, RobotReading
from remote_site.drivers.faults import FaultCode, RobotFault
from remote_site.drivers.kinematic import KinematicDriver
from remote_site.kinematics.joints import JointMotion

CALLS_PER_INJECTION = 3000  # on average; a driver is called about a thousand times a second


def kinematic(config: RemoteConfig) -> tuple[FakeClock, Driver]:
    """An ideal robot, always where it was commanded."""
    del config
    clock = FakeClock(BEGIN_NS)
    return clock, KinematicDriver(clock)


def simulated(config: RemoteConfig) -> tuple[FakeClock, Driver]:
    """The robot of the simulated cell."""
    return _stepped(SteppedCell(config))


def c500c(config: RemoteConfig) -> tuple[FakeClock, Driver]:
    """The A465 arm behind an emulated C500C controller, on a serial line that loses one byte in ten thousand."""
    return _stepped(SteppedController(config, Emulated(), loss=1e-4))


def _stepped(robot: SteppedRobot) -> tuple[FakeClock, Driver]:
    clock = SteppedClock(robot)
    return clock, robot.driver(clock)


@dataclass
class Received:
    """The commands that a driver received: time in ns, motion, and the segment of motion that each belongs to."""

    t_ns: list[int] = field(default_factory=list)
    motions: list[JointMotion] = field(default_factory=list)
    segments: list[int] = field(default_factory=list)


class FaultInjectingDriver:
    """A `Driver` around another that injects faults at random; `received` keeps every command written to it.

    `block` runs the rest of the world until a time in ns, as a late call does; `blocked` keeps the beginning and end in
    ns of each. An activation and a stop each begin a new `segment` of motion.
    """

    def __init__(self, driver: Driver, rng: Random, clock: FakeClock, block: Callable[[int], None]) -> None:
        self._driver, self._rng, self._clock, self._block = driver, rng, clock, block
        self._fault_until_ns = 0
        self.received, self.segment = Received(), 0
        self.injected = {"raises": 0, "late": 0, "fault": 0}
        self.blocked: list[tuple[int, int]] = []

    @property
    def capabilities(self) -> Capabilities:
        """The wrapped driver's."""
        return self._driver.capabilities

    def configure(self, setup: DriverSetup) -> None:
        """Forward it."""
        self._driver.configure(setup)

    def activate(self, q0: Array) -> None:
        """Forward it; commands from here on continue from `q0` (n,) in rad."""
        self._driver.activate(q0)
        self.segment += 1

    def read(self) -> RobotReading:
        """The wrapped driver's reading, unless a fault is injected."""
        self._inject()
        reading = self._driver.read()
        if reading.fault is None and self._clock.now_ns() < self._fault_until_ns:
            return replace(reading, fault=RobotFault(FaultCode.EMERGENCY_STOP, "pressed"))
        return reading

    def write(self, command: JointCommand) -> JointCommand:
        """Record the command, and forward it unless an exception is injected first."""
        received = self.received
        received.t_ns.append(self._clock.now_ns())
        received.motions.append(command.motion)
        received.segments.append(self.segment)
        self._inject()
        return self._driver.write(command)

    def stop(self) -> None:
        """Forward it; commands after it belong to another segment."""
        self.segment += 1
        self._driver.stop()

    def deactivate(self) -> None:
        """Forward it."""
        self._driver.deactivate()

    def _inject(self) -> None:
        if self._rng.random() * CALLS_PER_INJECTION > 1.0:
            return
        kind = self._rng.choices(list(self.injected), [1, 8, 1])[0]
        self.injected[kind] += 1
        if kind == "late":
            since_ns = self._clock.now_ns()
            self._block(since_ns + round(self._rng.uniform(1, 60) * NS_PER_MS))
            self.blocked.append((since_ns, self._clock.now_ns()))
        elif kind == "fault":
            self._fault_until_ns = self._clock.now_ns() + round(self._rng.uniform(1, 400) * NS_PER_MS)
        else:
            raise self._rng.choice([DriverError("the line is cut"), ValueError("out of order"), KeyError("axis")])
