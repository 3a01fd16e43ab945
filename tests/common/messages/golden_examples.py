"""The golden messages; run this file once per protocol version to write their bytes under tests/golden."""

import struct
from pathlib import Path
from typing import Any, cast

import msgpack
import msgspec

from common.messages.base import PROTOCOL_VERSION, Covariance, Message
from common.messages.codec import encode
from common.messages.hand import (
    ClockSync,
    ClutchKey,
    HandArm,
    HandPoint,
    Intent,
    Locks,
    OperatorIntent,
    OperatorSettings,
    PointCovariances,
    TrackingStatus,
)
from common.messages.probe import Probe, ProbeEcho
from common.messages.recording import EpisodeOutcome, RecordingNotice, RecordingState
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
    MappingDescription,
    OperatorAction,
    OperatorRequest,
    RecordAction,
    RecordRequest,
    Reply,
    StopRequest,
    TroubleNoted,
    TroubleReport,
    ViewCalibration,
)
from common.messages.robot import (
    Asker,
    AssistPhase,
    AssistState,
    AssistTarget,
    Engagement,
    GripperCommand,
    GripperState,
    GripperStatus,
    HandLink,
    LeaseState,
    LoopTiming,
    MappingReference,
    Obeyed,
    Pose,
    Readiness,
    RobotState,
    RotationReference,
    SessionState,
    Traced,
    VideoLink,
)
from common.messages.shapes import BoxDescription, CapsuleDescription, GripperDescription, ShapesDescription
from common.messages.video import CameraStatus, Codec, KeyFrameRequest, VideoFrame, ViewCame, ViewShown, ViewsShown
from common.messages.wire_form import pack_covariance, unpack_covariance

GOLDEN = Path(__file__).parents[2] / "golden"


def _covariance(*m2: float) -> Covariance:
    """As exactly as a message has it."""
    return cast(Covariance, unpack_covariance(pack_covariance(m2)))


