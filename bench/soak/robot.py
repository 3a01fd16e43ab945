"""The robots of the soak on stepped time, and what goes wrong with them: calls that raise or are late, and faults."""

from collections.abc import Callable
from dataclasses import dataclass, field, replace
from random import Random

from common.clock import NS_PER_MS, FakeClock
from common.errors import DriverError
from common.geometry import Array
from remote_site.config import RemoteConfig
from remote_site.drivers.c500c.config import C500cConfig
from remote_site.drivers.c500c.driver import C500cDriver
from remote_site.drivers.c500c.emulation import EmulatedPort, Emulation
from remote_site.drivers.c500c.emulator import EmulatedController
from remote_site.drivers.driver import Capabilities, Driver, DriverSetup, JointCommand, RobotReading
from remote_site.drivers.faults import FaultCode, RobotFault
from remote_site.drivers.kinematic import KinematicDriver
from remote_site.drivers.simulated import SimulatedDriver
from remote_site.kinematics.joints import JointMotion
from remote_site.simulation.memory import CellMemory
from remote_site.simulation.process import SimulatedCell

BEGIN_NS = 1000 * NS_PER_MS
CALLS_PER_TROUBLE = 3000  # on average; a robot is called about a thousand times a second


class SteppedCellClock(FakeClock):
    """A clock that steps a simulated cell as time passes."""

    def __init__(self, cell: SimulatedCell) -> None:
        super().__init__(BEGIN_NS)
        self._cell, self._stepped_ns, self._step_ns = cell, BEGIN_NS, round(cell.dt * 1e9)

    def sleep_until_ns(self, deadline_ns: int) -> None:
        """Step the cell as often as its period requires."""
        while self._stepped_ns + self._step_ns <= deadline_ns:
            self._stepped_ns += self._step_ns
            self.time_ns = max(self.time_ns, self._stepped_ns)
            self._cell.step(self._stepped_ns, self._stepped_ns)
        super().sleep_until_ns(deadline_ns)


def kinematic(config: RemoteConfig) -> tuple[FakeClock, Driver]:
    """A robot that is where it was commanded."""
    del config
    clock = FakeClock(BEGIN_NS)
    return clock, KinematicDriver(clock)


def simulated(config: RemoteConfig) -> tuple[FakeClock, Driver]:
    """The simulated cell."""
    memory = CellMemory.create(len(config.robot.start_deg))
    clock = SteppedCellClock(SimulatedCell(config.simulation, config.robot, memory))
    return clock, SimulatedDriver(memory, clock)


def c500c(config: RemoteConfig) -> tuple[FakeClock, Driver]:
    """The A465's controller, emulated, on a line that loses one byte in ten thousand."""
    clock = FakeClock(BEGIN_NS)
    port = EmulatedPort(Emulation(EmulatedController(config.robot.start), clock.now_ns(), loss=1e-4), clock)
    return clock, C500cDriver(C500cConfig(), port, clock)


@dataclass
class Received:
    """The commands that a driver received: time in ns, motion, and in which activation."""

    t_ns: list[int] = field(default_factory=list)
    motions: list[JointMotion] = field(default_factory=list)
    activations: list[int] = field(default_factory=list)


class FaultInjectingDriver:
    """A `Driver` around another, with random faults; `received` keeps the commands for the wrapped one.

    `block` lets time pass for the rest of the world while a call is late.
    """

    def __init__(self, driver: Driver, rng: Random, clock: FakeClock, block: Callable[[int], None]) -> None:
        self._driver, self._rng, self._clock, self._block = driver, rng, clock, block
        self._fault_until_ns = 0
        self.received, self.activations = Received(), 0
        self.troubles = {"raises": 0, "late": 0, "fault": 0}
        self.blocked: list[tuple[int, int]] = []

    @property
    def capabilities(self) -> Capabilities:
        """Those of the wrapped driver."""
        return self._driver.capabilities

    def configure(self, setup: DriverSetup) -> None:
        """Pass it on."""
        self._driver.configure(setup)

    def activate(self, q0: Array) -> None:
        """Pass it on; commands continue from `q0`."""
        self._driver.activate(q0)
        self.activations += 1

    def read(self) -> RobotReading:
        """The reading, or a fault."""
        self._inject()
        reading = self._driver.read()
        if reading.fault is None and self._clock.now_ns() < self._fault_until_ns:
            return replace(reading, fault=RobotFault(FaultCode.EMERGENCY_STOP, "pressed"))
        return reading

    def write(self, command: JointCommand) -> JointCommand:
        """Note the command at the call, and pass it on, unless a fault comes first."""
        received = self.received
        received.t_ns.append(self._clock.now_ns())
        received.motions.append(command.motion)
        received.activations.append(self.activations)
        self._inject()
        return self._driver.write(command)

    def stop(self) -> None:
        """Pass it on; later commands belong to another motion."""
        self.activations += 1
        self._driver.stop()

    def deactivate(self) -> None:
        """Pass it on."""
        self._driver.deactivate()

    def _inject(self) -> None:
        if self._rng.random() * CALLS_PER_TROUBLE > 1.0:
            return
        trouble = self._rng.choices(list(self.troubles), [1, 8, 1])[0]
        self.troubles[trouble] += 1
        if trouble == "late":
            since_ns = self._clock.now_ns()
            self._block(since_ns + round(self._rng.uniform(1, 60) * NS_PER_MS))
            self.blocked.append((since_ns, self._clock.now_ns()))
        elif trouble == "fault":
            self._fault_until_ns = self._clock.now_ns() + round(self._rng.uniform(1, 400) * NS_PER_MS)
        else:
            raise self._rng.choice([DriverError("the line is cut"), ValueError("out of order"), KeyError("axis")])
