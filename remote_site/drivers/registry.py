"""Drivers by name: every one, also Farhand's own, is an entry point of the group `farhand.drivers`."""

from collections.abc import Callable, Mapping
from dataclasses import dataclass, field
from importlib.metadata import EntryPoint, entry_points
from typing import TypeVar

import msgspec

from common.clock import Clock
from common.config.loading import ConfigMistake, build
from common.errors import ConfigError, DriverError, FarhandError
from common.text import instead_of
from remote_site.drivers.driver import Driver
from remote_site.simulation.memory import CellMemory

GROUP = "farhand.drivers"

S = TypeVar("S", bound=msgspec.Struct)

Option = str | int | float | bool


@dataclass(frozen=True, slots=True)
class DriverHost:
    """The inputs to make a driver: a clock, the table `driver.options`, and the simulated cell's memory, if any."""

    clock: Clock
    options: Mapping[str, Option] = field(default_factory=dict)
    cell: CellMemory | None = None


DriverFactory = Callable[[DriverHost], Driver]


def create_driver(name: str, host: DriverHost) -> Driver:
    """The driver of that name, not yet configured; ConfigError lists the alternatives.

    An installed package offers a `DriverFactory` as an entry point of the group `farhand.drivers`.
    """
    factory = load_factory(name)
    try:
        return factory(host)
    except FarhandError:
        raise  # it is a sentence already
    except Exception as error:  # an installed driver may raise anything
        where = check_driver(name).value
        raise DriverError(f"the driver {name!r} cannot be made: {where} raised {_kind(error)}") from error


def load_factory(name: str) -> DriverFactory:
    """Load the factory of the driver of that name; ConfigError when there is none, or it cannot be loaded."""
    point = check_driver(name)
    try:
        factory: DriverFactory = point.load()
    except (Exception, SystemExit) as error:  # an installed driver may raise anything
        raise ConfigError(f"the driver {name!r} cannot be loaded from {point.value}: {_kind(error)}") from error
    return factory


def check_driver(name: str) -> EntryPoint:
    """Find the driver of that name; ConfigError, listing the alternatives, when there is none."""
    installed = {point.name: point for point in entry_points(group=GROUP)}
    if not installed:
        raise ConfigError("no driver is registered: reinstall Farhand ('pip install -e .' in its folder)")
    if name not in installed:
        raise ConfigError(
            f"there is no driver {name!r}; {instead_of(name, sorted(installed))}; or install your own first, into "
            "Farhand's environment: pip install --editable FOLDER"
        )
    return installed[name]


def check_options(kind: type[S], options: Mapping[str, Option]) -> S:
    """The table `driver.options` as a msgspec struct of the driver's own; ConfigError names every mistake."""
    mistakes: list[ConfigMistake] = []
    config = build(kind, options, ("driver", "options"), mistakes)
    if config is None:
        raise ConfigError("\n".join(f"{'.'.join(mistake.path)}: {mistake.text}" for mistake in mistakes))
    return config


def _kind(error: BaseException) -> str:
    return f"{type(error).__name__}: {error}"
