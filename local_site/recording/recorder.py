"""The recorder of a local site: keeps what passes its links, tells this host's console that it does; and its loop."""

import time
from collections.abc import Callable, Iterator
from datetime import datetime
from functools import lru_cache, partial
from importlib.metadata import version
from typing import Protocol

import structlog
from foxglove_schemas_protobuf.CompressedImage_pb2 import CompressedImage

from common.clock import NS_PER_MS, NS_PER_S
from common.errors import MessageError
from common.link.channels import PREVIEW, RECORDER, STATE
from common.link.credentials import check_links
from common.messages.base import PROTOCOL_VERSION
from common.messages.codec import decode
from common.messages.hand import HandArm
from common.messages.recording import RecordingNotice, RecordingState
from common.messages.requests import RecordRequest
from common.messages.robot import FOLLOWING, RobotState
from common.messages.video import Codec, VideoFrame
from common.process.service import StopFlag, notify
from common.recording import foxglove
from common.recording.asked_recording import AskedRecording
from common.recording.awaited_site import AwaitedSite
from common.recording.guarded import GuardedRecording
from common.recording.hand_transcript import HandTranscript, add_log
from common.recording.session import RecordingPlan, RecordingSession
from common.recording.topics import Topic, protobuf_topic
from common.recording.wire_topics import topic_of
from local_site.calibration.control_points import CAMERAS
from local_site.config import LocalConfig
from local_site.recording.source import HeardMessage, OperatorSource

NOTICE_NS = 200 * NS_PER_MS
SITE_GONE_NS = 5 * NS_PER_S  # as long as a lease lasts without its local site
OPERATOR_TABLE = "farhand.operator"
POLL_S = 0.05


class Heard(Protocol):
    """The messages that were heard, each once, the orders among them, and how many were not taken in time."""

    lost: int

    def take(self) -> Iterator[HeardMessage]: ...

    def orders(self) -> Iterator[RecordRequest]: ...

    def hear_views(self, *, wanted: bool) -> None: ...


@lru_cache(len(CAMERAS))
def view_topic(view: str) -> Topic:
    """The pictures of one of the operator's views."""
    return protobuf_topic(f"/operator/{view}", CompressedImage)


class OperatorRecorder:
    """Keeps what is heard, at once or once the operator asks for it. `notice` says so, several times a second.

    What was asked for ends when the local site has been silent for SITE_GONE_NS: it is not of the site's next run.
    """

    def __init__(self, config: LocalConfig, recording: GuardedRecording, heard: Heard) -> None:
        pictures = config.record.operator_pictures
        self._config, self._heard = config, heard
        self._recording = AskedRecording(config.record, recording, operator_pictures=pictures)
        self._hands = HandTranscript(at_remote=False)
        self._said: tuple[str, str] | None = None
        self._notice_ns = -NOTICE_NS
        self._site_ns = -SITE_GONE_NS
        self._awaited = AwaitedSite("local", config.cell, config.links.listen)

    def step(self, now_ns: int) -> RecordingNotice | None:
        """Obey, keep what has come, flush; what to tell the console, if it is time."""
        recording = self._recording
        for order in self._heard.orders():
            given = order.task, order.outcome, order.note
            recording.obey(order.action, self._config.authority.name, now_ns, *given)
        if recording.is_due:
            self._begin(now_ns)
        self._keep()
        is_there = now_ns - self._site_ns <= SITE_GONE_NS
        self._awaited.note(is_there=is_there)
        if not is_there:
            recording.forget_requests()
        if recording.is_over:
            self.end(now_ns)
        self._heard.hear_views(wanted=recording.is_writing and self._config.record.operator_pictures)
        recording.tend(now_ns)
        if now_ns - self._notice_ns < NOTICE_NS:
            return None
        self._notice_ns = now_ns
        return RecordingNotice(state=self.state())

    def end(self, now_ns: int) -> None:
        """End the recording under way in order."""
        self._recording.end(now_ns)

    def state(self) -> RecordingState:
        """Return what the recorder does."""
        return self._recording.state(self._heard.lost)

    def _begin(self, now_ns: int) -> None:
        self._hands = HandTranscript(at_remote=False)
        self._said = None
        self._recording.begin(self._preamble, now_ns)

    def _keep(self) -> None:
        for message in self._heard.take():
            if message.sent:
                self._site_ns = message.t_ns
            self._recording.write(partial(self._write, message=message))

    def _preamble(self, session: RecordingSession, _now_ns: int) -> None:
        config = self._config
        table = {"cell": config.cell, "operator": config.authority.name, "software": version("farhand")}
        session.describe(OPERATOR_TABLE, table | {"protocol": str(PROTOCOL_VERSION), "tracker": config.tracking.method})

    def _write(self, session: RecordingSession, message: HeardMessage) -> None:
        topic, published_ns = topic_of(message.key, sent=message.sent), None
        try:
            if topic.schema.name.startswith(f"farhand.{HandArm.__name__}."):
                published_ns = self._hands.add(session, message.key, message.payload, message.t_ns)
            elif message.key == STATE.key_for(self._config.cell):
                self._follow(session, decode(message.payload, RobotState, STATE.max_bytes), message.t_ns)
            elif topic.schema.name.startswith(f"farhand.{VideoFrame.__name__}."):
                self._picture(session, decode(message.payload, VideoFrame, PREVIEW.max_bytes), message.t_ns)
        except MessageError:
            add_log(session, message.t_ns, "refused", f"{message.key}: not a message of this release")
        session.add(topic, message.payload, message.t_ns, published_ns)

    def _follow(self, session: RecordingSession, state: RobotState, t_ns: int) -> None:
        self._recording.follow(session, engaged=state.state in FOLLOWING, t_ns=t_ns)
        said = state.state.value, state.code
        if said != self._said:
            self._said = said
            add_log(session, t_ns, "session", f"{said[0]} ({said[1]}): {state.reason}")

    def _picture(self, session: RecordingSession, frame: VideoFrame, t_ns: int) -> None:
        if frame.data and frame.codec is Codec.JPEG:
            captured = session.since_1970_ns(frame.capture_ns)
            image = foxglove.jpeg_image(captured, f"operator_{frame.camera}", frame.data)
            session.add(view_topic(frame.camera), image, t_ns, frame.capture_ns)


def record_operator(
    config: LocalConfig, plan: RecordingPlan, date: Callable[[], datetime], should_stop: StopFlag
) -> None:
    """Record what passes the local site's links until asked to stop; FarhandError where they cannot be opened."""
    check_links((config.links.remote, config.links.listen), config.links, config.bearer)
    with OperatorSource(config) as source:
        notices = source.link.publisher(RECORDER, config.cell, operator=config.authority.name)
        recorder = OperatorRecorder(config, GuardedRecording(plan, date), source)
        notify("READY=1")
        structlog.get_logger().info("ready", cell=config.cell)
        while not should_stop():
            notice = recorder.step(time.monotonic_ns())
            if notice is not None:
                notices.put(notice)
            notify("WATCHDOG=1")
            should_stop.wait(POLL_S)
        notify("STOPPING=1")
        recorder.end(time.monotonic_ns())