RECORDING = RecordingState(
    writing=True,
    on_request=True,
    operator_pictures=False,
    episode=3,
    episode_open=True,
    task="put the block on the mark",
    outcome=EpisodeOutcome.UNKNOWN,
    lost=0,
    alarm="",
    seconds=754.2,
    size_bytes=1_234_567_890,
    episode_seconds=41.5,
)
SETTINGS = OperatorSettings(
    lease=1311768467463790321, revision=2, scale=0.5, rotation_scale=0.25, locks=Locks(z=True, roll=True)
)
INTENT = Intent(hold=True, settings=SETTINGS, assist="block", clutch=ClutchKey.UNSEEN)
CLOCKS = ClockSync(
    remote_minus_local_ns=-3_600_000_000_123,
    uncertainty_ns=81_000,
    measured_ns=1_234_000_000,
    remote_ahead_ns=-270_927_093,
)
HAND = HandArm(
    session=81985529216486895,
    seq=42,
    capture_ns=1_234_567_890_123,
    elbow=(0.603515625, 0.4345703125, 0.4765625),
    wrist=(0.4296875, 0.3701171875, 0.669921875),
    index=(0.2734375, 0.3564453125, 0.73828125),
    thumb=None,
    palm=(0.390625, 0.3720703125, 0.6943359375),
    status=TrackingStatus.TRACKED,
    reason="",
    thumb_inferred=False,
    hand_open=True,
    gripper_toggles=3,
    covariance=PointCovariances(
        elbow=_covariance(1.6e-5, -2e-6, 0.0, 1.2e-5, 1e-6, 9e-6),
        wrist=_covariance(4e-6, 0.0, 0.0, 4e-6, 0.0, 4e-6),
        index=_covariance(6e-6, 1e-6, -1e-6, 9e-6, 0.0, 5e-6),
        palm=_covariance(5e-6, 0.0, 0.0, 5e-6, 0.0, 7e-6),
    ),
    lease=1311768467463790321,
    clock=CLOCKS,
    intent=INTENT,
    read_ns=1_234_590_000_000,
    sent_ns=1_234_597_890_123,
)
POSE = Pose(position=(0.4443359375, 0.0, 0.869140625), orientation=(0.0, 0.70703125, 0.0, 0.70703125))
STATE = RobotState(
    session=7,
    seq=1001,
    t_ns=1_234_567_899_999,
    state=SessionState.ENGAGED,
    code="following",
    reason="following the hand",
    age_limit_ms=100.0,
    speed_scale=1.0,
    q=(0.099609375, -0.2001953125),
    q_commanded=(0.1005859375, -0.2001953125),
    base_T_tool=POSE,
    gripper=GripperState(opening=0.05, force=12.5, commanded=GripperCommand.CLOSED, status=GripperStatus.HOLDING),
    gripper_toggles_applied=1,
    gripper_next=GripperCommand.OPEN,
    obeyed=Obeyed(
        session=81985529216486895, seq=42, capture_ns=1_234_567_890_123, command_ns=1_234_567_901_000, motion_ns=None
    ),
    engagement=Engagement(number=1, hand_capture_ns=1_234_000_000_000, base_T_tool=POSE),
    rejected={"stale": 2},
    timing=LoopTiming(hz=250.0, late_p99_us=210.5, missed=0, ticks=5000, real_time=True),
    lease=LeaseState(1311768467463790321, "anna", 81985529216486895, 1_234_572_000_000, Asker("ben", 8198552921648689)),
    clock=CLOCKS,
    readiness=Readiness(ready=True, code="ok", reason="the arm follows the hand", held=True),
    target=POSE,
    traced=Traced(81985529216486895, 41, 1_234_534_000_000, 1_234_567_001_000, 1_234_567_005_000, 1_234_567_030_000),
    settings=SETTINGS,
    reference=MappingReference(
        session=81985529216486895,
        seq=42,
        revision=2,
        offset=(0.6103515625, 0.1396484375, 0.5498046875),
        rotation=RotationReference(
            operator_R_hand=(0.0, 0.0, 0.599609375, 0.7998046875),
            base_R_tool=(0.0, 0.70703125, 0.0, 0.70703125),
            turn=(0.099609375, -0.2001953125, 3.599609375),
            base_R_locked=(0.0, 0.70703125, 0.0, 0.70703125),
        ),
    ),
    hand_link=HandLink(
        age_ms=310.5,
        network_ms=240.25,
        clock_ms=40.0,
        tracking_ms=30.25,
        interval_ms=33.5,
        jitter_ms=4.5,
        loss=0.0125,
        code="samples_old",
        reason="hand samples are too old",
    ),
    video_link=VideoLink(carries_mbit_s=1.8, needs_mbit_s=31.2, reason="the link carries 1.8 Mbit/s of pictures"),
    assist=AssistState(
        phase=AssistPhase.OFFERED,
        code="assist_offered",
        reason="hold A: the tool will move 12 mm and 3 deg to grasp 'block'",
        target=AssistTarget(
            name="block",
            kind="grasp",
            base_T_marker=Pose((0.625, 0.0, 0.75), (0.5, 0.5, 0.5, 0.5)),
            size=0.04,
            base_T_tool=Pose((0.5, 0.0, 0.75), (0.0, 1.0, 0.0, 0.0)),
            distance_mm=12.25,
            angle_deg=3.5,
            views=("front_high", "front_low"),
        ),
    ),
    recording=RECORDING,
    halted_ns=1_234_000_000_000,
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
    codec=Codec.JPEG,
    key=True,
    data=b"\xff\xd8\xff\xd9",
    ahead_ns=-270_927_093,
)
RESET = EngagementRequest(id=5, deadline_ns=10**12, action=EngagementAction.RESET, seen_ns=10**11)
LEASE = LeaseRequest(id=6, deadline_ns=10**12, action=LeaseAction.RENEW, session=7, lease=8)
LEASE_REPLY = LeaseReply(
    id=6,
    done=True,
    code="lease_held",
    reason="it is yours",
    lease=8,
    lasts_ns=5 * 10**9,
    holder="anna",
    holder_session=7,
)
JOINTS = JointsRequest(
    id=10, deadline_ns=10**12, shoulder=(0.25, 0.375), elbow=(0.5, 0.5126953125), wrist=(0.65625, 0.4873046875)
)
OPERATE = OperatorRequest(id=9, deadline_ns=10**12, action=OperatorAction.GIVE, to=Asker("ben", 8198552921648689))
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
    last_T_tool=POSE,
    workspace_min=(0.099609375, -0.5, 0.0),
    workspace_max=(0.7998046875, 0.5, 0.900390625),
    mapping=MappingDescription(
        point=HandPoint.WRIST,
        scale=0.8,
        scale_range=(0.0498046875, 2.0),
        base_R_operator=((0.0, -1.0, 0.0), (1.0, 0.0, 0.0), (0.0, 0.0, 1.0)),
        locks=Locks(yaw=True),
    ),
    shapes=ShapesDescription(
        capsules=(CapsuleDescription(1, (0.0, 0.0, 0.0), (0.0, 0.0, 0.25), 0.05),),
        fixtures=(BoxDescription("table", (0.5, -0.5, -0.25), (1.0, 0.5, 0.125)),),
        gripper=GripperDescription(0.003, 0.045),
    ),
)
RECORD = RecordRequest(
    id=6,
    deadline_ns=10**9,
    action=RecordAction.LABEL,
    task="put the block on the mark",
    outcome=EpisodeOutcome.SUCCESS,
    note="second try",
)
REPLY = Reply(id=5, done=False, code="not_ready", reason="the robot is not ready")

SHOWN_VIEW = ViewShown(seq=7, capture_ns=9 * 10**8, age_ms=41.5, fps=27.7, came=ViewCame(seq=8, age_ms=24.0, fps=29.9))

