"""Stands for the conformance suite on a clock moved by hand, with the robots stepped along."""

from collections.abc import Callable

from common.clock import NS_PER_MS, FakeClock
from remote_site.config import RemoteConfig
from remote_site.drivers.c500c.config import C500cConfig
from remote_site.drivers.c500c.driver import C500cDriver
from remote_site.drivers.c500c.emulation import EmulatedPort, Emulation
from remote_site.drivers.c500c.emulator import EmulatedController
from remote_site.drivers.conformance.trial import DriverStand
from remote_site.drivers.driver import Driver
from remote_site.drivers.kinematic import KinematicDriver
from remote_site.drivers.simulated import SimulatedDriver
from remote_site.kinematics.config import RobotConfig
from remote_site.runtime.driver_process import setup_of
from remote_site.simulation.memory import CellMemory
from remote_site.simulation.process import SimulatedCell

CONFIG = RemoteConfig()
SETUP = setup_of(CONFIG)
STEP_NS = 2 * NS_PER_MS


class CellClock(FakeClock):
    """A clock that takes a simulated cell along."""

    def __init__(self, cell: SimulatedCell) -> None:
        super().__init__(NS_PER_MS * 1000)
        self.cell = cell

    def sleep_until_ns(self, deadline_ns: int) -> None:
        while self.time_ns < deadline_ns:
            self.time_ns += STEP_NS
            self.cell.step(self.time_ns, self.time_ns)


def kinematic_stand(
    make: Callable[[FakeClock], Driver] = KinematicDriver, robot: RobotConfig = CONFIG.robot
) -> DriverStand:
    clock = FakeClock(NS_PER_MS * 1000)
    return DriverStand(clock, SETUP, lambda: make(clock), robot.start)


def simulated_stand(robot: RobotConfig = CONFIG.robot) -> DriverStand:
    memory = CellMemory.create(6)
    clock = CellClock(SimulatedCell(CONFIG.simulation, robot, memory))
    return DriverStand(clock, SETUP, lambda: SimulatedDriver(memory, clock), robot.start)


def c500c_stand(loss: float = 0.0, robot: RobotConfig = CONFIG.robot) -> DriverStand:
    clock = FakeClock(NS_PER_MS * 1000)
    emulation = Emulation(EmulatedController(robot.start), clock.now_ns(), loss=loss)
    port = EmulatedPort(emulation, clock)
    return DriverStand(clock, SETUP, lambda: C500cDriver(C500cConfig(), port, clock), robot.start)
