"""Checks that a driver makes of its configuration before anything starts, without a robot; declared at its factory."""

from collections.abc import Callable, Mapping
from typing import TypeVar

from common.errors import ConfigError, FarhandError
from remote_site.drivers.driver import DriverSetup
from remote_site.drivers.registry import Option, load_factory

DriverCheck = Callable[[Mapping[str, Option], DriverSetup], object]

F = TypeVar("F", bound=Callable[..., object])

DECLARED = "farhand_checks"


def checked_by(*checks: DriverCheck) -> Callable[[F], F]:
    """Declare, at a driver's factory, what can be checked of its options and setup before anything starts.

    A check raises DriverError with a sentence that says what to change, or with a line for each mistake. It is called
    on any machine, with or without the robot, and opens nothing. All of them run.
    """

    def declare(factory: F) -> F:
        setattr(factory, DECLARED, checks)
        return factory

    return declare


def check_before_start(name: str, options: Mapping[str, Option], setup: DriverSetup) -> None:
    """ConfigError with every mistake that the checks of this driver find; a driver that declares none has none."""
    checks: tuple[DriverCheck, ...] = getattr(load_factory(name), DECLARED, ())
    mistakes = [line for check in checks for line in _mistakes(name, check, options, setup)]
    if mistakes:
        raise ConfigError("\n".join(mistakes))


def _mistakes(name: str, check: DriverCheck, options: Mapping[str, Option], setup: DriverSetup) -> list[str]:
    try:
        check(options, setup)
    except FarhandError as error:
        return str(error).splitlines()
    except Exception as error:  # an installed driver may raise anything
        return [f"a check of the driver {name!r} raised {type(error).__name__}: {error}; tell its author"]
    return []
