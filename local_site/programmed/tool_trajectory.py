"""A path of the tool through time, and what the gripper does on it; pure."""

from dataclasses import dataclass, field
from typing import NamedTuple

import numpy as np
from scipy.spatial.transform import Rotation

from common.errors import ConfigError
from common.geometry import Array, rotation_from_vector, transform
from common.messages.robot import GripperCommand


class GripperAction(NamedTuple):
    """A command to the gripper where the path stands at `t_s`, and how long the tool rests then, s."""

    t_s: float
    command: GripperCommand
    dwell_s: float = 0.0


@dataclass(frozen=True, eq=False)
class ToolTrajectory:
    """Poses of the tool in the base frame at the times `t_s` (n,), which begin at 0 and rise: linear between them.

    `positions` (n, 3) in m; `orientations` (n, 4) are unit quaternions (x, y, z, w). `marks` are the times of the way
    points, at which a run in steps stops; `actions` are in the order of their times. ConfigError where it is no path.
    """

    t_s: Array
    positions: Array
    orientations: Array
    marks: tuple[float, ...] = ()
    actions: tuple[GripperAction, ...] = ()
    _rotations: Array = field(init=False, repr=False)
    _turns: Array = field(init=False, repr=False)  # (n - 1, 3) in rad, of the tool from each pose to the next

    def __post_init__(self) -> None:
        n = len(self.t_s)
        if n < 2 or self.t_s[0] != 0.0 or bool((np.diff(self.t_s) <= 0).any()):
            raise ConfigError("a path of the tool needs two times or more, from 0 and rising")
        if self.positions.shape != (n, 3) or self.orientations.shape != (n, 4):
            raise ConfigError(f"a path of {n} times needs as many positions and orientations")
        if not (np.isfinite(self.positions).all() and np.isfinite(self.orientations).all()):
            raise ConfigError("a path of the tool has a number that is not finite")
        poses = Rotation.from_quat(self.orientations)
        object.__setattr__(self, "_rotations", poses.as_matrix())
        object.__setattr__(self, "_turns", (poses[:-1].inv() * poses[1:]).as_rotvec())

    @property
    def duration_s(self) -> float:
        """The time of its last pose."""
        return float(self.t_s[-1])

    def base_T_tool(self, t_s: float) -> Array:
        """The tool's pose (4 x 4) at a time, that of the nearest end outside."""
        at_s = min(max(t_s, 0.0), self.duration_s)
        k = max(int(np.searchsorted(self.t_s, at_s)) - 1, 0)
        part = (at_s - self.t_s[k]) / (self.t_s[k + 1] - self.t_s[k])
        position = self.positions[k] + part * (self.positions[k + 1] - self.positions[k])
        return transform(self._rotations[k] @ rotation_from_vector(part * self._turns[k]), position)
