"""Messages for a page, for screenshots and tests: a cell, its robot's states, its cameras' pictures."""

import time

import msgspec
import numpy as np

from common.clock import NS_PER_MS
from common.messages.hand import ClockSync, HandArm, OperatorSettings, TrackingStatus
from common.messages.requests import Description
from common.messages.robot import (
    GripperCommand,
    GripperState,
    GripperStatus,
    LeaseState,
    LoopTiming,
    Obeyed,
    Pose,
    Readiness,
    RobotState,
    SessionState,
)
from common.messages.video import CameraStatus, Codec, VideoFrame
from remote_site.config import RemoteConfig
from remote_site.kinematics.limits import JointLimits
from remote_site.kinematics.model import ArmModel
from remote_site.runtime.request_server import describe
from remote_site.video.config import VideoConfig
from remote_site.video.streaming.pictures import encode_jpeg

CONFIG = RemoteConfig(video=VideoConfig(calibrated=True))
MODEL = ArmModel.from_urdf(CONFIG.robot.urdf, CONFIG.robot.tool_frame, CONFIG.robot.tool_T_tcp)
CAMERAS = tuple(camera.name for camera in CONFIG.video.cameras)
SIZE = (480, 640)


def cell(*, held: bool = True) -> Description:
    """The A465's cell, its views calibrated."""
    described = describe(CONFIG, MODEL, JointLimits.from_model(MODEL, CONFIG.robot))
    return msgspec.structs.replace(described, held=held)


def state(word: SessionState, code: str, reason: str, **changes: object) -> RobotState:
    """The robot's state now, 0.006 rad short of what is commanded, as an arm under way is."""
    now_ns = time.monotonic_ns()
    q = CONFIG.robot.start
    known = RobotState(
        session=1,
        seq=1,
        t_ns=now_ns,
        state=word,
        code=code,
        reason=reason,
        age_limit_ms=100.0,
        speed_scale=1.0,
        q=tuple(q.tolist()),
        q_commanded=tuple((q + 0.006).tolist()),
        base_T_tool=Pose.from_transform(MODEL.forward(q)),
        gripper=GripperState(opening=0.05, force=12.0, commanded=GripperCommand.CLOSED, status=GripperStatus.HOLDING),
        gripper_toggles_applied=1,
        gripper_next=GripperCommand.OPEN,
        obeyed=Obeyed(7, now_ns, now_ns - 60 * NS_PER_MS, now_ns - 25 * NS_PER_MS, now_ns - 20 * NS_PER_MS),
        engagement=None,
        rejected={},
        timing=LoopTiming(250.0, 100.0, 0, 1, True),
        lease=LeaseState(5, "anna", 7, now_ns + 5000 * NS_PER_MS, None),
        clock=ClockSync(remote_minus_local_ns=0, uncertainty_ns=NS_PER_MS, measured_ns=now_ns),
        readiness=Readiness(True, "ok", "ready", True),
        min_distance=0.21,
        target=Pose.from_transform(MODEL.forward(q + 0.02)) if word is SessionState.ENGAGED else None,
        settings=OperatorSettings(lease=5),
    )
    return msgspec.structs.replace(known, **changes)


def hand() -> HandArm:
    """A tracked hand, now."""
    return HandArm(
        session=7,
        seq=1,
        capture_ns=time.monotonic_ns() - 30 * NS_PER_MS,
        elbow=(0.0, 0.2, 0.3),
        wrist=(0.0, 0.0, 0.3),
        index=None,
        thumb=None,
        status=TrackingStatus.TRACKED,
        reason="",
        thumb_inferred=False,
        hand_open=False,
        gripper_toggles=1,
    )


def picture(
    camera: str, seq: int, jpeg: bytes, status: CameraStatus = CameraStatus.LIVE, reason: str = "", age_ms: float = 20.0
) -> VideoFrame:
    """A picture of this age; only its metadata without bytes."""
    return VideoFrame(
        camera=camera,
        seq=seq,
        capture_ns=time.monotonic_ns() - round(age_ms * NS_PER_MS),
        capture_estimated=False,
        status=status,
        reason=reason,
        width=SIZE[1],
        height=SIZE[0],
        codec=Codec.JPEG,
        key=bool(jpeg),
        data=jpeg,
    )


def plain(level: int) -> bytes:
    """A picture all of one grey."""
    return encode_jpeg(np.full((*SIZE, 3), level, np.uint8), 80)
