"""The topics of a cell's recording, and the structs of those that are JSON."""

import msgspec
from foxglove_schemas_protobuf.CameraCalibration_pb2 import CameraCalibration
from foxglove_schemas_protobuf.CompressedImage_pb2 import CompressedImage
from foxglove_schemas_protobuf.FrameTransform_pb2 import FrameTransform
from foxglove_schemas_protobuf.JointStates_pb2 import JointStates
from foxglove_schemas_protobuf.PoseInFrame_pb2 import PoseInFrame

from common.messages.robot import GripperCommand, GripperState
from common.recording.topics import MSGPACK, MessageSchema, Topic, json_topic, protobuf_topic

BASE, TOOL = "base_link", "tool"


class ActionCause(msgspec.Struct, frozen=True, kw_only=True):
    """The hand sample that an action follows: captured at `capture_ns` by the operator's clock, `born_ns` by ours."""

    session: int
    seq: int
    capture_ns: int
    born_ns: int


class SentAction(msgspec.Struct, frozen=True, kw_only=True):
    """What the robot was ordered in a cycle, after every limit: joints in rad by the order of /joints/commanded.

    `command` is its number and `sent_ns` when it was ordered. The robot had been given the motion of the command
    `written_command` at `written_ns` by then, the newest one. `cause` is null where no sample was followed.
    """

    command: int
    sent_ns: int
    q: list[float]
    gripper: GripperCommand
    cause: ActionCause | None
    written_command: int | None
    written_ns: int | None


MEASURED = protobuf_topic("/joints/measured", JointStates, unit="rad, rad/s")
COMMANDED = protobuf_topic("/joints/commanded", JointStates, unit="rad, rad/s, rad/s2")
WRITTEN = protobuf_topic("/joints/written", JointStates, unit="rad, rad/s, rad/s2")
TOOL_MEASURED = protobuf_topic("/tool/measured", PoseInFrame, unit="m")
TOOL_TARGET = protobuf_topic("/tool/target", PoseInFrame, unit="m")
TRANSFORMS = protobuf_topic("/tf", FrameTransform, unit="m")
ACTION = json_topic("/action", SentAction)
GRIPPER = json_topic("/gripper", GripperState, unit="m, N")
CYCLE_INPUT = Topic("/cycle/input", MSGPACK, MessageSchema("farhand.CycleInput"))
CYCLE_OUTCOME = Topic("/cycle/outcome", MSGPACK, MessageSchema("farhand.CycleOutcome"))


def image_topic(camera: str) -> Topic:
    """The pictures of a camera in full quality."""
    return protobuf_topic(f"/camera/{camera}", CompressedImage)


def calibration_topic(camera: str) -> Topic:
    """The calibration of a camera."""
    return protobuf_topic(f"/camera/{camera}/calibration", CameraCalibration)


def camera_frame_name(camera: str) -> str:
    """The frame of a camera."""
    return f"camera_{camera}"
