"""What a driver declares that it checks is asked before anything starts, of a package of anybody's."""

from collections.abc import Mapping
from importlib.metadata import EntryPoint

import pytest

from common.clock import FakeClock
from common.errors import ConfigError, DriverError
from remote_site.drivers import registry
from remote_site.drivers.checks_before_start import check_before_start, checked_by
from remote_site.drivers.driver import Driver, DriverSetup, check_joints
from remote_site.drivers.kinematic import KinematicDriver
from remote_site.drivers.registry import DriverHost, Option, create_driver
from tests.remote_site.drivers.test_robot_drivers import SETUP


def address(options: Mapping[str, Option], setup: DriverSetup) -> None:
    assert setup is SETUP
    if "host" not in options:
        raise DriverError("set driver.options.host\nset driver.options.port")


def joints(options: Mapping[str, Option], setup: DriverSetup) -> None:
    check_joints(setup, 7 if options else 6, "a lab arm")


def broken(options: Mapping[str, Option], setup: DriverSetup) -> None:
    raise KeyError(len(options) + len(setup.joint_names))


@checked_by(address, joints)
def checked(host: DriverHost) -> Driver:
    return KinematicDriver(host.clock)


@checked_by(broken)
class Checked(KinematicDriver):
    def __init__(self, host: DriverHost) -> None:
        super().__init__(host.clock)


def unchecked(host: DriverHost) -> Driver:
    return KinematicDriver(host.clock)


@pytest.fixture(autouse=True)
def _registered(monkeypatch: pytest.MonkeyPatch) -> None:
    points = [EntryPoint(name, f"{__name__}:{name}", registry.GROUP) for name in ("checked", "unchecked")]
    points.append(EntryPoint("class", f"{__name__}:Checked", registry.GROUP))
    monkeypatch.setattr(registry, "entry_points", lambda group: points if group == registry.GROUP else [])


@pytest.mark.parametrize(
    ("options", "mistakes"),
    [
        ({}, ["set driver.options.host", "set driver.options.port"]),
        ({"host": "x"}, ["a lab arm has 7 joints, the model 6: give robot.model the URDF of this arm"]),
    ],
)
def test_every_mistake_of_every_check_is_told(options: Mapping[str, Option], mistakes: list[str]) -> None:
    with pytest.raises(ConfigError) as told:
        check_before_start("checked", options, SETUP)
    assert str(told.value).splitlines() == mistakes


def test_a_check_that_fails_itself_is_told_as_such() -> None:
    with pytest.raises(ConfigError, match="a check of the driver 'class' raised KeyError: 6; tell its author"):
        check_before_start("class", {}, SETUP)


def test_a_driver_that_declares_none_has_none_and_each_is_made_as_before() -> None:
    check_before_start("unchecked", {"anything": 1}, SETUP)
    for name in ("unchecked", "checked", "class"):
        assert isinstance(create_driver(name, DriverHost(FakeClock())), KinematicDriver)


def test_one_that_is_not_installed_is_told() -> None:
    with pytest.raises(ConfigError, match="there is no driver 'lab'"):
        check_before_start("lab", {}, SETUP)
