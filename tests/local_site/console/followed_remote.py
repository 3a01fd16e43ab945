"""The remote site's own mapping followed sample by sample, with the states that it publishes, and a hand's samples."""

from typing import Any

import numpy as np
from msgspec.structs import replace

from common.clock import NS_PER_MS, NS_PER_S
from common.geometry import Array, rotation_from_vector
from common.mapping.shown_hand import shown_orientation
from common.messages.codec import decode, encode
from common.messages.hand import HandArm, HandPoint, Intent, OperatorSettings, TrackingStatus
from common.messages.requests import Description
from common.messages.robot import Pose, RobotState, SessionState
from lab.measure.page import scene
from remote_site.config import RemoteConfig
from remote_site.kinematics.limits import JointLimits
from remote_site.kinematics.model import ArmModel
from remote_site.motion.config import ControlConfig
from remote_site.runtime.request_server import describe
from remote_site.safety.clearance import Workspace
from remote_site.session.samples import Accepted
from remote_site.teleop.config import MappingConfig
from remote_site.teleop.tool_target import ToolTarget

CONFIG = RemoteConfig()
MODEL = ArmModel.from_urdf(CONFIG.robot.urdf, CONFIG.robot.tool_frame, CONFIG.robot.tool_T_tcp)
LIMITS = JointLimits.from_model(MODEL, CONFIG.robot)
START = CONFIG.robot.start
BORN, PERIOD = 100 * NS_PER_S, 33 * NS_PER_MS
LEASE, SESSION = 5, 7
UNLEASHED = ControlConfig(leash_m=1.0, leash_deg=180.0)
WRIST = np.array([0.0, 0.0, 0.3])
INDEX, THUMB = np.array([0.09, -0.05, 0.02]), np.array([0.09, 0.05, 0.0])


def cell(mapping: MappingConfig, *, held: bool = False) -> Description:
    described = describe(replace(CONFIG, mapping=mapping), MODEL, LIMITS)
    return replace(described, held=held)


def sample(seq: int, moved: Any = (0.0, 0.0, 0.0), turn: Any = (0.0, 0.0, 0.0), **changes: Any) -> HandArm:
    """A hand that has moved and turned since the first; with `turn` None its thumb is hidden."""
    operator_R_hand = rotation_from_vector(np.array(turn if turn is not None else (0.0, 0.0, 0.0)))
    wrist = WRIST + np.array(moved)
    known = HandArm(
        session=SESSION,
        seq=seq,
        capture_ns=BORN + seq * PERIOD,
        elbow=None,
        wrist=tuple(wrist.tolist()),
        index=tuple((wrist + operator_R_hand @ INDEX).tolist()),
        thumb=tuple((wrist + operator_R_hand @ THUMB).tolist()) if turn is not None else None,
        palm=tuple((wrist + operator_R_hand @ np.array([0.03, 0.0, 0.01])).tolist()),
        status=TrackingStatus.TRACKED,
        reason="",
        thumb_inferred=False,
        hand_open=False,
        gripper_toggles=0,
        lease=LEASE,
        intent=Intent(hold=True, settings=OperatorSettings(lease=LEASE)),
    )
    return replace(known, **changes)


class Remote:
    """The remote site's own target, followed sample by sample, and the states that it publishes."""

    def __init__(self, mapping: MappingConfig, control: ControlConfig = UNLEASHED) -> None:
        box = Workspace(np.array(CONFIG.safety.workspace_min_m), np.array(CONFIG.safety.workspace_max_m))
        self.point = mapping.point
        self.tool = ToolTarget(mapping, control, box, MODEL, START)
        self.settings = OperatorSettings(lease=LEASE)
        self.engaged = False

    def follow(self, hand: HandArm) -> Array:
        """The target `base_T_tool` for a sample; the first is captured."""
        self.settings = self.settings.followed_by(hand.intent.settings if hand.intent is not None else None)
        in_force = self.tool.bounded(self.settings)
        shown = hand.palm if self.point is HandPoint.PALM else hand.wrist
        accepted = Accepted(hand, np.array(shown), shown_orientation(hand), hand.capture_ns, new_session=False)
        if not self.engaged:
            self.engaged = True
            self.tool.capture(accepted, in_force, START, 1)
        else:
            self.tool.aim(accepted, in_force, START, START, hand.capture_ns)
        return self.tool.base_T_tool

    def state(self, t_ns: int, **changes: Any) -> RobotState:
        """The state after the samples so far, as it comes over the wire."""
        known = replace(
            scene.state(SessionState.ENGAGED, "ok", ""),
            t_ns=t_ns,
            target=Pose.from_transform(self.tool.base_T_tool),
            settings=self.tool.bounded(self.settings),
            reference=self.tool.reference,
        )
        return decode(encode(replace(known, **changes)), RobotState, 16384)
