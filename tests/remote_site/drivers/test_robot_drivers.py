"""The kinematic driver is where it was commanded; the registry knows who there is."""

import tomllib
from dataclasses import replace
from importlib.metadata import EntryPoint
from pathlib import Path

import numpy as np
import pytest

from common.clock import NS_PER_MS, FakeClock
from common.errors import ConfigError, DriverError
from common.messages.robot import GripperCommand
from remote_site.drivers import registry
from remote_site.drivers.driver import DriverSetup, JointCommand
from remote_site.drivers.faults import NOT_ACTIVATED
from remote_site.drivers.kinematic import KinematicDriver
from remote_site.drivers.registry import DriverHost, check_driver, create_driver
from remote_site.simulation.memory import CellMemory
from tests.remote_site.remote_loop import arm

MODEL, LIMITS = arm()
DT = 0.004
START = np.radians([0.0, 0.0, -45.0, 0.0, -45.0, 0.0])
SETUP = DriverSetup(MODEL.joint_names, LIMITS, DT, 50 * NS_PER_MS)


class Bench:
    """An activated kinematic driver, its clock, and a ramp of joint 1 at 0.4 rad/s."""

    def __init__(self):
        self.clock = FakeClock(1_000 * NS_PER_MS)
        self.driver = KinematicDriver(self.clock)
        self.driver.configure(SETUP)
        self.driver.activate(START)
        self.q, self.v, self.a, self.seq = START.copy(), 0.0, 0.0, 0

    def command(self, jerk=0.0):
        self.clock.advance_ms(4)
        self.q[0] += self.v * DT + self.a * DT**2 / 2 + jerk * DT**3 / 6
        self.v += self.a * DT + jerk * DT**2 / 2
        self.a += jerk * DT
        self.seq += 1
        e1 = np.eye(6)[0]
        return JointCommand(self.seq, self.clock.now_ns(), self.q.copy(), e1 * self.v, e1 * self.a, GripperCommand.KEEP)

    def ramp(self):
        for jerk in [500.0] * 5 + [0.0] * 5 + [-500.0] * 5 + [0.0] * 20:
            command = self.command(jerk)
            assert self.driver.write(command).q is command.q


@pytest.fixture
def bench():
    return Bench()


def test_it_is_where_it_was_commanded(bench):
    bench.ramp()
    reading = bench.driver.read()
    assert np.array_equal(reading.q, bench.q)
    assert reading.dq[0] == bench.v > 0.35
    assert (reading.fault, reading.obeyed_seq) == (None, bench.seq)
    assert reading.t_ns == bench.clock.now_ns()


def test_calls_out_of_order_are_refused():
    driver = KinematicDriver(FakeClock())
    with pytest.raises(DriverError, match="configure"):
        driver.activate(START)
    with pytest.raises(DriverError, match="configure"):
        driver.read()
    driver.configure(replace(SETUP, start=START))
    before = driver.read()
    assert (before.q.tolist(), before.fault) == (START.tolist(), NOT_ACTIVATED)
    assert not before.dq.any()
    with pytest.raises(DriverError, match="activate"):
        driver.write(JointCommand(1, 0, START, START * 0, START * 0, GripperCommand.KEEP))


@pytest.mark.parametrize("q0", [START[:5], START * np.nan])
def test_a_start_that_is_no_posture_is_refused(bench, q0):
    with pytest.raises(DriverError, match="6 finite positions"):
        bench.driver.activate(q0)


def test_a_stop_is_idempotent_and_activation_waits_for_rest(bench):
    bench.ramp()
    bench.driver.stop()
    with pytest.raises(DriverError, match="still moves"):
        bench.driver.activate(bench.q)
    bench.clock.advance_ms(20)
    first = bench.driver.read()
    bench.driver.stop()
    assert np.array_equal(bench.driver.read().dq, first.dq)
    bench.clock.advance_ms(200)
    rest = bench.driver.read()
    assert not rest.dq.any()
    assert rest.q[0] > bench.q[0]
    bench.driver.activate(rest.q)
    bench.driver.deactivate()
    assert bench.driver.read().fault is not None


@pytest.fixture
def registered(monkeypatch):
    """Farhand's own drivers as pyproject.toml registers them, whatever is installed, and two foreign ones."""
    project = tomllib.loads((Path(__file__).parents[3] / "pyproject.toml").read_text())["project"]
    points = [
        EntryPoint(name, value, registry.GROUP) for name, value in project["entry-points"][registry.GROUP].items()
    ]
    points += [
        EntryPoint("lab", "remote_site.drivers.factories:kinematic", registry.GROUP),
        EntryPoint("unmade", "remote_site.drivers.kinematic:CAPABILITIES", registry.GROUP),
        EntryPoint("broken", "no_such_package:make", registry.GROUP),
    ]
    monkeypatch.setattr(registry, "entry_points", lambda group: points if group == registry.GROUP else [])


@pytest.mark.usefixtures("registered")
def test_drivers_are_found_by_name():
    assert isinstance(create_driver("kinematic", DriverHost(FakeClock())), KinematicDriver)
    simulated = create_driver("simulated", DriverHost(FakeClock(), cell=CellMemory.create(6)))
    assert simulated.capabilities.joints == 6


@pytest.mark.usefixtures("registered")
def test_an_unknown_driver_lists_the_alternatives():
    every = "broken, c500c, franka, kinematic, lab, simulated, unmade"
    with pytest.raises(
        ConfigError,
        match=rf"no driver 'c500'; did you mean c500c\? Else choose one of: {every}; or install your own first",
    ):
        create_driver("c500", DriverHost(FakeClock()))


@pytest.mark.usefixtures("registered")
def test_what_a_driver_needs_is_told():
    with pytest.raises(DriverError, match="cell"):
        create_driver("simulated", DriverHost(FakeClock()))
    with pytest.raises(ConfigError, match=r"driver\.options\.port"):
        create_driver("c500c", DriverHost(FakeClock()))
    with pytest.raises(DriverError, match="cannot open the serial line /dev/none"):
        create_driver("c500c", DriverHost(FakeClock(), {"port": "/dev/none"}))
    with pytest.raises(ConfigError, match=r"driver\.options\.prot: .*did you mean port"):
        create_driver("c500c", DriverHost(FakeClock(), {"prot": "/dev/ttyUSB0"}))


@pytest.mark.usefixtures("registered")
def test_installed_packages_offer_drivers():
    assert isinstance(create_driver("lab", DriverHost(FakeClock())), KinematicDriver)
    with pytest.raises(ConfigError, match="no_such_package:make"):
        create_driver("broken", DriverHost(FakeClock()))
    with pytest.raises(DriverError, match=r"'unmade' cannot be made: .*kinematic:CAPABILITIES raised TypeError"):
        create_driver("unmade", DriverHost(FakeClock()))


def test_an_installation_without_drivers_is_told_its_cure(monkeypatch):
    monkeypatch.setattr(registry, "entry_points", lambda group: [])  # noqa: ARG005
    with pytest.raises(ConfigError, match="pip install -e"):
        check_driver("kinematic")
