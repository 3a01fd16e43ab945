"""Stands for the conformance suite on a clock moved by hand, with the robots stepped along."""

from collections.abc import Callable

import msgspec

from common.clock import FakeClock
from common.geometry import Array
from lab.stage.stepped.robots import BEGIN_NS, SteppedCell, SteppedClock, SteppedController, SteppedRobot
from remote_site.config import RemoteConfig
from remote_site.drivers.c500c.emulator import Emulated
from remote_site.drivers.conformance.trial import DriverStand
from remote_site.drivers.driver import Driver
from remote_site.drivers.kinematic import KinematicDriver
from remote_site.kinematics.config import RobotConfig
from remote_site.runtime.driver_process import setup_of

CONFIG = RemoteConfig()
SETUP = setup_of(CONFIG)


def kinematic_stand(
    make: Callable[[FakeClock], Driver] = KinematicDriver, robot: RobotConfig = CONFIG.robot
) -> DriverStand:
    clock = FakeClock(BEGIN_NS)
    return DriverStand(clock, SETUP, lambda: make(clock), robot.start)


def simulated_stand(robot: RobotConfig = CONFIG.robot) -> DriverStand:
    return _stepped(SteppedCell(msgspec.structs.replace(CONFIG, robot=robot)), robot.start)


def c500c_stand(loss: float = 0.0, robot: RobotConfig = CONFIG.robot) -> DriverStand:
    return _stepped(SteppedController(msgspec.structs.replace(CONFIG, robot=robot), Emulated(), loss), robot.start)


def _stepped(robot: SteppedRobot, start: Array) -> DriverStand:
    clock = SteppedClock(robot)
    return DriverStand(clock, SETUP, lambda: robot.driver(clock), start)
