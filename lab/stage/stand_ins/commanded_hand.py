"""The scripted operator's hand as it is commanded: its path so far, and the pose that asks for a posture of the arm."""

import time
from pathlib import Path
from typing import Any

import numpy as np

from common.geometry import Array, vector_from_rotation
from lab.stage.network.command_socket import send
from lab.stage.stand_ins.hand_path import ScriptedPath
from remote_site.config import RemoteConfig
from remote_site.kinematics.model import ArmModel


class CommandedHand:
    """The scripted operator of one local site, as it is commanded."""

    def __init__(self, socket: Path, config: RemoteConfig) -> None:
        """`socket` is where the scripted operator listens, `config` that of the remote site."""
        robot = config.robot
        self.model = ArmModel.from_urdf(robot.urdf, robot.tool_frame, robot.tool_T_tcp)
        self.path = ScriptedPath.still()
        self._socket, self._start, self._mapping = socket, robot.start, config.mapping

    def forget(self) -> None:
        """Forget an operator that has ended: the next one's hand is at home, and its socket says that it listens."""
        self._socket.unlink(missing_ok=True)
        self.path = ScriptedPath.still()

    def command(self, **fields: Any) -> None:
        """Command the hand, or what sees it; a motion begins now."""
        if "to" in fields:
            fields["begun_ns"] = time.monotonic_ns()
            self.path = self.path.then(fields)
        send(self._socket, **fields)

    def pose_of(self, q: Array) -> tuple[float, ...]:
        """Compute the hand's pose (m, rotation vector; operator frame) that asks for the tool's pose in a posture `q`.

        The arm's start is asked for by a hand at home.
        """
        start, now = (self.model.forward(posture) for posture in (self._start, q))
        base_R_operator: Array = np.array(self._mapping.base_R_operator)
        # The tool's motion in the base is R = base_R_operator times the hand's, the shift also times the scale. So the
        # hand's is R^T times the tool's, which is v @ R for a vector v.
        moved = (now[:3, 3] - start[:3, 3]) @ base_R_operator / self._mapping.scale
        turned = vector_from_rotation(now[:3, :3] @ start[:3, :3].T) @ base_R_operator
        return (*moved.tolist(), *turned.tolist())
