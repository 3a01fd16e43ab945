"""The golden messages; run this file once per protocol version to write their bytes under tests/golden."""

from pathlib import Path

import msgpack
import msgspec

from common.messages.base import PROTOCOL_VERSION, Message
from common.messages.codec import encode
from common.messages.hand import ClockSync, HandArm, Intent, Locks, OperatorIntent, PointCovariances, TrackingStatus
from common.messages.requests import (
    CameraDescription,
    ClockAnswer,
    ClockQuestion,
    DescribeQuestion,
    Description,
    EngagementAction,
    EngagementRequest,
    JointDescription,
    JointsRequest,
    LeaseAction,
    LeaseReply,
    LeaseRequest,
    OperatorAction,
    OperatorRequest,
    Reply,
    ViewCalibration,
)
from common.messages.robot import (
    Engagement,
    GripperState,
    GripperStatus,
    LeaseState,
    LoopTiming,
    Obeyed,
    Pose,
    Readiness,
    RobotState,
    SessionState,
    Traced,
)
from common.messages.video import CameraStatus, VideoFrame, ViewCame, ViewShown, ViewsShown

GOLDEN = Path(__file__).parents[2] / "golden"

INTENT = Intent(hold=True, clutch_count=2, scale=0.5, rotation_scale=0.25, locks=Locks(z=True, roll=True))
CLOCKS = ClockSync(remote_minus_local_ns=-3_600_000_000_123, uncertainty_ns=81_000, measured_ns=1_234_000_000)
HAND = HandArm(
    session=81985529216486895,
    seq=42,
    capture_ns=1_234_567_890_123,
    elbow=(0.603217, 0.434782, 0.476757),
    wrist=(0.43, 0.37, 0.67),
    index=(0.273696, 0.356765, 0.738445),
    thumb=None,
    palm=(0.391, 0.372, 0.694),
    status=TrackingStatus.TRACKED,
    reason="",
    thumb_inferred=False,
    hand_open=True,
    gripper_toggles=3,
    covariance=PointCovariances(
        elbow=(1.6e-5, -2e-6, 0.0, 1.2e-5, 1e-6, 9e-6),
        wrist=(4e-6, 0.0, 0.0, 4e-6, 0.0, 4e-6),
        index=(6e-6, 1e-6, -1e-6, 9e-6, 0.0, 5e-6),
        palm=(5e-6, 0.0, 0.0, 5e-6, 0.0, 7e-6),
    ),
    lease=1311768467463790321,
    clock=CLOCKS,
    intent=INTENT,
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
    gripper=GripperState(opening=0.05, force=12.5, commanded_open=False, status=GripperStatus.HOLDING),
    gripper_toggles_applied=1,
    obeyed=Obeyed(
        session=81985529216486895, seq=42, capture_ns=1_234_567_890_123, command_ns=1_234_567_901_000, motion_ns=None
    ),
    engagement=Engagement(number=1, hand_capture_ns=1_234_000_000_000, base_T_tool=POSE),
    rejected={"stale": 2},
    timing=LoopTiming(hz=250.0, late_p99_us=210.5, missed=0, ticks=5000, real_time=True),
    lease=LeaseState(1311768467463790321, "anna", 81985529216486895, 1_234_572_000_000, "ben"),
    clock=CLOCKS,
    readiness=Readiness(ready=True, code="ok", reason="the arm follows the hand", held=True),
    target=POSE,
    traced=Traced(81985529216486895, 41, 1_234_534_000_000, 1_234_567_001_000, 1_234_567_005_000, 1_234_567_030_000),
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
STOP = EngagementRequest(id=5, deadline_ns=10**12, operator="anna", action=EngagementAction.STOP)
LEASE = LeaseRequest(id=6, deadline_ns=10**12, action=LeaseAction.RENEW, session=7, operator="anna", lease=8)
LEASE_REPLY = LeaseReply(
    id=6, done=True, code="lease_held", reason="it is yours", lease=8, lasts_ns=5 * 10**9, holder="anna"
)
JOINTS = JointsRequest(id=10, deadline_ns=10**12, shoulder=(0.25, 0.375), elbow=(0.5, 0.5125), wrist=(0.65625, 0.4875))
OPERATE = OperatorRequest(id=9, deadline_ns=10**12, action=OperatorAction.GIVE)
PROJECTION = (-500.0, -320.0, 0.0, 900.0, 0.0, -240.0, 500.0, -100.0, 0.0, -1.0, 0.0, 2.0)
DESCRIPTION = Description(
    cell="cell",
    software="0.1.0",
    robot="a465",
    driver="kinematic",
    joints=(JointDescription("joint_1", -3.05, 3.05, 3.14, POSE, (0.0, 0.0, 1.0), False),),
    cameras=(
        CameraDescription("side", 640, 480, 30.0),
        CameraDescription("front", 640, 480, 30.0, ViewCalibration(PROJECTION, on_tool=False)),
    ),
    held=True,
    control_hz=250.0,
    state_hz=50.0,
    last_T_tool=POSE,
    workspace_min=(0.1, -0.5, 0.0),
    workspace_max=(0.8, 0.5, 0.9),
)
REPLY = Reply(id=5, done=False, code="not_ready", reason="the robot is not ready")

SHOWN_VIEW = ViewShown(seq=7, capture_ns=9 * 10**8, age_ms=41.5, fps=27.7, came=ViewCame(seq=8, age_ms=24.0, fps=29.9))

VALID: dict[str, Message] = {
    "hand": HAND,
    "state": STATE,
    "video": VIDEO,
    "engagement": STOP,
    "reply": REPLY,
    "shown": ViewsShown(
        session=99,
        sent_ns=10**9,
        lease=1311768467463790321,
        views={"front_high": SHOWN_VIEW},
    ),
    "intent": OperatorIntent(sent_ns=10**9, intent=INTENT),
    "lease": LEASE,
    "lease_reply": LEASE_REPLY,
    "operate": OPERATE,
    "joints": JOINTS,
    "clock_question": ClockQuestion(),
    "clock": ClockAnswer(received_ns=10**9, answered_ns=10**9 + 50),
    "describe": DescribeQuestion(),
    "description": DESCRIPTION,
}


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
        "invalid.covariance_of_no_point": _with_covariance(fields, shoulder=(1e-6, 0.0, 0.0, 1e-6, 0.0, 1e-6)),
        "invalid.scale_of_nothing": _with_intent(fields, scale=0.0),
        "invalid.scale_too_large": _with_intent(fields, scale=50.0),
        "invalid.hold_as_number": _with_intent(fields, hold=1),
        "invalid.negative_clutch": _with_intent(fields, clutch_count=-1),
        "invalid.lock_of_no_axis": _with_intent(fields, locks={"w": True}),
        "invalid.negative_lease": msgpack.packb(fields | {"lease": -1}),
        "invalid.negative_uncertainty": msgpack.packb(fields | {"clock": fields["clock"] | {"uncertainty_ns": -1}}),
        "not_finite.scale": _with_intent(fields, scale=float("nan")),
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


def _with_intent(fields: dict[str, object], **changes: object) -> bytes:
    payload: bytes = msgpack.packb(fields | {"intent": fields["intent"] | changes})
    return payload


if __name__ == "__main__":
    for name, message in VALID.items():
        (GOLDEN / "valid" / f"{name}.msgpack").write_bytes(encode(message))
    for name, payload in broken().items():
        (GOLDEN / "broken" / f"{name}.msgpack").write_bytes(payload)
