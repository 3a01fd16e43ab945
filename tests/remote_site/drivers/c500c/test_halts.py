"""What halts the arm: a broken line, missing setpoints, an emergency stop, a jam; and what it takes to go on."""

import numpy as np
import pytest

from common.errors import DriverError
from common.messages.robot import GripperCommand
from remote_site.drivers.c500c.emulation import EmulatedLine
from remote_site.drivers.c500c.protocol import Fault, Flag, Kind
from remote_site.drivers.driver import JointCommand
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


def test_a_setpoint_from_before_a_stop_reaches_neither_the_arm_nor_its_gripper_after_the_next_activation():
    for wait_ms in range(20, 60, 4):
        bench = EmulatedA465().ready()
        bench.send(ROBOT.start, periods=4, gripper=GripperCommand.CLOSED)
        for _ in range(2):  # at once: the second finds the controller's queue full, and waits to be sent again
            command = JointCommand(9, bench.clock.now_ns(), ROBOT.start, np.zeros(6), np.zeros(6), GripperCommand.OPEN)
            bench.driver.write(command)
        bench.run(wait_ms)
        bench.driver.stop()
        activation = bench.controller.activation
        bench.driver.activate(ROBOT.start)
        while bench.controller.activation == activation:
            bench.run(2)
        opens = bench.controller.gripper.aim_open
        bench.run(150)
        assert (bench.controller.gripper.aim_open, bench.controller._last_setpoint) == (opens, None), wait_ms


def test_a_stop_withdraws_an_activation_that_still_waits_for_the_line(bench):
    bench.driver.configure(SETUP)
    bench.run(100)
    while bench.driver._exchange._pending is None:  # until a poll is under way
        bench.run(2)
    bench.driver.activate(ROBOT.start)
    bench.driver.stop()
    bench.run(200)
    assert not bench.controller.active


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


def test_an_arm_without_power_is_halted_and_told(bench):
    bench.ready()
    for k in range(20):
        bench.send(ROBOT.start + 0.01 * k)
    bench.controller.arm_power = False
    reading = bench.run(60)
    assert reading.fault.code is FaultCode.ARM_POWER
    assert not bench.controller.dq.any()
    with pytest.raises(DriverError, match="no power"):
        bench.driver.activate(reading.q)


@pytest.mark.parametrize("bit", range(8))
@pytest.mark.parametrize("kind", [Kind.POLL, Kind.SETPOINT])
def test_one_wrong_bit_in_a_length_halts_nothing(bench, kind, bit):
    def push(data: bytes, now_ns: int) -> None:
        if not changed and data and data[3] == kind:
            changed.append(data)
            data = data[:1] + bytes([data[1] ^ (1 << bit)]) + data[2:]
        EmulatedLine.push(line, data, now_ns)

    changed, line = list[bytes](), bench.ready().emulation.there
    bench.send(ROBOT.start, periods=5)
    line.push = push
    for k in range(20):
        assert bench.send(ROBOT.start + 0.002 * k).fault is None
    assert changed
