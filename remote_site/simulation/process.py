"""The process of the simulated cell: physics, servos and robot controller in real time until asked to end."""

import math
import time
from collections.abc import Callable

import mujoco
import numpy as np
import structlog

from common.clock import NS_PER_S
from common.errors import DriverError
from common.geometry import Array
from common.messages.robot import GripperCommand
from common.process.service import ask_for_real_time
from remote_site.kinematics.config import RobotConfig
from remote_site.kinematics.joints import JointMotion
from remote_site.simulation.cell import Cell, build_cell
from remote_site.simulation.config import CellConfig, GripperConfig
from remote_site.simulation.controller import SimulatedController, controller_limits
from remote_site.simulation.memory import CellCommand, CellMemory

MAX_LATE_STEPS = 20
STEPS_PER_WAKE = 2  # to be woken costs a process more than a step
FIFO_PRIORITY = 40  # as a robot's own controller, but below the control loop
SLIDING_RAD_S = 0.02


class ArmServo:
    """Computed torque of an arm's joints; `q`, `dq` (n,) are live views of the measured rad and rad/s."""

    def __init__(self, config: CellConfig, cell: Cell, data: mujoco.MjData) -> None:
        self._model, self._data, self._arm = cell.model, data, cell.arm
        stiffness = (2.0 * math.pi * config.servo.bandwidth_hz) ** 2
        self._stiffness_and_damping = stiffness, 2.0 * math.sqrt(stiffness)
        self._coulomb_and_viscous = np.array(config.arm.coulomb_n_m), np.array(config.arm.viscous_n_m_s)
        self._acceleration, self._torque = np.zeros(cell.model.nv), np.zeros(cell.model.nv)
        # Views: MuJoCo looks each array up anew.
        self._bias, self._ctrl = data.qfrc_bias[cell.arm], data.ctrl[cell.arm]
        self._before = JointMotion.at_rest(cell.start_q)
        self.q: Array = data.qpos[cell.arm]
        self.dq: Array = data.qvel[cell.arm]

    def drive(self, motion: JointMotion) -> None:
        """Set the torques (n,) in N·m that lead to where the motion is at the end of the step."""
        stiffness, damping = self._stiffness_and_damping
        error, rate = self._before.q - self.q, self._before.dq - self.dq
        self._acceleration[self._arm] = motion.ddq + damping * rate + stiffness * error
        mujoco.mj_mulM(self._model, self._data, self._torque, self._acceleration)
        coulomb, viscous = self._coulomb_and_viscous
        friction = coulomb * np.tanh(motion.dq / SLIDING_RAD_S) + viscous * motion.dq
        self._ctrl[:] = self._torque[self._arm] + self._bias + friction
        self._before = motion


class GripperDrive:
    """The force-limited drive of the gripper's opening, a ramp between open and closed; open at the start."""

    def __init__(self, config: GripperConfig, cell: Cell, data: mujoco.MjData) -> None:
        self._grip, self._ctrl, self._force_range = cell.grip, data.ctrl, cell.model.actuator_forcerange
        self._lengths, self._forces = data.ten_length, data.actuator_force
        self._config, self._step_m = config, config.speed_m_s * cell.model.opt.timestep
        self._aim = self._opening = config.max_opening_m
        self._force_n = config.force_limit_n

    def drive(self, command: GripperCommand) -> None:
        """Move on towards open or closed, for one step; with KEEP towards what was commanded before, as hard."""
        if command is not GripperCommand.KEEP:
            self._aim = self._config.max_opening_m if command is GripperCommand.OPEN else 0.0
            self._force_range[self._grip] = (-self._force_n, self._force_n)
        self._opening += min(max(self._aim - self._opening, -self._step_m), self._step_m)
        self._ctrl[self._grip] = self._opening

    def limit_grip(self, force_n: float) -> None:
        """From the next command on, close with no more than this force, nor than the gripper's own limit."""
        self._force_n = min(force_n, self._config.force_limit_n)

    @property
    def opening_m(self) -> float:
        """The measured opening between the fingers."""
        return float(self._lengths[0])

    @property
    def force_n(self) -> float:
        """The force with which the drive closes the fingers, 0 while it opens them."""
        return max(0.0, -float(self._forces[self._grip]))


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
        self._command_count, self._command = 0, CellCommand.of(memory.command.read())
        self._reading = np.zeros((), dtype=memory.reading.dtype)
        self._snapshot = np.zeros((), dtype=memory.snapshot.dtype)

    def step(self, due_ns: int, now_ns: int) -> None:
        """One period of control and physics, ending at `due_ns`; silence and setpoints are timed by `now_ns`.

        The two differ while late steps are made up for: the same setpoint then serves them all, and is not yet old.
        """
        memory, controller = self._memory, self.controller
        if memory.command.count != self._command_count:
            self._command_count, self._command = memory.command.count, CellCommand.of(memory.command.read())
        if controller.asked(self._command):
            setup = memory.setup.read()
            controller.activate(setup, self._command)
            self._gripper.limit_grip(float(setup["grip_force_n"]))
        motion = controller.tick(self._command, self._servo.q, now_ns, self.dt)
        before_s = self.data.time
        mujoco.mj_step1(self.cell.model, self.data)
        self._servo.drive(motion)
        self._gripper.drive(controller.gripper)
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
            gripper.opening_m,
            gripper.force_n,
            servo.q,
            servo.dq,
        )
        self._memory.reading.write(self._reading)
        self._snapshot[()] = (t_ns, self.data.qpos)
        self._memory.snapshot.write(self._snapshot)


def run_cell(cell: SimulatedCell, should_stop: Callable[[], bool], beat: Callable[[], None]) -> None:
    """Run the cell at real time in this process until `should_stop`; then stop the arm, and return once it rests.

    Late steps are made up for; more than 40 ms of lateness is dropped, with a warning in the log.
    """
    ask_for_real_time(FIFO_PRIORITY)
    period_ns = round(cell.dt * NS_PER_S)
    due_ns = time.monotonic_ns()
    while not (should_stop() and cell.controller.resting):
        if should_stop():
            cell.controller.stop()
        due_ns = _wait(due_ns + STEPS_PER_WAKE * period_ns, MAX_LATE_STEPS * period_ns)
        for left in reversed(range(STEPS_PER_WAKE)):
            cell.step(due_ns - left * period_ns, time.monotonic_ns())
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
