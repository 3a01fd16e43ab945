"""Control and driver in processes of their own: a killed control, a driver that blocks, a fault that stays."""

import contextlib
import multiprocessing
import os
import signal
import time
from functools import partial
from typing import Any

import numpy as np
import pytest

from common.clock import NS_PER_S
from common.errors import DriverError
from common.host_clock import MonotonicClock
from common.messages.robot import GripperCommand
from common.process.children import END, Children
from common.process.service import StopFlag, ask_for_real_time
from lab.stage.waiting import until
from remote_site.config import RemoteConfig
from remote_site.drivers import link as driver_link
from remote_site.drivers.c500c.config import C500cConfig
from remote_site.drivers.c500c.driver import C500cDriver
from remote_site.drivers.c500c.emulation import EmulatedPort, Emulation, Terminal, run_emulation
from remote_site.drivers.c500c.emulator import EmulatedController
from remote_site.drivers.c500c.port import open_port
from remote_site.drivers.c500c.protocol import Fault
from remote_site.drivers.config import DriverConfig
from remote_site.drivers.driver import JointCommand
from remote_site.drivers.faults import FaultCode
from remote_site.drivers.kinematic import KinematicDriver
from remote_site.drivers.link import DriverLink
from remote_site.drivers.memory import DriverMemory
from remote_site.drivers.registry import DriverHost
from remote_site.drivers.simulated import SimulatedDriver
from remote_site.drivers.supervisor import reading_check, watched_driver
from remote_site.kinematics.joints import JointMotion
from remote_site.runtime import driver_process as process
from remote_site.safety.stopping import stopping
from remote_site.simulation.memory import CellMemory
from remote_site.simulation.process import SimulatedCell, run_cell
from tests.present import present
from tests.remote_site.drivers.leading_control import LeadingControl
from tests.remote_site.remote_loop import arm

STARVED_NS = 2 * NS_PER_S  # that is how long other tests may keep the simulated robot from its processor
LATE_CALL_NS = NS_PER_S // 2  # a busy machine may keep a call of a driver that does not block
FORK = multiprocessing.get_context("fork")
CONFIG = RemoteConfig(driver=DriverConfig(command_timeout_ms=1000.0))  # a busy machine may keep control waiting
MODEL, LIMITS = arm()
CLOCK = MonotonicClock()
DT = 0.004
PATIENCE_S = 30.0


class Blocking(KinematicDriver):
    """Waits in its tenth reading after it was commanded, until it is let go."""

    let_go = FORK.RawValue("b", 0)

    def read(self):
        if self._obeyed is not None and self._obeyed >= 10:
            until_s = time.monotonic() + 2 * PATIENCE_S
            while not self.let_go.value and time.monotonic() < until_s:
                time.sleep(0.005)
        return super().read()


def kinematic(host):
    return KinematicDriver(host.clock)


def blocking(host):
    return Blocking(host.clock)


def simulated(host):
    return SimulatedDriver(host.cell, host.clock)


def c500c(host):
    emulation = Emulation(EmulatedController(CONFIG.robot.start), host.clock.now_ns())
    return C500cDriver(C500cConfig(), EmulatedPort(emulation, host.clock), host.clock)


class Rig:
    """The driver's process, the cell's where there is one, and the content of the reports."""

    def __init__(self, factory, monkeypatch):
        monkeypatch.setattr(process, "create_driver", lambda name, host: factory(host))  # noqa: ARG005
        monkeypatch.setattr(reading_check, "OLDEST_NS", STARVED_NS)
        for module in (driver_link, watched_driver) if factory is not blocking else ():
            monkeypatch.setattr(module, "DEADLINE_NS", LATE_CALL_NS)
        self.memory, self.cell = DriverMemory.create(6), CellMemory.create(6)
        self.children = Children("remote")
        if factory is simulated:
            cell = SimulatedCell(CONFIG.simulation, CONFIG.robot, self.cell)
            self.children.start("cell", lambda stop, beat: run_cell(cell, stop, beat.beat))
        self.driver = self.children.start("driver", partial(process.run_driver, CONFIG, self.memory, self.cell))
        self.children.wait_ready(30.0, StopFlag())
        self.log = []

    def watch(self, until, seconds=30.0):
        """Keep every new report until one fulfils `until`."""
        watcher = DriverLink(self.memory, LIMITS, CLOCK)
        deadline = time.monotonic() + seconds
        while time.monotonic() < deadline:
            watcher._activation = self.memory.report.read().activation
            report = watcher.read()
            self.log.append((time.monotonic(), report))
            if until(report):
                return report
            time.sleep(0.0005)
        return pytest.fail(f"not reached in {seconds} s; last {self.log[-1]}")


def control(memory):
    """Activate, then go to a far goal and back until killed: a busy machine may hide one way from the watcher."""
    ask_for_real_time(50)
    link, start = DriverLink(memory, LIMITS, CLOCK), CONFIG.robot.start
    link.activate(start)
    while (fault := link.read().fault) is not None:
        time.sleep(0.01)
        if fault.code is FaultCode.REFUSED:
            link.activate(start)
    leading, goal, other = LeadingControl(link, LIMITS, CLOCK, start), start + np.array([2.4, 0, 0, 0, 0, 0]), start
    for _ in range(100_000):
        leading.order(goal)
        if np.abs(leading.sent.q - goal).max() < 0.001:
            goal, other = other, goal
        time.sleep(DT)


