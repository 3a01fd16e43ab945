"""What halts the arm: a broken line, missing setpoints, an emergency stop, a jam; and what it takes to go on."""

import numpy as np
import pytest

from common.errors import DriverError
from remote_site.drivers.c500c.protocol import (
    Fault,
    Flag,
)
from remote_site.drivers.faults import FaultCode
from tests.remote_site.drivers.c500c.emulated_a465 import ROBOT, SETUP, EmulatedA465


def test_a_line_that_loses_too_much_halts_the_arm_before_a_setpoint_is_left_out():
    bench = EmulatedA465().ready()
    bench.emulation.there.loss = bench.emulation.back.loss = 0.02
    with pytest.raises(DriverError, match="does not keep up"):
        bench.send(ROBOT.start + 0.02, periods=90)
    assert bench.longest <= 2
    bench.run(500)
    assert not bench.controller.dq.any()


def test_a_cut_line_halts_the_arm_and_is_told(bench):
    bench.ready()
    for k in range(20):
        bench.send(ROBOT.start + 0.01 * k)
    assert np.abs(bench.controller.dq).max() > 0.05
    bench.emulation.there.loss = bench.emulation.back.loss = 1.0
    reading = bench.run(600)
    assert reading.fault.code is FaultCode.SILENT
    assert bench.controller.fault in (Fault.WATCHDOG, Fault.UNDERRUN)
    assert not bench.controller.dq.any()
    bench.emulation.there.loss = bench.emulation.back.loss = 0.0
    reading = bench.run(300)
    assert reading.fault.code in (FaultCode.WATCHDOG, FaultCode.LINK)  # the line is back, the arm stays
    rest = bench.controller.player.q.copy()
    bench.send(rest + 0.1, periods=5)
    assert (bench.controller.player.q == rest).all()


def test_setpoints_that_cease_in_motion_halt_the_arm(bench):
    bench.ready()
    for k in range(20):
        bench.send(ROBOT.start + 0.01 * k)
    reading = bench.run(600)
    assert reading.fault.code is FaultCode.LINK
    assert reading.fault.native == "UNDERRUN"
    assert not bench.controller.dq.any()


def test_a_halt_brakes_within_its_limits_and_stays_powered(bench):
    bench.ready()
    for k in range(20):
        bench.send(ROBOT.start + 0.05 * k)
    before, speeds = bench.controller.player.q.copy(), []
    bench.driver.stop()
    for _ in range(150):
        reading = bench.run(4)
        bench.driver.stop()
        speeds.append(bench.controller.dq[0])
    assert reading.fault.code is FaultCode.STOPPED
    assert speeds[0] > 0.6
    assert speeds[-1] == 0.0
    assert np.abs(np.diff(speeds)).max() <= 2 * 10.0 * 0.005 + 1e-9
    assert bench.controller.player.q[0] - before[0] < 0.1
    assert Flag.ARM_POWER in bench.driver._exchange.state.flags


def test_an_emergency_stop_is_mirrored_and_needs_release_and_activation(bench):
    bench.ready()
    for k in range(20):
        bench.send(ROBOT.start + 0.01 * k)
    bench.controller.emergency_stop = True
    reading = bench.run(60)
    assert reading.fault.code is FaultCode.EMERGENCY_STOP
    assert reading.fault.native == "EMERGENCY_STOP"
    assert not bench.controller.dq.any()
    with pytest.raises(DriverError, match="emergency stop"):
        bench.driver.activate(reading.q)
    bench.controller.emergency_stop = False
    reading = bench.run(200)
    assert reading.fault is not None
    bench.driver.activate(reading.q)
    assert bench.run(80).fault is None


def test_a_jammed_joint_halts_and_is_told(bench):
    bench.ready()
    for k in range(20):
        bench.send(ROBOT.start + 0.01 * k)
    bench.controller.jammed = True
    assert bench.run(200).fault.code is FaultCode.BLOCKED


def test_activation_elsewhere_is_refused_by_the_controller(bench):
    bench.driver.configure(SETUP)
    bench.run(100)
    bench.driver.activate(ROBOT.start + 0.1)
    assert bench.run(80).fault.code is FaultCode.APART
