"""The golden messages; run this file once per protocol version to write their bytes under tests/golden."""

from pathlib import Path

import msgpack
import msgspec

from common.codec import encode
from common.messages import (
    PROTOCOL_VERSION,
    CameraStatus,
    Engagement,
    GripperState,
    HandArm,
    LoopTiming,
    Message,
    Obeyed,
    PointCovariances,
    Pose,
    Reply,
    Request,
    RobotState,
    SessionState,
    TrackingStatus,
    VideoFrame,
)

GOLDEN = Path(__file__).parents[1] / "golden"

HAND = HandArm(
    session=81985529216486895,
    seq=42,
    capture_ns=1_234_567_890_123,
    elbow=(0.603217, 0.434782, 0.476757),
    wrist=(0.43, 0.37, 0.67),
    index=(0.273696, 0.356765, 0.738445),
    thumb=None,
    status=TrackingStatus.TRACKED,
    reason="",
    thumb_inferred=False,
    hand_open=True,
    gripper_toggles=3,
    covariance=PointCovariances(
        elbow=(1.6e-5, -2e-6, 0.0, 1.2e-5, 1e-6, 9e-6),
        wrist=(4e-6, 0.0, 0.0, 4e-6, 0.0, 4e-6),
        index=(6e-6, 1e-6, -1e-6, 9e-6, 0.0, 5e-6),
    ),
)
POSE = Pose(position=(0.444, 0.0, 0.869), orientation=(0.0, 0.70710678, 0.0, 0.70710678))
STATE = RobotState(
    session=7,
    seq=1001,
    t_ns=1_234_567_899_999,
    state=SessionState.ENGAGED,
    code="following",
    reason="following the hand",
    joints=("joint_1", "joint_2"),
    q=(0.1, -0.2),
    q_commanded=(0.1001, -0.2002),
    base_T_tool=POSE,
    gripper=GripperState(opening=0.05, force=12.5, commanded_open=False),
    gripper_toggles_applied=1,
    obeyed=Obeyed(
        session=81985529216486895, seq=42, capture_ns=1_234_567_890_123, command_ns=1_234_567_901_000, motion_ns=None
    ),
    engagement=Engagement(number=1, hand_capture_ns=1_234_000_000_000, base_T_tool=POSE),
    rejected={"stale": 2},
    timing=LoopTiming(hz=250.0, late_p99_us=210.5, missed=0, ticks=5000, real_time=True),
)
VIDEO = VideoFrame(
    camera="front_high",
    seq=9,
    capture_ns=77,
    capture_estimated=False,
    status=CameraStatus.LIVE,
    reason="",
    width=640,
    height=480,
    jpeg=b"\xff\xd8\xff\xd9",
)
REQUEST = Request(id=5, deadline_ns=10**12)
REPLY = Reply(id=5, done=False, code="not_ready", reason="the robot is not ready")

VALID: dict[str, Message] = {"hand": HAND, "state": STATE, "video": VIDEO, "request": REQUEST, "reply": REPLY}


def broken() -> dict[str, bytes]:
    """Payloads that no receiver may take for a hand sample, each named reason.detail."""
    fields = msgspec.to_builtins(HAND)
    return {
        "version.newer": msgpack.packb(fields | {"version": PROTOCOL_VERSION + 1}),
        "version.older": msgpack.packb(fields | {"version": PROTOCOL_VERSION - 1}),
        "version.missing": msgpack.packb({k: v for k, v in fields.items() if k != "version"}),
        "version.text": msgpack.packb(fields | {"version": str(PROTOCOL_VERSION)}),
        "not_finite.nan": msgpack.packb(fields | {"wrist": (float("nan"), 0.0, 0.0)}),
        "not_finite.infinity": msgpack.packb(fields | {"elbow": (0.0, float("-inf"), 0.0)}),
        "not_finite.covariance": _with_covariance(fields, wrist=(float("nan"), 0.0, 0.0, 1e-6, 0.0, 1e-6)),
        "invalid.negative_variance": _with_covariance(fields, wrist=(1e-6, 0.0, 0.0, -1e-6, 0.0, 1e-6)),
        "invalid.short_covariance": _with_covariance(fields, wrist=(1e-6, 1e-6, 1e-6)),
        "invalid.covariance_of_no_point": _with_covariance(fields, palm=(1e-6, 0.0, 0.0, 1e-6, 0.0, 1e-6)),
        "invalid.unknown_field": msgpack.packb(fields | {"joint": 1}),
        "invalid.missing_field": msgpack.packb({k: v for k, v in fields.items() if k != "wrist"}),
        "invalid.short_vector": msgpack.packb(fields | {"wrist": (0.0, 1.0)}),
        "invalid.text_for_number": msgpack.packb(fields | {"seq": "42"}),
        "invalid.negative_sequence": msgpack.packb(fields | {"seq": -1}),
        "invalid.unknown_status": msgpack.packb(fields | {"status": "splendid"}),
        "malformed.truncated": encode(HAND)[:-7],
        "malformed.empty": b"",
        "malformed.trailing": encode(HAND) + b"\x00",
        "malformed.list": msgpack.packb([1, 2, 3]),
        "malformed.noise": bytes(range(255, 155, -1)),
        "malformed.extension": msgpack.packb({"version": msgpack.ExtType(1, b"x" * 8)}),
        "malformed.deep": b"\x91" * 2000,
        "oversized.padded": encode(HAND) + b"\x00" * 5000,
    }


def _with_covariance(fields: dict[str, object], **points: tuple[float, ...]) -> bytes:
    payload: bytes = msgpack.packb(fields | {"covariance": points})
    return payload


if __name__ == "__main__":
    for name, message in VALID.items():
        (GOLDEN / "valid" / f"{name}.msgpack").write_bytes(encode(message))
    for name, payload in broken().items():
        (GOLDEN / "broken" / f"{name}.msgpack").write_bytes(payload)
