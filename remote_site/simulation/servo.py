"""The joint servo of the simulated robot: computed torque towards the controller's motion, and the gripper's drive."""

import math

import mujoco
import numpy as np

from common.geometry import Array
from remote_site.kinematics.joints import JointMotion
from remote_site.simulation.cell import Cell
from remote_site.simulation.config import CellConfig

SLIDING_RAD_S = 0.02


class Servo:
    """Drives a cell's arm and gripper, one step of physics each call; `q`, `dq` (n,) are live views of the measured."""

    def __init__(self, config: CellConfig, cell: Cell, data: mujoco.MjData) -> None:
        self._model, self._data, self._cell = cell.model, data, cell
        self._stiffness = (2.0 * math.pi * config.servo.bandwidth_hz) ** 2
        self._damping = 2.0 * math.sqrt(self._stiffness)
        self._coulomb = np.array(config.arm.coulomb_n_m)
        self._viscous = np.array(config.arm.viscous_n_m_s)
        self._acceleration = np.zeros(cell.model.nv)
        self._torque = np.zeros(cell.model.nv)
        self._widest = config.gripper.max_opening_m
        self._strongest_n = config.gripper.force_limit_n
        self._opening_step = config.gripper.speed_m_s * cell.model.opt.timestep
        self._opening = self._widest
        self._before = JointMotion.at_rest(cell.start_q)
        arm = cell.arm
        self.q: Array = data.qpos[arm]
        self.dq: Array = data.qvel[arm]
        self._drives, self._bias = data.ctrl[arm], data.qfrc_bias[arm]

    def step(self, motion: JointMotion, gripper_open: bool) -> None:
        """Advance the physics to where the motion is at the step's end, within the URDF's effort limits."""
        data, cell = self._data, self._cell
        mujoco.mj_step1(self._model, data)
        self._drives[:] = self._arm_torque(motion)
        aim = self._widest if gripper_open else 0.0
        self._opening += min(max(aim - self._opening, -self._opening_step), self._opening_step)
        data.ctrl[cell.grip] = self._opening
        mujoco.mj_step2(self._model, data)
        self._before = motion

    def limit_grip(self, force_n: float) -> None:
        """Close with no more than this force, nor than the gripper's own limit."""
        force = min(force_n, self._strongest_n)
        self._model.actuator_forcerange[self._cell.grip] = (-force, force)

    @property
    def opening_m(self) -> float:
        """The measured opening between the fingers."""
        return float(self._data.ten_length[0])

    @property
    def force_n(self) -> float:
        """The force with which the drive closes the fingers, 0 while it opens them."""
        return max(0.0, -float(self._data.actuator_force[self._cell.grip]))

    def _arm_torque(self, motion: JointMotion) -> Array:
        arm = self._cell.arm
        error, rate = self._before.q - self.q, self._before.dq - self.dq
        self._acceleration[arm] = motion.ddq + self._damping * rate + self._stiffness * error
        mujoco.mj_mulM(self._model, self._data, self._torque, self._acceleration)
        friction = self._coulomb * np.tanh(motion.dq / SLIDING_RAD_S) + self._viscous * motion.dq
        torque: Array = self._torque[arm] + self._bias + friction
        return torque