VALID: dict[str, Message] = {
    "hand": HAND,
    "state": STATE,
    "video": VIDEO,
    "engagement": RESET,
    "stop": StopRequest(),
    "reply": REPLY,
    "shown": ViewsShown(
        session=99,
        sent_ns=10**9,
        lease=1311768467463790321,
        h264=True,
        views={"front_high": SHOWN_VIEW},
    ),
    "key_frames": KeyFrameRequest(camera="side", after_seq=41),
    "intent": OperatorIntent(session=99, sent_ns=10**9, intent=INTENT),
    "lease": LEASE,
    "lease_reply": LEASE_REPLY,
    "operate": OPERATE,
    "record": RECORD,
    "recording": RecordingNotice(state=RECORDING),
    "joints": JOINTS,
    "clock_question": ClockQuestion(),
    "clock": ClockAnswer(received_ns=10**9, answered_ns=10**9 + 50, ahead_ns=-270_927_093),
    "describe": DescribeQuestion(),
    "description": DESCRIPTION,
    "trouble": TroubleReport(reason="UDP is blocked"),
    "trouble_noted": TroubleNoted(),
    "probe": Probe(session=98, seq=3, sent_ns=10**9, echo_bytes=600, padding=bytes(4)),
    "echo": ProbeEcho(
        session=98,
        seq=3,
        sent_ns=10**9,
        received_ns=9 * 10**8,
        answered_ns=9 * 10**8 + 50,
        received=4,
        padding=bytes(4),
    ),
}


def broken() -> dict[str, bytes]:
    """Payloads that no receiver may take for a hand sample, each named reason.detail."""
    nan, infinity, covariance = float("nan"), float("inf"), pack_covariance((4e-6, 0.0, 0.0, 4e-6, 0.0, 4e-6))
    return {
        "version.newer": _packed({}, PROTOCOL_VERSION + 1),
        "version.older": _packed({}, PROTOCOL_VERSION - 1),
        "version.text": _packed({}, str(PROTOCOL_VERSION)),
        "not_finite.nan": _packed({"wrist": _single(nan, 0.0, 0.0)}),
        "not_finite.infinity": _packed({"elbow": _single(0.0, -infinity, 0.0)}),
        "not_finite.scale": _packed({"intent.settings.scale": nan}),
        "invalid.correlation": _packed({"covariance.wrist": covariance[:-1] + b"\x80"}),
        "invalid.short_covariance": _packed({"covariance.wrist": covariance[:-1]}),
        "invalid.scale_of_nothing": _packed({"intent.settings.scale": 0.0}),
        "invalid.scale_too_large": _packed({"intent.settings.scale": 50.0}),
        "invalid.hold_as_number": _packed({"intent.hold": 1}),
        "invalid.unknown_clutch": _packed({"intent.clutch": len(ClutchKey)}),
        "invalid.clutch_as_flag": _packed({"intent.clutch": True}),
        "invalid.negative_revision": _packed({"intent.settings.revision": -1}),
        "invalid.locks_as_flags": _packed({"intent.settings.locks": 5}),
        "invalid.negative_lease": _packed({"lease": -1}),
        "invalid.negative_uncertainty": _packed({"clock.uncertainty_ns": -1}),
        "invalid.unknown_field": msgpack.packb([*msgpack.unpackb(encode(HAND)), 1]),
        "invalid.missing_field": msgpack.packb(msgpack.unpackb(encode(HAND))[:-1]),
        "invalid.short_vector": _packed({"wrist": _single(0.0, 1.0)}),
        "invalid.plain_vector": _packed({"wrist": (0.0, 1.0, 2.0)}),
        "invalid.text_for_number": _packed({"seq": "42"}),
        "invalid.negative_sequence": _packed({"seq": -1}),
        "invalid.unknown_status": _packed({"status": len(TrackingStatus)}),
        "invalid.status_in_words": _packed({"status": "tracked"}),
        "malformed.truncated": encode(HAND)[:-7],
        "malformed.empty": b"",
        "malformed.trailing": encode(HAND) + b"\x00",
        "malformed.map": msgpack.packb({"version": PROTOCOL_VERSION}),
        "malformed.noise": bytes(range(255, 155, -1)),
        "malformed.extension": msgpack.packb([msgpack.ExtType(1, b"x" * 8)]),
        "malformed.deep": b"\x91" * 2000,
        "oversized.padded": encode(HAND) + b"\x00" * 5000,
    }


def _packed(changes: dict[str, object], version: object = PROTOCOL_VERSION) -> bytes:
    """The hand sample with some places of its arrays changed; a place is named by the fields that lead to it."""
    fields = msgpack.unpackb(encode(HAND))[1:]
    for path, value in changes.items():
        array, part = fields, cast(Any, HAND)
        *outer, last = path.split(".")
        for name in outer:
            array, part = array[_place(part, name)], getattr(part, name)
        array[_place(part, last)] = value
    payload: bytes = msgpack.packb([version, *fields])
    return payload


def _place(part: msgspec.Struct, name: str) -> int:
    return part.__struct_fields__.index(name)


def _single(*numbers: float) -> bytes:
    return struct.pack(f"<{len(numbers)}f", *numbers)


if __name__ == "__main__":
    for name, message in VALID.items():
        (GOLDEN / "valid" / f"{name}.msgpack").write_bytes(encode(message))
    for name, payload in broken().items():
        (GOLDEN / "broken" / f"{name}.msgpack").write_bytes(payload)
