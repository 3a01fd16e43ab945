"""The simulated driver hands setpoints to the cell, and states why the arm does not take them."""

from dataclasses import replace

import numpy as np
import pytest

from common.clock import FakeClock
from common.errors import DriverError
from common.geometry import Array
from common.messages.robot import GripperCommand
from remote_site.drivers.driver import DriverSetup, JointCommand
from remote_site.drivers.faults import FaultCode
from remote_site.drivers.simulated import SimulatedDriver
from remote_site.kinematics.config import RobotConfig
from remote_site.kinematics.limits import JointLimits
from remote_site.kinematics.model import ArmModel
from remote_site.simulation.config import CellConfig
from remote_site.simulation.memory import GRIPPER_COMMANDS, CellMemory
from remote_site.simulation.process import SimulatedCell

ROBOT = RobotConfig()
MODEL = ArmModel.from_urdf(ROBOT.urdf, ROBOT.tool_frame, ROBOT.tool_T_tcp)
SETUP = DriverSetup(MODEL.joint_names, JointLimits.from_model(MODEL, ROBOT), 0.004, 100_000_000)


class Bench:
    """A cell and its driver on one fake clock."""

    def __init__(self) -> None:
        self.clock = FakeClock(1_000_000_000)
        self.memory = CellMemory.create(6)
        self.cell = SimulatedCell(CellConfig(), ROBOT, self.memory)
        self.driver = SimulatedDriver(self.memory, self.clock)
        self.seq = 0

    def run(self, steps: int = 1) -> None:
        for _ in range(steps):
            self.clock.advance_ms(2)
            self.cell.step(self.clock.now_ns(), self.clock.now_ns())

    def ready(self) -> "Bench":
        self.driver.configure(SETUP)
        self.run()
        self.driver.activate(self.driver.read().q)
        self.run()
        return self

    def command(self, q: Array = ROBOT.start, gripper: GripperCommand = GripperCommand.OPEN) -> JointCommand:
        self.seq += 1
        return JointCommand(self.seq, self.clock.now_ns(), np.array(q), np.zeros(6), np.zeros(6), gripper)

    def hold(self, ticks: int, q: Array = ROBOT.start, gripper: GripperCommand = GripperCommand.OPEN) -> None:
        for _ in range(ticks):
            self.driver.write(self.command(q, gripper))
            self.run(2)


@pytest.fixture
def bench():
    return Bench()


def test_a_cell_that_gives_no_readings_is_not_ready(bench):
    bench.driver.configure(SETUP)
    with pytest.raises(DriverError, match="no readings"):
        bench.driver.read()
    with pytest.raises(DriverError, match="no readings"):
        bench.driver.activate(ROBOT.start)


def test_a_cell_that_falls_silent_is_not_ready(bench):
    bench.ready()
    assert bench.driver.read().fault is None
    for _ in range(9):
        bench.clock.advance_ms(12)
        reading = bench.driver.read()
    assert reading.fault.code is FaultCode.SILENT


def test_a_pause_of_the_reader_is_no_silence_of_the_cell(bench):
    bench.ready()
    assert bench.driver.read().fault is None
    bench.clock.advance_ms(150)
    assert bench.driver.read().fault is None


def test_it_must_be_configured_then_activated(bench):
    bench.run()
    with pytest.raises(DriverError, match="configure"):
        bench.driver.activate(ROBOT.start)
    bench.driver.configure(SETUP)
    with pytest.raises(DriverError, match="activate"):
        bench.driver.write(bench.command())


def test_activation_is_ready_after_a_step_of_the_cell(bench):
    bench.driver.configure(SETUP)
    bench.run()
    bench.driver.activate(ROBOT.start)
    assert bench.driver.read().fault.code is FaultCode.NOT_ACTIVATED
    bench.run()
    reading = bench.driver.read()
    assert reading.fault is None
    assert reading.obeyed_seq is None
    assert reading.q == pytest.approx(ROBOT.start, abs=1e-4)


def test_a_command_is_obeyed_and_reported(bench):
    bench.ready()
    goal = ROBOT.start + np.array([0.1, 0, 0, 0, 0, 0])
    sent = bench.driver.write(bench.command(goal))
    bench.run(2)
    assert bench.driver.read().obeyed_seq == sent.seq == 1
    bench.hold(250, goal)
    assert bench.driver.read().q == pytest.approx(goal, abs=1e-3)


def test_the_gripper_closes_and_opens(bench):
    bench.ready().hold(250, gripper=GripperCommand.CLOSED)
    assert bench.driver.read().gripper.opening_m == pytest.approx(0.0, abs=0.002)
    bench.hold(250)
    assert bench.driver.read().gripper.opening_m == pytest.approx(0.065, abs=0.001)


def test_another_driver_keeps_what_the_gripper_holds_and_how_hard(bench):
    bench.ready().hold(250, gripper=GripperCommand.CLOSED)
    cell = bench.cell.cell
    force_n = cell.model.actuator_forcerange[cell.grip].copy()
    bench.driver.stop()
    bench.run(100)
    bench.driver = SimulatedDriver(bench.memory, bench.clock)
    bench.driver.configure(replace(SETUP, grip_force_n=1.0))
    bench.driver.activate(bench.driver.read().q)
    assert GRIPPER_COMMANDS[bench.memory.command.read()["gripper"]] is GripperCommand.KEEP
    bench.hold(250, gripper=GripperCommand.KEEP)
    assert bench.driver.read().gripper.opening_m == pytest.approx(0.0, abs=0.002)
    assert (cell.model.actuator_forcerange[cell.grip] == force_n).all()
    bench.hold(1, gripper=GripperCommand.CLOSED)
    assert cell.model.actuator_forcerange[cell.grip].max() == 1.0


def test_after_a_stop_only_activation_moves_the_arm(bench):
    bench.ready().hold(5)
    bench.driver.stop()
    bench.driver.stop()
    bench.run(2)
    assert bench.driver.read().fault.code is FaultCode.STOPPED
    with pytest.raises(DriverError, match="activate"):
        bench.driver.write(bench.command())
    bench.driver.activate(bench.driver.read().q)
    bench.run()
    assert bench.driver.read().fault is None
    bench.hold(2)


def test_ceasing_commands_are_told_as_the_watchdog(bench):
    bench.ready().hold(5)
    bench.run(80)
    reading = bench.driver.read()
    assert reading.fault.code is FaultCode.WATCHDOG
    assert reading.fault.native == "WATCHDOG"
    with pytest.raises(DriverError, match="watchdog"):
        bench.driver.write(bench.command())


def test_steps_that_are_caught_up_do_not_pass_for_silence(bench):
    bench.ready().hold(5)
    now_ns = bench.clock.now_ns()
    bench.driver.write(bench.command())
    for late in range(80, 0, -1):
        bench.cell.step(now_ns - 2_000_000 * late, now_ns)
    assert bench.driver.read().fault is None


def test_activation_elsewhere_is_refused_in_words(bench):
    bench.driver.configure(SETUP)
    bench.run()
    bench.driver.activate(ROBOT.start + 0.2)
    bench.run()
    assert bench.driver.read().fault.code is FaultCode.APART


def test_another_arm_is_refused(bench):
    with pytest.raises(DriverError, match="6 joints"):
        bench.driver.configure(DriverSetup(("a", "b"), SETUP.limits, 0.004, 100_000_000))
