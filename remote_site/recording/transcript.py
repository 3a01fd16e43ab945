"""From what control and video left in the rings to the messages of a recording."""

from functools import cache
from importlib.metadata import version
from typing import NamedTuple

import msgspec
import numpy as np
import structlog
from scipy.linalg import rq

from common.errors import MessageError
from common.geometry import Array, transform
from common.messages.base import PROTOCOL_VERSION
from common.messages.hand import HandArm
from common.messages.requests import ViewCalibration
from common.recording import foxglove
from common.recording.hand_transcript import OPERATOR_FRAME, HandTranscript, add_log
from common.recording.session import RecordingSession
from common.recording.wire_topics import topic_of
from remote_site.config import RemoteConfig
from remote_site.kinematics.model import ArmModel
from remote_site.recording import topics
from remote_site.recording.cycle_record import CycleOutcome, decode_input, decode_outcome
from remote_site.recording.kept_config import encode_config
from remote_site.recording.message_budget import KEPT_BYTES_PER_S
from remote_site.recording.records import FullPicture, LeftOut, PassedMessage, RecordedTick
from remote_site.teleop.cycle import CycleInput
from remote_site.video.calibration import calibration_of, size_of

CELL_TABLE = "farhand.cell"
CONFIG_FILE, URDF_FILE = "remote.json", "robot.urdf"
TICKS_PER_TRANSFORM = 5
image_topic = cache(topics.image_topic)


class CameraFrame(NamedTuple):
    """The camera's matrix (3 x 3), from its frame (z ahead, y down) to pixels; `parent_T_camera` (4 x 4)."""

    pixels_T_camera: Array
    parent_T_camera: Array


def camera_frame(view: ViewCalibration) -> CameraFrame:
    """The frame of a calibrated view, in the base's frame, or in the tool's where the camera rides on it."""
    projection = np.reshape(view.projection, (3, 4))
    projection = projection * np.sign(np.linalg.det(projection[:, :3]))
    upper, turn = rq(projection[:, :3])
    signs = np.diag(np.sign(np.diag(upper)))
    upper, turn = upper @ signs, signs @ turn
    moved = np.linalg.solve(upper, projection[:, 3])
    return CameraFrame(upper / upper[2, 2], transform(turn.T, -turn.T @ moved))


