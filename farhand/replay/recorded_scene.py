"""An operator's page out of a recording: states, hand samples and pictures, in the order of their times."""

import re
from collections.abc import Iterable, Iterator
from contextlib import ExitStack
from dataclasses import dataclass, replace
from pathlib import Path
from types import TracebackType
from typing import Self

import msgspec
from foxglove_schemas_protobuf.CompressedImage_pb2 import CompressedImage
from foxglove_schemas_protobuf.Log_pb2 import Log
from google.protobuf.message import DecodeError

from common.clock import NS_PER_S
from common.errors import MessageError, RecordingError
from common.link.channels import HAND, STATE
from common.messages.codec import decode
from common.messages.hand import HandArm
from common.messages.requests import Description
from common.messages.robot import STOPPED, RobotState, SessionState
from common.messages.video import CameraStatus, Codec, VideoFrame
from common.recording.folder import parts_from
from common.recording.hand_transcript import EPISODE, LOG
from common.recording.reader import KeptMessage, RecordingReader, as_recorded
from common.recording.recorded_episodes import event_in
from farhand.replay.recorded_cycles import recorded_config
from remote_site.config import RemoteConfig
from remote_site.kinematics.limits import load_arm
from remote_site.recording import topics
from remote_site.runtime.request_server import describe

BEFORE_NS = NS_PER_S // 2  # before the time that is jumped to: by then every panel has something
MOST_EVENTS_BYTES = 8 << 20  # of one file, each with what keeping it takes
EVENT_BYTES = 100
EVENT_TOPICS = EPISODE.name, LOG.name
HAND_PREFIX = HAND.key.split("{operator}")[0]

Shown = RobotState | HandArm | VideoFrame
SESSION_LINE = re.compile(r"(?P<state>\w+) \((?P<code>\w+)\): (?P<sentence>.*)", re.DOTALL)
SESSION = "session"
STOP = "stop"


@dataclass(frozen=True, slots=True)
class RecordedEvent:
    """A point of the recording to which a person may want to jump: seconds from its beginning, its kind, and words."""

    at_s: float
    kind: str
    words: str


def worth_a_jump(events: Iterable[RecordedEvent]) -> Iterator[RecordedEvent]:
    """Of the session's lines those with another state than before, or a stop; all other events as they are.

    What a site says while it starts, and limits that come and go during an engagement, change no state.
    """
    state, is_stopped = SessionState.DISENGAGED.value, False
    for event in events:
        said = SESSION_LINE.fullmatch(event.words) if event.kind == SESSION else None
        if said is None:
            yield event
            continue
        stops = said["code"] == STOPPED
        if said["state"] != state or (stops and not is_stopped):
            yield replace(event, kind=STOP if stops else said["state"], words=_words(said["state"], said["sentence"]))
        state, is_stopped = said["state"], stops


def _words(state: str, sentence: str) -> str:
    return sentence if sentence.startswith(state) else f"{state}: {sentence}"


def recorded_cell(path: Path, folder: Path) -> Description:
    """The cell of a recording; `folder` receives the recorded URDF, where the arm's own is another one.

    RecordingError for files that are no recording of a cell.
    """
    with RecordingReader(path) as recording:
        return _described(recorded_config(recording, folder))


