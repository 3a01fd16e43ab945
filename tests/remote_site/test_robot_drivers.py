"""The kinematic driver keeps the last limits itself; the registry knows who there is."""

from importlib.metadata import EntryPoint

import numpy as np
import pytest
from remote_loop import arm

from common.clock import NS_PER_MS, FakeClock
from common.errors import DriverError
from remote_site.drivers import registry
from remote_site.drivers.driver import DriverSetup, JointCommand
from remote_site.drivers.kinematic import KinematicDriver
from remote_site.drivers.registry import DriverHost, create_driver, driver_names

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
        return JointCommand(self.seq, self.clock.now_ns(), self.q.copy(), e1 * self.v, e1 * self.a, True)

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
    assert (reading.ready, reading.fault, reading.obeyed_seq) == (True, "", bench.seq)
    assert reading.t_ns == bench.clock.now_ns()


def test_calls_out_of_order_are_refused():
    driver = KinematicDriver(FakeClock())
    with pytest.raises(DriverError, match="configure"):
        driver.activate(START)
    driver.configure(SETUP)
    with pytest.raises(DriverError, match="activate"):
        driver.read()
    with pytest.raises(DriverError, match="activate"):
        driver.write(JointCommand(1, 0, START, START * 0, START * 0, False))


@pytest.mark.parametrize("q0", [START[:5], START * np.nan])
def test_a_start_that_is_no_posture_is_refused(bench, q0):
    with pytest.raises(DriverError, match="6 finite positions"):
        bench.driver.activate(q0)


@pytest.mark.parametrize("jerk", [3000.0, np.nan])
def test_a_command_beyond_the_limits_is_replaced_by_the_stop(bench, jerk):
    bench.ramp()
    moving = bench.driver.read()
    sent = bench.driver.write(bench.command(jerk))
    assert np.isfinite(sent.q).all()
    assert sent.ddq[0] == pytest.approx(-LIMITS.jerk[0] * DT)
    assert sent.dq[0] < moving.dq[0]


def test_silence_beyond_the_time_out_stops_within_limits_and_needs_activation(bench):
    bench.ramp()
    bench.clock.advance_ms(50)
    assert bench.driver.read().ready
    speeds = []
    for _ in range(60):
        bench.clock.advance_ms(1)
        speeds.append(bench.driver.read().dq[0])
    assert speeds[0] > 0.3
    assert speeds[-1] == 0.0
    assert np.abs(np.diff(speeds)).max() <= LIMITS.acceleration[0] * 1e-3 + 1e-9
    reading = bench.driver.read()
    assert not reading.ready
    assert "no command for" in reading.fault
    with pytest.raises(DriverError, match="activate anew"):
        bench.driver.write(bench.command())
    bench.driver.activate(reading.q)
    assert bench.driver.read().ready


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
    assert not bench.driver.read().ready


def test_drivers_are_found_by_name():
    assert isinstance(create_driver("kinematic", DriverHost(FakeClock())), KinematicDriver)
    assert {"kinematic", "simulated"} <= set(driver_names())


def test_an_unknown_driver_lists_the_alternatives():
    with pytest.raises(DriverError, match=r"no driver 'c500'.*kinematic, simulated"):
        create_driver("c500", DriverHost(FakeClock()))


def test_the_simulated_driver_needs_its_cell():
    with pytest.raises(DriverError, match="cell"):
        create_driver("simulated", DriverHost(FakeClock()))


def test_installed_packages_offer_drivers(monkeypatch):
    points = {
        "lab": EntryPoint("lab", "remote_site.drivers.registry:_kinematic", registry.GROUP),
        "broken": EntryPoint("broken", "no_such_package:make", registry.GROUP),
    }
    monkeypatch.setattr(registry, "entry_points", lambda group: points.values() if group == registry.GROUP else ())
    assert isinstance(create_driver("lab", DriverHost(FakeClock())), KinematicDriver)
    assert {"lab", "broken"} < set(driver_names())
    with pytest.raises(DriverError, match="no_such_package:make"):
        create_driver("broken", DriverHost(FakeClock()))
