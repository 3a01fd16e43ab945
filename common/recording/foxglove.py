"""Messages in Foxglove's schemas, which Foxglove and Rerun show as they are; times are ns since the file's epoch."""

import struct
from collections.abc import Mapping, Sequence

from foxglove_schemas_protobuf.CameraCalibration_pb2 import CameraCalibration
from foxglove_schemas_protobuf.CompressedImage_pb2 import CompressedImage
from foxglove_schemas_protobuf.FrameTransform_pb2 import FrameTransform
from foxglove_schemas_protobuf.JointState_pb2 import JointState
from foxglove_schemas_protobuf.JointStates_pb2 import JointStates
from foxglove_schemas_protobuf.Log_pb2 import Log
from foxglove_schemas_protobuf.PackedElementField_pb2 import PackedElementField
from foxglove_schemas_protobuf.PointCloud_pb2 import PointCloud
from foxglove_schemas_protobuf.Pose_pb2 import Pose
from foxglove_schemas_protobuf.PoseInFrame_pb2 import PoseInFrame
from foxglove_schemas_protobuf.Quaternion_pb2 import Quaternion
from foxglove_schemas_protobuf.Vector3_pb2 import Vector3
from google.protobuf.message import Message
from google.protobuf.timestamp_pb2 import Timestamp

from common.clock import NS_PER_S
from common.geometry import Array, quaternion_from_rotation
from common.messages.base import Covariance
from common.messages.base import Vector3 as Point

POINT_FIELDS = ("x", "y", "z", "xx", "xy", "xz", "yy", "yz", "zz", "point")
POINT = struct.Struct("<10f")
UNKNOWN: Covariance = (float("nan"),) * 6
NO_TURN = Pose(orientation=Quaternion(w=1.0))
CLOUD_FIELDS = [
    PackedElementField(name=name, offset=4 * k, type=PackedElementField.FLOAT32) for k, name in enumerate(POINT_FIELDS)
]


def joint_states(t_ns: int, names: Sequence[str], q: Array, dq: Array | None, ddq: Array | None) -> bytes:
    """Joints (n,) by name: rad, rad/s, rad/s²; None where there is no such figure."""
    columns = [q.tolist(), *(a.tolist() if a is not None else [None] * len(names) for a in (dq, ddq))]
    joints = [
        JointState(name=name, position=position, velocity=velocity, acceleration=acceleration)
        for name, position, velocity, acceleration in zip(names, *columns, strict=True)
    ]
    return _bytes(JointStates(timestamp=_time(t_ns), joints=joints))


def pose_in_frame(t_ns: int, frame: str, frame_T_body: Array) -> bytes:
    """A pose (4 x 4) in a frame, m."""
    return _bytes(PoseInFrame(timestamp=_time(t_ns), frame_id=frame, pose=_pose(frame_T_body)))


def frame_transform(t_ns: int, parent: str, child: str, parent_T_child: Array) -> bytes:
    """Encode where a frame is (4 x 4) in another, m."""
    pose = _pose(parent_T_child)
    return _bytes(
        FrameTransform(
            timestamp=_time(t_ns),
            parent_frame_id=parent,
            child_frame_id=child,
            translation=pose.position,
            rotation=pose.orientation,
        )
    )


def points(t_ns: int, frame: str, named: Mapping[str, tuple[Point, Covariance | None]], order: Sequence[str]) -> bytes:
    """Points (m) with covariances (m²; NaN where unknown); `point` is the place of its name in the topic's order."""
    rows = (POINT.pack(*at, *(spread or UNKNOWN), order.index(name)) for name, (at, spread) in named.items())
    return _bytes(
        PointCloud(
            timestamp=_time(t_ns),
            frame_id=frame,
            pose=NO_TURN,
            point_stride=POINT.size,
            fields=CLOUD_FIELDS,
            data=b"".join(rows),
        )
    )


def jpeg_image(t_ns: int, frame: str, data: bytes) -> bytes:
    """A JPEG picture, exposed at this time by the camera of this frame."""
    return _bytes(CompressedImage(timestamp=_time(t_ns), frame_id=frame, data=data, format="jpeg"))


def calibration(t_ns: int, frame: str, size: tuple[int, int], pixels_T_camera: Array) -> bytes:
    """A camera without distortion: its size in pixels, and its matrix (3 x 3)."""
    k = pixels_T_camera.ravel().tolist()
    p = [*k[:3], 0.0, *k[3:6], 0.0, *k[6:], 0.0]
    turn = [1.0, 0.0, 0.0, 0.0, 1.0, 0.0, 0.0, 0.0, 1.0]
    (width, height), flat = size, [0.0] * 5
    return _bytes(
        CameraCalibration(
            timestamp=_time(t_ns),
            frame_id=frame,
            width=width,
            height=height,
            distortion_model="plumb_bob",
            D=flat,
            K=k,
            R=turn,
            P=p,
        )
    )


def log_line(t_ns: int, name: str, sentence: str) -> bytes:
    """A line of the log."""
    return _bytes(Log(timestamp=_time(t_ns), level=Log.INFO, name=name, message=sentence))


def _time(t_ns: int) -> Timestamp:
    seconds, nanos = divmod(t_ns, NS_PER_S)
    return Timestamp(seconds=seconds, nanos=nanos)


def _pose(frame_T_body: Array) -> Pose:
    x, y, z = frame_T_body[:3, 3].tolist()
    qx, qy, qz, qw = quaternion_from_rotation(frame_T_body[:3, :3]).tolist()
    return Pose(position=Vector3(x=x, y=y, z=z), orientation=Quaternion(x=qx, y=qy, z=qz, w=qw))


def _bytes(message: Message) -> bytes:
    data: bytes = message.SerializeToString()
    return data