class RecordedScene:
    """A recording from one of its files on, as a context manager; the times are those of the host that recorded.

    `events` are the episodes, and each change of the session's state, by time. RecordingError as `recorded_cell`.
    """

    def __init__(self, path: Path, folder: Path) -> None:
        with ExitStack() as stack:
            self._parts = [stack.enter_context(RecordingReader(part)) for part in parts_from(path)]
            first, last = self._parts[0], self._parts[-1]
            config = recorded_config(first, folder)
            self.begin_ns, self.end_ns = first.span_ns[0], last.span_ns[1]
            self.began_ns = self.begin_ns + first.epoch_minus_clock_ns  # since 1970
            self.events = list(worth_a_jump(event for part in self._parts for event in self._events(part)))
            self.cell = _described(config)
            self._open = stack.pop_all()
        self._cameras = {topics.image_topic(camera.name).name: camera.name for camera in config.video.cameras}
        self._state = STATE.key_for(config.cell)
        self._hands = HAND_PREFIX.format(cell=config.cell)
        self._pictures = 0

    def __enter__(self) -> Self:
        return self

    def __exit__(
        self, kind: type[BaseException] | None, error: BaseException | None, trace: TracebackType | None
    ) -> None:
        self._open.close()

    def shown(self, from_ns: int) -> Iterator[tuple[int, Shown]]:
        """Times and messages from shortly before a time on; what another release sent is left out."""
        for part in self._parts:
            if part.span_ns[1] < from_ns - BEFORE_NS:
                continue
            wanted = [name for name in part.topics if self._is_shown(name)]
            for message in part.messages(wanted, from_ns - BEFORE_NS):
                try:
                    yield message.t_ns, self._message(message)
                except (MessageError, DecodeError):
                    continue

    def _is_shown(self, topic: str) -> bool:
        return topic == self._state or topic in self._cameras or topic.startswith(self._hands)

    def _message(self, message: KeptMessage) -> Shown:
        if message.topic == self._state:
            return decode(message.data, RobotState, STATE.max_bytes)
        if message.topic in self._cameras:
            return self._picture(self._cameras[message.topic], message)
        return _by_our_clock(decode(message.data, HandArm, HAND.max_bytes))

    def _picture(self, camera: str, message: KeptMessage) -> VideoFrame:
        """Numbers only rise, also where the time jumps back: a page paints no older picture over a newer one."""
        self._pictures += 1
        image = CompressedImage.FromString(message.data)
        size = next(described for described in self.cell.cameras if described.name == camera)
        return VideoFrame(
            camera=camera,
            seq=self._pictures,
            capture_ns=message.t_ns,
            capture_estimated=False,
            status=CameraStatus.LIVE,
            reason="",
            width=size.width,
            height=size.height,
            codec=Codec.JPEG,
            key=True,
            data=image.data,
        )

    def _events(self, part: RecordingReader) -> Iterator[RecordedEvent]:
        """Those of a file; where it is damaged, or has more than a page can list, so far, and that."""
        at_s, kept_bytes = 0.0, 0
        try:
            with as_recorded(part.path):
                for message in part.messages(EVENT_TOPICS):
                    at_s = (message.t_ns - self.begin_ns) / NS_PER_S
                    kept_bytes += EVENT_BYTES + len(message.data)
                    if kept_bytes > MOST_EVENTS_BYTES:
                        raise ValueError("more events than a page can list")
                    event = self._event(message, at_s)
                    if event is not None:
                        yield event
        except RecordingError as error:
            yield RecordedEvent(at_s, SESSION, f"no events are known from here on: {error}")

    def _event(self, message: KeptMessage, at_s: float) -> RecordedEvent | None:
        if message.topic == EPISODE.name:
            event = event_in(message)
            words = f"episode {event.episode}: {event.event.value}, {event.outcome.value} {event.task}".strip()
            return RecordedEvent(at_s, "episode", words)
        line = Log.FromString(message.data)
        return RecordedEvent(at_s, SESSION, line.message) if line.name == SESSION else None


def _described(config: RemoteConfig) -> Description:
    return describe(config, *load_arm(config.robot))


def _by_our_clock(hand: HandArm) -> HandArm:
    """A hand sample with its times by the clock of the host that recorded, as far as that is known."""
    offset_ns = hand.clock.remote_minus_local_ns if hand.clock is not None else 0
    sent_ns = hand.sent_ns + offset_ns if hand.sent_ns is not None else None
    return msgspec.structs.replace(hand, capture_ns=max(hand.capture_ns + offset_ns, 0), sent_ns=sent_ns)
