"""The teleoperator itself, with the names and types that LeRobot asks for."""

from typing import Any

import zenoh
from lerobot.teleoperators.teleoperator import Teleoperator
from lerobot.utils.errors import DeviceAlreadyConnectedError, DeviceNotConnectedError

from lerobot_teleoperator_farhand.config import JOINTS, FarhandTeleopConfig
from lerobot_teleoperator_farhand.feed import StateFeed

TOOL_AXES = "tool.x", "tool.y", "tool.z", "tool.qx", "tool.qy", "tool.qz", "tool.qw"
GRIPPER = "gripper.pos"


class FarhandTeleop(Teleoperator):
    """What an operator's bare hand commands a Farhand cell, as actions.

    `get_action` raises StaleDataError rather than give what is not live. Nothing is sent to the cell: who operates it,
    when the arm follows, and how it is stopped remain Farhand's.
    """

    config_class = FarhandTeleopConfig
    name = "farhand"

    def __init__(self, config: FarhandTeleopConfig) -> None:
        super().__init__(config)
        self.config = config
        self._feed: StateFeed | None = None

    @property
    def action_features(self) -> dict[str, type]:
        """Joints in rad or the tool's pose in m and a quaternion, and the gripper: all floats."""
        config = self.config
        names = [f"{joint}.pos" for joint in config.joints] if config.action == JOINTS else list(TOOL_AXES)
        return dict.fromkeys([*names, *[GRIPPER] * config.gripper], float)

    @property
    def feedback_features(self) -> dict[str, type]:
        """None: a bare hand feels nothing."""
        return {}

    @property
    def is_connected(self) -> bool:
        """Whether the session is open; a link that is interrupted shows in `get_action`."""
        return self._feed is not None

    def connect(self, calibrate: bool = True) -> None:  # noqa: ARG002  # cameras are calibrated at the operator's site
        """Open the session, and check that the cell has the configured joints; ConnectionError with the cure."""
        if self._feed is not None:
            raise DeviceAlreadyConnectedError(f"{self} is connected already")
        config = self.config
        try:
            feed = StateFeed(config.cell, config.remote, config.ca, config.certificate, config.key)
        except zenoh.ZError as error:
            raise ConnectionError(f"no link to {config.remote}: {error}; is the remote site running there?") from error
        try:
            self._check(feed.joint_names(config.connect_timeout_s))
        except BaseException:
            feed.close()
            raise
        self._feed = feed

    @property
    def is_calibrated(self) -> bool:
        """Always: the operator's cameras are calibrated at the operator's site."""
        return True

    def calibrate(self) -> None:
        """Nothing is to be done here."""

    def configure(self) -> None:
        """Nothing is to be done here."""

    def get_action(self) -> dict[str, float]:
        """What the hand commands now: while the arm does not follow, where it rests; StaleDataError with the reason."""
        config, state = self.config, self._connected().live(self.config.max_age_ms)
        values = list(state.q if config.action == JOINTS else state.tool)
        if config.gripper:
            if state.is_open is None:
                raise RuntimeError("the cell has no gripper that is measured: set gripper=false")
            values.append(config.gripper_open if state.is_open else config.gripper_closed)
        return dict(zip(self.action_features, values, strict=True))

    def send_feedback(self, feedback: dict[str, Any]) -> None:
        """Takes none; ValueError for any."""
        self._connected()
        if feedback:
            raise ValueError(f"a bare hand feels nothing: {', '.join(feedback)} cannot be sent")

    def disconnect(self) -> None:
        """Close the session."""
        self._connected().close()
        self._feed = None

    def _connected(self) -> StateFeed:
        if self._feed is None:
            raise DeviceNotConnectedError(f"{self} is not connected: call connect() first")
        return self._feed

    def _check(self, of_cell: list[str]) -> None:
        given = self.config.joints
        if self.config.action == JOINTS and given != of_cell:
            raise ConnectionError(f"the cell has the joints {', '.join(of_cell)}, not {', '.join(given)}: set joints")
