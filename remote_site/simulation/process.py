"""The process of the simulated cell: physics and robot controller in real time until asked to end, after a stop."""

import time
from collections.abc import Callable

import mujoco
import numpy as np
import structlog

from common.clock import NS_PER_S
from common.errors import DriverError
from common.process.service import ask_for_real_time
from remote_site.kinematics.config import RobotConfig
from remote_site.simulation.cell import Cell, build_cell
from remote_site.simulation.config import CellConfig
from remote_site.simulation.controller import SimulatedController, controller_limits
from remote_site.simulation.memory import CellMemory
from remote_site.simulation.servo import ArmServo, GripperDrive

MAX_LATE_STEPS = 20
FIFO_PRIORITY = 40  # as a robot's own controller, but below the control loop


class SimulatedCell:
    """The cell and its robot controller, connected to shared memory; time comes in with each step."""

    def __init__(self, config: CellConfig, robot: RobotConfig, memory: CellMemory) -> None:
        self.cell = build_cell(config, robot)
        self.data = self.cell.start()
        self.dt: float = self.cell.model.opt.timestep
        self.controller = make_controller(self.cell, config)
        self._servo = ArmServo(config, self.cell, self.data)
        self._gripper = GripperDrive(config.gripper, self.cell, self.data)
        self._memory = memory
        self._command_count, self._command = 0, np.zeros((), dtype=memory.command.dtype)
        self._reading = np.zeros((), dtype=memory.reading.dtype)
        self._snapshot = np.zeros((), dtype=memory.snapshot.dtype)

    def step(self, due_ns: int, now_ns: int) -> None:
        """One period of control and physics, ending at `due_ns`; silence and setpoints are timed by `now_ns`.

        The two differ while late steps are made up for: the same setpoint then serves them all, and is not yet old.
        """
        memory, controller = self._memory, self.controller
        if memory.command.count != self._command_count:
            self._command_count, self._command = memory.command.count, memory.command.read()
        if controller.asked(self._command):
            setup = memory.setup.read()
            controller.activate(setup, self._command)
            self._gripper.limit_grip(float(setup["grip_force_n"]))
        motion = controller.tick(self._command, self._servo.q, now_ns, self.dt)
        before_s = self.data.time
        mujoco.mj_step1(self.cell.model, self.data)
        self._servo.drive(motion)
        self._gripper.drive(controller.gripper_open)
        mujoco.mj_step2(self.cell.model, self.data)
        if self.data.time < before_s:  # MuJoCo resets itself when its state is no longer finite
            raise DriverError(
                "the simulated cell's physics diverged; choose a shorter simulation.step_ms or a less stiff servo"
            )
        self._publish(due_ns)

    def _publish(self, t_ns: int) -> None:
        controller, servo, gripper = self.controller, self._servo, self._gripper
        self._reading[()] = (
            t_ns,
            controller.setpoints.obeyed_seq,
            controller.setpoints.obeyed_ns,
            controller.activation,
            controller.active,
            controller.resting,
            controller.fault,
            controller.gripper_open,
            gripper.opening_m,
            gripper.force_n,
            servo.q,
            servo.dq,
        )
        self._memory.reading.write(self._reading)
        self._snapshot[()] = (t_ns, self.data.qpos)
        self._memory.snapshot.write(self._snapshot)


def run_cell(
    config: CellConfig,
    robot: RobotConfig,
    memory: CellMemory,
    should_stop: Callable[[], bool],
    beat: Callable[[], None],
) -> None:
    """Run the cell at real time in this process until `should_stop`; then stop the arm, and return once it rests.

    Late steps are made up for; more than 40 ms of lateness is dropped, with a warning in the log.
    """
    cell = SimulatedCell(config, robot, memory)
    ask_for_real_time(FIFO_PRIORITY)
    period_ns = round(cell.dt * NS_PER_S)
    due_ns = time.monotonic_ns()
    while not (should_stop() and cell.controller.resting):
        if should_stop():
            cell.controller.stop()
        due_ns = _wait(due_ns + period_ns, MAX_LATE_STEPS * period_ns)
        cell.step(due_ns, time.monotonic_ns())
        beat()


def _wait(due_ns: int, most_ns: int) -> int:
    now_ns = time.monotonic_ns()
    if now_ns < due_ns:
        time.sleep((due_ns - now_ns) / NS_PER_S)
    elif now_ns > due_ns + most_ns:
        structlog.get_logger().warning("simulated cell lost time", late_ms=round((now_ns - due_ns) / 1e6))
        return now_ns
    return due_ns


def make_controller(cell: Cell, config: CellConfig) -> SimulatedController:
    """The robot controller of that cell; ModelError when the servo's configuration is for another number of joints."""
    ranges = np.array([cell.model.joint(name).range for name in cell.joints])
    limits = controller_limits(config.servo, cell.joints, ranges[:, 0], ranges[:, 1])
    return SimulatedController(config.servo, limits, cell.start_q)
