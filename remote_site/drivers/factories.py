"""Makes Farhand's own drivers, as the entry points in pyproject.toml name them."""

from collections.abc import Mapping

from common.errors import ConfigError, DriverError
from remote_site.drivers.c500c.config import c500c_options
from remote_site.drivers.c500c.protocol import JOINTS as A465_JOINTS
from remote_site.drivers.checks_before_start import checked_by
from remote_site.drivers.driver import Driver, DriverSetup, check_joints
from remote_site.drivers.franka.config import franka_options
from remote_site.drivers.franka.robot_limits import check_fr3
from remote_site.drivers.registry import DriverHost, Option


def without_options(options: Mapping[str, Option], _setup: DriverSetup) -> None:
    """Raise ConfigError with a line for each option, of a driver that has none."""
    if options:
        cure = "leave it out, or set driver.options={}"
        raise ConfigError("\n".join(f"driver.options.{key}: this driver has no options; {cure}" for key in options))


@checked_by(without_options)
def kinematic(host: DriverHost) -> Driver:
    """A robot that follows perfectly."""
    from remote_site.drivers.kinematic import KinematicDriver  # noqa: PLC0415  # each imports what it alone needs

    return KinematicDriver(host.clock)


@checked_by(without_options)
def simulated(host: DriverHost) -> Driver:
    """The robot of the simulated cell."""
    from remote_site.drivers.simulated import SimulatedDriver  # noqa: PLC0415  # it needs MuJoCo's extra

    if host.cell is None:
        raise DriverError("the simulated driver needs the simulated cell; start it with the remote site")
    return SimulatedDriver(host.cell, host.clock)


@checked_by(lambda options, _: c500c_options(options), lambda _, setup: check_joints(setup, A465_JOINTS, "an A465"))
def c500c(host: DriverHost) -> Driver:
    """The A465's controller on a serial line."""
    from remote_site.drivers.c500c.driver import C500cDriver  # noqa: PLC0415  # only this robot's
    from remote_site.drivers.c500c.port import open_port  # noqa: PLC0415  # only this robot's

    config = c500c_options(host.options)
    return C500cDriver(config, open_port(config.port, config.baud), host.clock)


@checked_by(lambda options, _: franka_options(options), lambda _, setup: check_fr3(setup))
def franka(host: DriverHost) -> Driver:
    """An FR3 of Franka Robotics, with or without its hand."""
    from remote_site.drivers.franka.driver import FrankaDriver  # noqa: PLC0415  # only this robot's
    from remote_site.drivers.franka.robot_side import RobotProcesses  # noqa: PLC0415  # only this robot's

    config = franka_options(host.options)
    return FrankaDriver(config, RobotProcesses(config, host.clock), host.clock)
