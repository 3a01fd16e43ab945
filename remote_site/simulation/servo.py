"""The servos of the simulated robot: computed torque towards the controller's motion, and the gripper's drive."""

import math

import mujoco
import numpy as np

from common.geometry import Array
from remote_site.kinematics.joints import JointMotion
from remote_site.simulation.cell import Cell
from remote_site.simulation.config import CellConfig, GripperConfig

SLIDING_RAD_S = 0.02


class ArmServo:
    """Computed torque of an arm's joints; `q`, `dq` (n,) are live views of the measured rad and rad/s."""

    def __init__(self, config: CellConfig, cell: Cell, data: mujoco.MjData) -> None:
        self._model, self._data, self._arm = cell.model, data, cell.arm
        self._stiffness = (2.0 * math.pi * config.servo.bandwidth_hz) ** 2
        self._damping = 2.0 * math.sqrt(self._stiffness)
        self._coulomb, self._viscous = np.array(config.arm.coulomb_n_m), np.array(config.arm.viscous_n_m_s)
        self._acceleration, self._torque = np.zeros(cell.model.nv), np.zeros(cell.model.nv)
        self._before = JointMotion.at_rest(cell.start_q)
        self.q: Array = data.qpos[cell.arm]
        self.dq: Array = data.qvel[cell.arm]

    def drive(self, motion: JointMotion) -> None:
        """Set the torques (n,) in N·m that lead to where the motion is at the end of the step."""
        arm = self._arm
        error, rate = self._before.q - self.q, self._before.dq - self.dq
        self._acceleration[arm] = motion.ddq + self._damping * rate + self._stiffness * error
        mujoco.mj_mulM(self._model, self._data, self._torque, self._acceleration)
        friction = self._coulomb * np.tanh(motion.dq / SLIDING_RAD_S) + self._viscous * motion.dq
        self._data.ctrl[arm] = self._torque[arm] + self._data.qfrc_bias[arm] + friction
        self._before = motion


class GripperDrive:
    """The force-limited drive of the gripper's opening, a ramp between open and closed."""

    def __init__(self, config: GripperConfig, cell: Cell, data: mujoco.MjData) -> None:
        self._model, self._data, self._grip = cell.model, data, cell.grip
        self._config = config
        self._opening = config.max_opening_m

    def drive(self, is_open: bool) -> None:
        """Move on towards open or closed, for one step."""
        step = self._config.speed_m_s * self._model.opt.timestep
        aim = self._config.max_opening_m if is_open else 0.0
        self._opening += min(max(aim - self._opening, -step), step)
        self._data.ctrl[self._grip] = self._opening

    def limit_grip(self, force_n: float) -> None:
        """Close with no more than this force, nor than the gripper's own limit."""
        force = min(force_n, self._config.force_limit_n)
        self._model.actuator_forcerange[self._grip] = (-force, force)

    @property
    def opening_m(self) -> float:
        """The measured opening between the fingers."""
        return float(self._data.ten_length[0])

    @property
    def force_n(self) -> float:
        """The force with which the drive closes the fingers, 0 while it opens them."""
        return max(0.0, -float(self._data.actuator_force[self._grip]))
