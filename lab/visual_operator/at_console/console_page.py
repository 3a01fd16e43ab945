"""The page as a console fills it: its messages taken as they come, and what is shown of them at an instant; pure."""

from collections.abc import Mapping

import cv2
import msgspec
import numpy as np
import simplejpeg

from common.cameras.camera import Image
from common.clock import NS_PER_MS, NS_PER_S
from common.messages.hand import OperatorSettings, TrackingStatus
from common.messages.requests import CameraDescription, Description
from common.messages.robot import AssistState, GripperStatus, SessionState
from common.messages.video import Codec
from lab.visual_operator.shown import ShownPage, ShownView

CAMERA_VIEW = "camera/"
LENGTH_BYTES, MS_PER_S = 2, 1e3


class _ShownGripper(msgspec.Struct):
    opening: float
    status: GripperStatus


class _Lease(msgspec.Struct):
    number: int
    holder: str


class _HandLink(msgspec.Struct):
    network_ms: float | None


class _Robot(msgspec.Struct):
    state: SessionState
    code: str
    reason: str
    silent: bool
    gripper: _ShownGripper | None
    lease: _Lease | None
    hand_link: _HandLink | None
    assist: AssistState | None


class _Hand(msgspec.Struct):
    status: TrackingStatus
    silent: bool


class _Seat(msgspec.Struct):
    page: int | None


class _Situation(msgspec.Struct):
    robot: _Robot | None
    hand: _Hand | None
    seat: _Seat
    settings: OperatorSettings | None


class _Hello(msgspec.Struct):
    page: int
    operator: str


class _Cell(msgspec.Struct):
    cell: Description


class _Echo(msgspec.Struct):
    server_ms: float


class _Kind(msgspec.Struct):
    type: str


class _Header(msgspec.Struct):
    view: str
    seq: int
    capture_ms: float | None
    codec: Codec


class PaintedView(msgspec.Struct, frozen=True):
    """The newest picture of a view as a page reports it: its number, its age when it came (ms), pictures a second."""

    seq: int
    age_ms: float
    fps: float


class ConsolePage:
    """The messages that a console has sent so far. Pictures of the operator are taken and not looked at.

    `heard_ms` is the console's time in its newest echo; each beat repeats it. `cell` is the description, None before it
    came; `settings` are those in force, or on their way; `painted` is what a
    page reports.
    """

    def __init__(self) -> None:
        self.heard_ms: float | None = None
        self.cell: Description | None = None
        self.painted: Mapping[str, PaintedView] = {}
        self._hello: _Hello | None = None
        self._situation: _Situation | None = None
        self._calibrated: dict[str, CameraDescription] = {}
        self._views: dict[str, ShownView] = {}

    @property
    def settings(self) -> OperatorSettings | None:
        """The operator's scales and locks; None while they are unknown."""
        return self._situation.settings if self._situation is not None else None

    def take_text(self, text: str) -> None:
        """Take a message in JSON; other kinds than these tell nothing that the operator looks at."""
        match msgspec.json.decode(text, type=_Kind).type:
            case "hello":
                self._hello = msgspec.json.decode(text, type=_Hello)
            case "echo":
                self.heard_ms = msgspec.json.decode(text, type=_Echo).server_ms
            case "cell":
                self._describe(msgspec.json.decode(text, type=_Cell).cell)
            case "situation":
                self._situation = msgspec.json.decode(text, type=_Situation)

    def take_picture(self, message: bytes, now_ns: int) -> str:
        """Take a message of a view, and the view's name, under which the console waits to hear that it is painted."""
        begin = LENGTH_BYTES + int.from_bytes(message[:LENGTH_BYTES], "little")
        header = msgspec.json.decode(message[LENGTH_BYTES:begin], type=_Header)
        camera, data = header.view.removeprefix(CAMERA_VIEW), message[begin:]
        of_cell = header.view.startswith(CAMERA_VIEW) and camera in self._calibrated
        if of_cell and data and header.codec is Codec.JPEG and header.capture_ms is not None:
            capture_ns = round(header.capture_ms * NS_PER_MS)
            picture = simplejpeg.decode_jpeg(data, colorspace="BGR")
            self._paint(self._calibrated[camera], np.asarray(picture, dtype=np.uint8), capture_ns, header.seq, now_ns)
        return header.view

    def shown(self, now_ns: int) -> ShownPage | None:
        """The page at a time; None until all that the operator needs is on it."""
        situation = self._situation
        if situation is None or situation.robot is None or set(self._views) != set(self._calibrated):
            return None
        robot, gripper = situation.robot, situation.robot.gripper
        network_ms = robot.hand_link.network_ms if robot.hand_link is not None else None
        return ShownPage(
            t_ns=now_ns,
            views=dict(self._views),
            state=robot.state,
            code=robot.code,
            reason=robot.reason,
            opening_m=gripper.opening if gripper is not None else 0.0,
            gripper=gripper.status if gripper is not None else GripperStatus.UNKNOWN,
            delay_s=(network_ms or 0.0) / MS_PER_S,
            assist=robot.assist,
        )

    def lacks(self) -> str:
        """Say what keeps the operator from beginning; empty once nothing does."""
        hello, situation = self._hello, self._situation
        if hello is None or situation is None or situation.seat.page != hello.page:
            return "the controls"
        robot, hand = situation.robot, situation.hand
        if robot is None or robot.silent:
            return "the robot's state"
        if robot.lease is None or robot.lease.holder != hello.operator or situation.settings is None:
            return "the lease"
        if not self._calibrated or set(self._views) != set(self._calibrated):
            return "pictures of every calibrated view"
        tracked = hand is not None and not hand.silent and hand.status is TrackingStatus.TRACKED
        return "" if tracked else "a hand that is tracked"

    def _describe(self, cell: Description) -> None:
        self.cell = cell
        self._calibrated = {camera.name: camera for camera in cell.cameras if camera.calibration is not None}

    def _paint(self, camera: CameraDescription, picture: Image, capture_ns: int, seq: int, now_ns: int) -> None:
        """Show a picture in its full size: over a narrow link it comes smaller."""
        before, calibration = self._views.get(camera.name), camera.calibration
        if calibration is None:
            return
        size = camera.width, camera.height
        if picture.shape[1::-1] != size:
            picture = np.asarray(cv2.resize(picture, size, interpolation=cv2.INTER_LINEAR), dtype=np.uint8)
        apart_ns = capture_ns - before.capture_ns if before is not None else 0
        fps = NS_PER_S / apart_ns if apart_ns > 0 else 0.0
        painted = PaintedView(seq, max(0, now_ns - capture_ns) / NS_PER_MS, fps)
        self.painted = {**self.painted, CAMERA_VIEW + camera.name: painted}
        projection = np.reshape(calibration.projection, (3, 4))
        self._views[camera.name] = ShownView(picture, capture_ns, projection, calibration.on_tool)
