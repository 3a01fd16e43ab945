"""Straight-line tool motions of the simulated arm, sampled at the driver's rate."""

from collections.abc import Sequence
from itertools import pairwise

import numpy as np
from numpy.typing import NDArray

from common.geometry import Array
from remote_site.kinematics.config import RobotConfig
from remote_site.kinematics.model import ArmModel

RATE_HZ = 250
Stage = tuple[float, float, float, bool]  # forward, left, up in m from the start; gripper open

PICK_AND_PLACE: tuple[Stage, ...] = (
    (0.00, 0.00, 0.00, True),
    (0.00, 0.00, -0.16, True),
    (0.08, 0.00, -0.16, True),
    (0.08, 0.00, -0.16, False),
    (0.08, 0.00, -0.12, False),
    (0.08, -0.20, -0.12, False),
    (0.08, -0.20, -0.16, False),
    (0.08, -0.20, -0.16, True),
    (0.00, -0.20, -0.16, True),
    (0.00, 0.00, 0.00, True),
)


def arm_model(robot: RobotConfig) -> ArmModel:
    return ArmModel.from_urdf(robot.urdf, robot.tool_frame, robot.tool_T_tcp)


def sample(
    stages: Sequence[Stage], robot: RobotConfig, mean_speed_m_s: float
) -> tuple[Array, Array, Array, NDArray[np.bool_]]:
    """Joint positions, velocities, accelerations (N, n) and gripper (N,), minimum jerk between the stages."""
    points, gripper = [], []
    for before, after in pairwise(stages):
        start, end = np.array(before[:3]), np.array(after[:3])
        count = max(int(RATE_HZ * np.linalg.norm(end - start) / mean_speed_m_s), RATE_HZ // 2)
        u = np.arange(1, count + 1)[:, None] / count
        points.append(start + (end - start) * u**3 * (10 - 15 * u + 6 * u * u))
        gripper += [after[3]] * count
    q = _joints(np.concatenate(points), robot)
    dq = np.gradient(q, 1 / RATE_HZ, axis=0)
    return q, dq, np.gradient(dq, 1 / RATE_HZ, axis=0), np.array(gripper)


def _joints(offsets: Array, robot: RobotConfig) -> Array:
    model, q = arm_model(robot), robot.start
    start, joints = model.forward(q), []
    for offset in offsets:
        for _ in range(20):
            pose = model.forward(q)
            turn = 0.5 * sum(np.cross(pose[:3, k], start[:3, k]) for k in range(3))
            error = np.concatenate([start[:3, 3] + offset - pose[:3, 3], turn])
            if np.linalg.norm(error) < 1e-9:
                break
            q = q + np.linalg.solve(model.jacobian(q), error)
        joints.append(q)
    return np.array(joints)