@pytest.fixture
def make_rig(monkeypatch):
    rigs = []

    def make(factory):
        rigs.append(Rig(factory, monkeypatch))
        return rigs[-1]

    yield make
    for rig in rigs:
        rig.children.end()


@pytest.fixture
def commander():
    started = []

    def start(rig):
        started.append(FORK.Process(target=control, args=(rig.memory,)))
        started[-1].start()
        return started[-1]

    yield start
    for each in started:
        each.kill()
        each.join(5)


def is_stopped(report):
    timed_out = report.fault is not None and report.fault.code is FaultCode.COMMAND_TIMEOUT
    return timed_out and not report.sent.dq.any() and np.abs(report.dq).max() < 0.01


# The simulated robot extrapolates its last setpoint while a busy machine keeps the next from it: 20 ms at 1 rad/s.
@pytest.mark.parametrize(("factory", "overshoot_rad"), [(kinematic, 0.003), (simulated, 0.02), (c500c, 0.003)])
def test_control_killed_in_full_motion_ends_in_the_verified_stop(make_rig, commander, factory, overshoot_rad):
    rig = make_rig(factory)
    victim = commander(rig)
    rig.watch(lambda report: report.ready and report.sent.dq[0] > 1.0 and report.dq[0] > 0.5)
    os.kill(victim.pid, signal.SIGKILL)
    victim.join(5)
    rig.memory.orders._seen = rig.memory.orders._record.count - 1
    (last,) = rig.memory.orders.take()
    end = stopping(last.command.motion, LIMITS, 9.9).q[0]
    del rig.log[:]
    report = rig.watch(is_stopped)
    assert report.sent.q[0] == pytest.approx(end, abs=1e-9)
    rig.watch(lambda r: abs(r.q[0] - end) < 0.003 and np.abs(r.dq).max() < 0.01)
    assert max(r.q[0] for _, r in rig.log) < end + overshoot_rad
    time.sleep(0.1)
    assert rig.watch(lambda _: True).sent.q[0] == pytest.approx(report.sent.q[0], abs=1e-9)


@pytest.mark.slow
def test_a_driver_killed_in_motion_leaves_the_controllers_own_watchdog(make_rig, commander):
    terminal = Terminal.create()
    robot = Children("remote")

    def over_the_line(host):
        return C500cDriver(C500cConfig(silent_ms=400.0), open_port(terminal.path, 57600), host.clock)

    def be_the_robot(should_stop, heartbeat):
        emulation = Emulation(EmulatedController(CONFIG.robot.start), CLOCK.now_ns())
        run_emulation(emulation, terminal, should_stop, heartbeat.beat)

    robot.start("robot", be_the_robot)
    robot.wait_ready(30.0, StopFlag())
    rig = make_rig(over_the_line)
    commander(rig)
    rig.watch(lambda report: report.ready and report.dq[0] > 0.5)
    rig.driver.process.kill()
    rig.driver.process.join(30)
    again = over_the_line(DriverHost(CLOCK))
    places: list[Any] = []
    deadline = time.monotonic() + PATIENCE_S
    while not (len(places) > 100 and places[-1].fault and places[-1].q == pytest.approx(places[-100].q, abs=1e-9)):
        assert time.monotonic() < deadline
        time.sleep(0.004)
        with contextlib.suppress(DriverError):
            places.append(again.read())
    robot.end()
    assert places[-1].q[0] > 0.05
    assert again._exchange.state.fault in (Fault.WATCHDOG, Fault.UNDERRUN)


@pytest.mark.slow
def test_the_driver_process_told_to_end_leaves_the_arm_at_rest(make_rig, commander):
    rig = make_rig(simulated)
    commander(rig)
    rig.watch(lambda report: report.ready and report.sent.dq[0] > 1.5)
    os.kill(rig.driver.process.pid, END)
    rig.driver.process.join(30)
    assert rig.driver.process.exitcode == 0
    cell = rig.cell.reading.read()
    assert np.abs(cell["dq"]).max() < 0.02


def test_a_driver_that_blocks_is_seen_from_outside_while_control_goes_on(make_rig):
    rig = make_rig(blocking)
    link = DriverLink(rig.memory, LIMITS, CLOCK)
    link.activate(CONFIG.robot.start)
    rest = JointMotion.at_rest(CONFIG.robot.start)
    until(lambda: link.read().ready, "the driver")
    deadline = time.monotonic() + PATIENCE_S
    seq = 0
    while (fault := link.read().fault) is None:
        assert time.monotonic() < deadline
        seq += 1
        link.write(JointCommand(seq, CLOCK.now_ns(), rest.q, rest.dq, rest.ddq, GripperCommand.KEEP))
        time.sleep(DT)
    assert time.monotonic() < deadline  # no write has waited for the driver, which is still blocked
    assert fault.code is FaultCode.DEADLINE
    blocked_ns = rig.memory.report.read().at_ns
    Blocking.let_go.value = 1
    rig.watch(lambda _: rig.memory.report.read().at_ns > blocked_ns)
    assert present(link.read().fault).code is FaultCode.DEADLINE  # also when the call has returned


def test_a_process_that_is_gone_is_told(make_rig):
    rig = make_rig(kinematic)
    link = DriverLink(rig.memory, LIMITS, CLOCK)
    link.activate(CONFIG.robot.start)
    rig.watch(lambda report: report.ready)
    os.kill(rig.driver.process.pid, signal.SIGKILL)
    rig.driver.process.join(30)
    time.sleep(0.15)
    assert present(link.read().fault).code is FaultCode.PROCESS
