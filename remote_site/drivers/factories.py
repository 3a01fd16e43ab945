"""Makes Farhand's own drivers, as the entry points in pyproject.toml name them."""

from common.errors import DriverError
from remote_site.drivers.driver import Driver
from remote_site.drivers.registry import DriverHost, check_options


def kinematic(host: DriverHost) -> Driver:
    """A robot that follows perfectly."""
    from remote_site.drivers.kinematic import KinematicDriver  # noqa: PLC0415  # each imports what it alone needs

    return KinematicDriver(host.clock)


def simulated(host: DriverHost) -> Driver:
    """The robot of the simulated cell."""
    from remote_site.drivers.simulated import SimulatedDriver  # noqa: PLC0415  # it needs MuJoCo's extra

    if host.cell is None:
        raise DriverError("the simulated driver needs the simulated cell; start it with the remote site")
    return SimulatedDriver(host.cell, host.clock)


def c500c(host: DriverHost) -> Driver:
    """The A465's controller on a serial line."""
    from remote_site.drivers.c500c.config import C500cConfig  # noqa: PLC0415  # only this robot's
    from remote_site.drivers.c500c.driver import C500cDriver  # noqa: PLC0415  # only this robot's
    from remote_site.drivers.c500c.port import open_port  # noqa: PLC0415  # only this robot's

    config = check_options(C500cConfig, host.options)
    return C500cDriver(config, open_port(config.port, config.baud), host.clock)


def franka(host: DriverHost) -> Driver:
    """An FR3 of Franka Robotics, with or without its hand."""
    from remote_site.drivers.franka.client import check_installed  # noqa: PLC0415  # only this robot's
    from remote_site.drivers.franka.config import FrankaConfig  # noqa: PLC0415  # only this robot's
    from remote_site.drivers.franka.driver import FrankaDriver  # noqa: PLC0415  # only this robot's
    from remote_site.drivers.franka.robot_side import RobotProcesses  # noqa: PLC0415  # only this robot's

    config = check_options(FrankaConfig, host.options)
    check_installed()
    if not config.host:
        raise DriverError(
            "the franka driver needs the robot's address: set driver.options.host, or start with --emulate"
        )
    return FrankaDriver(config, RobotProcesses(config, host.clock), host.clock)
