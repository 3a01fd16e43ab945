"""The tool as measured and where it has been sent, as JSON for pages, each with the time that it is of; pure."""

from typing import Any

import msgspec

from common.clock import NS_PER_MS, ClockOffset
from common.geometry import Array
from common.messages.hand import HandArm
from common.messages.robot import Pose, RobotState


def tools_json(
    state: RobotState | None, hand: HandArm | None, sent: Array | None, wanted: Array | None, remote: ClockOffset | None
) -> str:
    """Both poses with times by this host's clock in ms; None where one is not known.

    The measured tool is as old as the newest state, the target `sent` (4 x 4) as the newest hand sample;
    `wanted` (3,) is where that hand would have the tool, outside the box too.
    """
    measured = sent_to = None
    if state is not None and remote is not None:
        measured = _tool(state.base_T_tool, state.t_ns - remote.offset_ns)
    if sent is not None and hand is not None:
        sent_to = _tool(Pose.from_transform(sent), hand.capture_ns)
    where = None if wanted is None else wanted.tolist()
    return msgspec.json.encode({"type": "tools", "measured": measured, "sent": sent_to, "wanted": where}).decode()


def _tool(pose: Pose, t_ns: int) -> dict[str, Any]:
    return {"position": pose.position, "orientation": pose.orientation, "t_ms": t_ns / NS_PER_MS}
