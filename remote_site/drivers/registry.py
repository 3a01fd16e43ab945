"""Drivers by name: the built-in ones, and those that installed packages register."""

from collections.abc import Callable
from dataclasses import dataclass
from importlib.metadata import EntryPoint, entry_points

from common.clock import Clock
from common.errors import DriverError
from remote_site.drivers.driver import Driver
from remote_site.drivers.kinematic import KinematicDriver
from remote_site.drivers.simulated import SimulatedDriver
from remote_site.shared_memory import CellMemory

GROUP = "farhand.drivers"


@dataclass(frozen=True, slots=True)
class DriverHost:
    """What the house lends a driver: its clock, and the simulated cell's memory if there is such a cell."""

    clock: Clock
    cell: CellMemory | None = None


DriverFactory = Callable[[DriverHost], Driver]


def create_driver(name: str, host: DriverHost) -> Driver:
    """The driver of that name, not yet configured; DriverError lists the alternatives.

    An installed package offers a `DriverFactory` as an entry point of the group `farhand.drivers`.
    """
    check_driver(name)
    if name in BUILT_IN:
        return BUILT_IN[name](host)
    installed = _installed()
    try:
        factory: DriverFactory = installed[name].load()
        return factory(host)
    except (ImportError, AttributeError) as error:
        raise DriverError(f"the driver {name!r} cannot be loaded from {installed[name].value}: {error}") from error


def check_driver(name: str) -> None:
    """DriverError, listing the alternatives, unless there is a driver of that name."""
    if name not in driver_names():
        raise DriverError(f"there is no driver {name!r}; choose one of: {', '.join(driver_names())}")


def driver_names() -> tuple[str, ...]:
    """Every name that `create_driver` knows."""
    return tuple(sorted({*BUILT_IN, *_installed()}))


def _installed() -> dict[str, EntryPoint]:
    return {point.name: point for point in entry_points(group=GROUP)}


def _kinematic(host: DriverHost) -> Driver:
    return KinematicDriver(host.clock)


def _simulated(host: DriverHost) -> Driver:
    if host.cell is None:
        raise DriverError("the simulated driver needs the simulated cell; start it with the remote site")
    return SimulatedDriver(host.cell, host.clock)


BUILT_IN: dict[str, DriverFactory] = {"kinematic": _kinematic, "simulated": _simulated}
