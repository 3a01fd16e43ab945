"""The operator's page as shown: pictures with their age and calibration, the session's state, the gripper."""

from collections.abc import Mapping
from dataclasses import dataclass

from common.cameras.camera import Image
from common.geometry import Array
from common.messages.robot import AssistState, GripperStatus, SessionState


@dataclass(frozen=True, slots=True)
class ShownView:
    """A view's newest picture (H, W, 3) BGR, its exposure by the operator's clock (ns), and its projection (3, 4).

    The projection is from the base's frame, or from the tool's (`on_tool`).
    """

    picture: Image
    capture_ns: int
    projection: Array
    on_tool: bool


@dataclass(frozen=True, slots=True)
class ShownPage:
    """The page at `t_ns`: the views by their names, the state with its reason, the gripper's opening (m) and status.

    `delay_s` is how long the hand's samples are on their way, as the page tells; `assist` is what it shows of fine
    adjustment, None where the cell has no targets for it.
    """

    t_ns: int
    views: Mapping[str, ShownView]
    state: SessionState
    code: str
    reason: str
    opening_m: float
    gripper: GripperStatus
    delay_s: float
    assist: AssistState | None = None
