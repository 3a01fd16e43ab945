"""States of a remote site as a run over a link would leave them."""

from collections.abc import Sequence

import numpy as np

from common.geometry import Array
from common.messages.robot import (
    Engagement,
    GripperCommand,
    LoopTiming,
    Obeyed,
    Pose,
    Readiness,
    RobotState,
    SessionState,
)

MS = 1_000_000
STATE_NS = 20 * MS
UPRIGHT = (0.0, 0.0, 0.0, 1.0)
ORIGIN = (0.4, 0.0, 0.8)
CAPTURE_NS = 0
LETTERS = {
    "E": SessionState.ENGAGED,
    "H": SessionState.HOLDING,
    "D": SessionState.DISENGAGED,
}


def state(
    t_ns: int,
    session: SessionState = SessionState.ENGAGED,
    tool: Sequence[float] = ORIGIN,
    q: Sequence[float] = (0.0,),
    obeyed: Obeyed | None = None,
    ready: bool = True,
    origin: tuple[int, tuple[float, ...]] = (CAPTURE_NS, ORIGIN),
) -> RobotState:
    """A state at a time; `origin` is the time of the hand's and the tool's position."""
    (x, y, z), (captured_ns, (ox, oy, oz)) = tool, origin
    return RobotState(
        session=1,
        seq=t_ns // MS,
        t_ns=t_ns,
        state=session,
        code="ok",
        reason=f"{session.value}, as played",
        age_limit_ms=150.0,
        speed_scale=1.0,
        q=(),
        q_commanded=tuple(q),
        base_T_tool=Pose((x, y, z), UPRIGHT),
        gripper=None,
        gripper_toggles_applied=0,
        gripper_next=GripperCommand.CLOSED,
        obeyed=obeyed,
        engagement=Engagement(1, captured_ns, Pose((ox, oy, oz), UPRIGHT)),
        rejected={},
        timing=LoopTiming(250.0, 0.0, 0, 0, real_time=True),
        lease=None,
        clock=None,
        readiness=Readiness(ready, "ok", "as played", held=False),
    )


def played(letters: str, begin_ns: int = 0) -> list[RobotState]:
    """A state every 20 ms by its letter: E engaged, H holding, D disengaged."""
    return [state(begin_ns + k * STATE_NS, LETTERS[letter]) for k, letter in enumerate(letters)]


def wrist(t_ns: int) -> Array:
    """A hand on a circle of 50 mm, once in five seconds."""
    angle = 2 * np.pi * t_ns / 5e9
    return np.array([0.05 * np.cos(angle), 0.05 * np.sin(angle), 0.3])