class Transcript:
    """Writes one cell's messages into its recording; the preamble goes into every file.

    `missing` counts the control cycles that did not come between the first and the last.
    """

    def __init__(self, config: RemoteConfig, model: ArmModel) -> None:
        self._config, self._model = config, model
        self._said: tuple[str, str] | None = None
        self._hands = HandTranscript(at_remote=True)
        self._measured_ns = self._written_ns = 0
        self._number = 0
        self.missing = 0

    def preamble(self, session: RecordingSession, now_ns: int) -> None:
        """Write what a reader needs to know, whichever file it opens: the cell, its configuration, its calibrations."""
        config, robot = self._config, self._config.robot
        table = {
            "cell": config.cell,
            "software": version("farhand"),
            "protocol": str(PROTOCOL_VERSION),
            "robot": robot.model,
            "driver": config.driver.name,
            "joints": ",".join(self._model.joint_names),
            "control_hz": str(config.control.rate_hz),
        }
        session.describe(CELL_TABLE, table)
        session.attach(CONFIG_FILE, "application/json", encode_config(config), now_ns)
        session.attach(URDF_FILE, "application/xml", robot.urdf.read_bytes(), now_ns)
        turned = transform(np.array(config.mapping.base_R_operator), np.zeros(3))
        self._transform(session, now_ns, topics.BASE, OPERATOR_FRAME, turned)
        for camera in config.video.cameras:
            view = calibration_of(camera, config.video, config.simulation, robot.tool_T_tcp)
            if view is None:
                continue
            name, size = topics.camera_frame_name(camera.name), size_of(camera, config.video)
            matrix, parent_T_camera = camera_frame(view)
            parent = topics.TOOL if view.on_tool else topics.BASE
            self._transform(session, now_ns, parent, name, parent_T_camera)
            kept = foxglove.calibration(session.since_1970_ns(now_ns), name, size, matrix)
            session.add(topics.calibration_topic(camera.name), kept, now_ns)

    def tick(self, session: RecordingSession, tick: RecordedTick) -> CycleOutcome | None:
        """A control cycle; its outcome, None where it cannot be read: the site is of another release."""
        session.add(topics.CYCLE_INPUT, tick.given, tick.t_ns)
        session.add(topics.CYCLE_OUTCOME, tick.outcome, tick.t_ns)
        try:
            given, outcome = decode_input(tick.given), decode_outcome(tick.outcome)
        except MessageError:
            return None
        self.missing += outcome.number - self._number - 1 if self._number else 0
        self._number = outcome.number
        self._joints(session, tick.t_ns, given, outcome)
        self._tool(session, tick.t_ns, given, outcome)
        self._action(session, tick.t_ns, outcome)
        said = outcome.state.value, outcome.reason.code.value
        if said != self._said:
            self._said = said
            add_log(session, tick.t_ns, "session", f"{said[0]} ({said[1]}): {outcome.reason.sentence}")
        return outcome

    def message(self, session: RecordingSession, passed: PassedMessage) -> None:
        """A message as it passed the wire; of a hand sample also what it shows."""
        topic, published_ns = topic_of(passed.key, sent=passed.sent), None
        if topic.schema.name.startswith(f"farhand.{HandArm.__name__}."):
            published_ns = self._hands.add(session, passed.key, passed.payload, passed.t_ns)
        session.add(topic, passed.payload, passed.t_ns, published_ns)

    def picture(self, session: RecordingSession, picture: FullPicture) -> None:
        """A picture in full quality, at its exposure."""
        t_ns, frame = picture.capture_ns, topics.camera_frame_name(picture.camera)
        image = foxglove.jpeg_image(session.since_1970_ns(t_ns), frame, picture.data)
        session.add(image_topic(picture.camera), image, t_ns)

    def left_out(self, session: RecordingSession, left: LeftOut) -> None:
        """Log what was not recorded of an operator, in the recording's log and in the recorder's."""
        who, size = left.operator or "senders without a name", f"{left.size / 1000:.0f} kB"
        why = f"at most {KEPT_BYTES_PER_S >> 10} kB a second of each are, beside the lease holder's hand samples"
        sentence = f"{left.messages} messages ({size}) of {who} are not recorded: {why}"
        add_log(session, left.t_ns, "left out", sentence)
        structlog.get_logger().warning("not all is recorded", reason=sentence)

    def _joints(self, session: RecordingSession, t_ns: int, given: CycleInput, outcome: CycleOutcome) -> None:
        names, since_1970_ns = self._model.joint_names, session.since_1970_ns
        if outcome.measured_ns != self._measured_ns:
            self._measured_ns = measured_ns = outcome.measured_ns
            data = foxglove.joint_states(since_1970_ns(measured_ns), names, given.robot.q, outcome.measured_dq, None)
            session.add(topics.MEASURED, data, t_ns, measured_ns)
        written, ordered = outcome.written, outcome.ordered
        if written is not None and written.t_ns != self._written_ns:
            self._written_ns = written.t_ns
            data = foxglove.joint_states(since_1970_ns(written.t_ns), names, written.q, written.dq, written.ddq)
            session.add(topics.WRITTEN, data, t_ns, written.t_ns)
        if ordered is not None:
            data = foxglove.joint_states(since_1970_ns(t_ns), names, ordered.q, ordered.dq, ordered.ddq)
            session.add(topics.COMMANDED, data, t_ns)

    def _tool(self, session: RecordingSession, t_ns: int, given: CycleInput, outcome: CycleOutcome) -> None:
        if outcome.number % TICKS_PER_TRANSFORM:
            return
        base_T_tool = self._model.forward(given.robot.q)
        pose = foxglove.pose_in_frame(session.since_1970_ns(outcome.measured_ns), topics.BASE, base_T_tool)
        session.add(topics.TOOL_MEASURED, pose, t_ns, outcome.measured_ns)
        self._transform(session, t_ns, topics.BASE, topics.TOOL, base_T_tool)
        if outcome.obeys is not None:
            target = foxglove.pose_in_frame(session.since_1970_ns(t_ns), topics.BASE, outcome.target)
            session.add(topics.TOOL_TARGET, target, t_ns)
        if given.robot.gripper is not None:
            session.add(topics.GRIPPER, msgspec.json.encode(given.robot.gripper), t_ns)

    def _action(self, session: RecordingSession, t_ns: int, outcome: CycleOutcome) -> None:
        ordered, written, obeys = outcome.ordered, outcome.written, outcome.obeys
        if ordered is None:
            return
        action = topics.SentAction(
            command=ordered.seq,
            sent_ns=ordered.t_ns,
            q=ordered.q.tolist(),
            gripper=ordered.gripper,
            cause=topics.ActionCause(**obeys._asdict()) if obeys is not None else None,
            written_command=written.seq if written is not None else None,
            written_ns=written.t_ns if written is not None else None,
        )
        session.add(topics.ACTION, msgspec.json.encode(action), t_ns)

    def _transform(
        self, session: RecordingSession, t_ns: int, parent: str, child: str, parent_T_child: np.ndarray
    ) -> None:
        data = foxglove.frame_transform(session.since_1970_ns(t_ns), parent, child, parent_T_child)
        session.add(topics.TRANSFORMS, data, t_ns)
