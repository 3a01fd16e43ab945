"""The recorder of a local site: keeps what passes its links, and tells the console of this host that it does."""

from collections.abc import Iterator
from functools import cache, partial
from importlib.metadata import version
from typing import Protocol

from foxglove_schemas_protobuf.CompressedImage_pb2 import CompressedImage

from common.clock import NS_PER_MS
from common.errors import MessageError
from common.link.channels import PREVIEW, STATE
from common.messages.base import PROTOCOL_VERSION
from common.messages.codec import decode
from common.messages.hand import HandArm
from common.messages.recording import RecordingNotice, RecordingState
from common.messages.robot import RobotState, SessionState
from common.messages.video import Codec, VideoFrame
from common.recording import foxglove
from common.recording.config import EpisodeBounds
from common.recording.episodes import Episodes
from common.recording.guarded import GuardedRecording
from common.recording.hand_transcript import HandTranscript, add_episode, add_log
from common.recording.session import RecordingSession
from common.recording.topics import Topic, protobuf_topic
from common.recording.wire_topics import topic_of
from local_site.config import LocalConfig
from local_site.recording.source import HeardMessage

NOTICE_NS = 200 * NS_PER_MS
OPERATOR_TABLE = "farhand.operator"
ENGAGED = (SessionState.ENGAGED, SessionState.HOLDING)


class Heard(Protocol):
    """What was heard, each message once, and how much was not taken in time."""

    lost: int

    def take(self) -> Iterator[HeardMessage]: ...


@cache
def view_topic(view: str) -> Topic:
    """The pictures of one of the operator's views."""
    return protobuf_topic(f"/operator/{view}", CompressedImage)


class OperatorRecorder:
    """Records from its first step on; engagements are the episodes. `notice` says so, several times a second."""

    def __init__(self, config: LocalConfig, recording: GuardedRecording, heard: Heard) -> None:
        self._config, self._recording, self._heard = config, recording, heard
        self._hands = HandTranscript(at_remote=False)
        self._episodes = Episodes(EpisodeBounds.ENGAGEMENT, config.record.task)
        self._said: tuple[str, str] | None = None
        self._notice_ns = -NOTICE_NS
        self._has_begun = False

    def step(self, now_ns: int) -> RecordingNotice | None:
        """Keep what has come; what to tell the console, if it is time."""
        if not self._has_begun:
            self._has_begun = True
            self._recording.begin(self._preamble, now_ns)
        for message in self._heard.take():
            self._recording.write(partial(self._keep, message=message))
        self._recording.write(lambda session: session.tend(now_ns))
        if now_ns - self._notice_ns < NOTICE_NS:
            return None
        self._notice_ns = now_ns
        return RecordingNotice(state=self.state())

    def end(self, now_ns: int) -> None:
        """End the recording in order."""
        self._recording.end(lambda session: self._finish(session, now_ns))

    def state(self) -> RecordingState:
        """What the recorder does."""
        episodes = self._episodes
        return RecordingState(
            writing=self._recording.session is not None,
            on_request=False,
            operator_pictures=self._config.record.operator_pictures,
            episode=episodes.number,
            episode_open=episodes.is_open,
            task=episodes.shown_task,
            outcome=episodes.outcome,
            lost=self._heard.lost,
            alarm=self._recording.alarm,
        )

    def _preamble(self, session: RecordingSession, _now_ns: int) -> None:
        config = self._config
        table = {"cell": config.cell, "operator": config.authority.name, "software": version("farhand")}
        session.describe(OPERATOR_TABLE, table | {"protocol": str(PROTOCOL_VERSION), "tracker": config.tracking.method})

    def _keep(self, session: RecordingSession, message: HeardMessage) -> None:
        topic, published_ns = topic_of(message.key, sent=message.sent), None
        try:
            if topic.schema.name.startswith(f"farhand.{HandArm.__name__}."):
                published_ns = self._hands.add(session, message.key, message.payload, message.t_ns)
            elif message.key == STATE.key_for(self._config.cell):
                self._follow(session, decode(message.payload, RobotState, STATE.max_bytes), message.t_ns)
            elif topic.schema.name.startswith(f"farhand.{VideoFrame.__name__}."):
                self._picture(session, decode(message.payload, VideoFrame, PREVIEW.max_bytes))
        except MessageError:
            add_log(session, message.t_ns, "refused", f"{message.key}: not a message of this release")
        session.add(topic, message.payload, message.t_ns, published_ns)

    def _follow(self, session: RecordingSession, state: RobotState, t_ns: int) -> None:
        for event in self._episodes.follow(engaged=state.state in ENGAGED, t_ns=t_ns):
            add_episode(session, event)
        said = state.state.value, state.code
        if said != self._said:
            self._said = said
            add_log(session, t_ns, "session", f"{said[0]} ({said[1]}): {state.reason}")

    def _picture(self, session: RecordingSession, frame: VideoFrame) -> None:
        if frame.data and frame.codec is Codec.JPEG:
            image = foxglove.jpeg_image(frame.capture_ns + session.epoch_ns, f"operator_{frame.camera}", frame.data)
            session.add(view_topic(frame.camera), image, frame.capture_ns)

    def _finish(self, session: RecordingSession, now_ns: int) -> None:
        for event in self._episodes.finish(now_ns):
            add_episode(session, event)
