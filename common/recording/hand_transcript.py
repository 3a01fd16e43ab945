"""Topics of either site's recording that show the hand: its points with covariances, and the offset of the clocks."""

from functools import lru_cache

import msgspec
from foxglove_schemas_protobuf.Log_pb2 import Log
from foxglove_schemas_protobuf.PointCloud_pb2 import PointCloud

from common.errors import MessageError
from common.link.channels import HAND
from common.messages.codec import decode
from common.messages.hand import ClockSync, HandArm
from common.recording import foxglove
from common.recording.episodes import EpisodeEvent
from common.recording.session import RecordingSession
from common.recording.topics import Topic, json_topic, protobuf_topic

OPERATOR_FRAME = "operator"
MOST_NAMES = 64  # of operators that are remembered: a list has 32 at most, and without one anybody invents some
HAND_POINTS = ("elbow", "wrist", "index", "thumb", "palm")


class KnownClock(msgspec.Struct, frozen=True, kw_only=True):
    """The remote site's clock minus an operator's, as the operator's hand samples carry it, ns."""

    operator: str
    sync: ClockSync


LOG = protobuf_topic("/log", Log)
EPISODE = json_topic("/episode", EpisodeEvent)
CLOCK = json_topic("/clock", KnownClock, unit="ns")


@lru_cache(MOST_NAMES)
def hand_topic(operator: str) -> Topic:
    """The points of an operator's arm."""
    return protobuf_topic(f"/hand/{operator}", PointCloud, unit="m, m2", points=",".join(HAND_POINTS))


class HandTranscript:
    """Writes the points of each sample; `at_remote` is whether the recording's clock is the remote site's."""

    def __init__(self, *, at_remote: bool) -> None:
        self._at_remote = at_remote
        self._clocks: dict[str, ClockSync] = {}

    def add(self, session: RecordingSession, key: str, payload: bytes, t_ns: int) -> int | None:
        """Keep what the sample shows; when it was sent, by the recording's clock, None where that is not known."""
        try:
            operator, hand = HAND.operator_in(key), decode(payload, HandArm, HAND.max_bytes)
        except MessageError:
            return None  # the sites refuse it, too; its bytes are kept
        if hand.clock is not None and hand.clock != self._clocks.get(operator):
            self._remember(operator, hand.clock)
            session.add(CLOCK, msgspec.json.encode(KnownClock(operator=operator, sync=hand.clock)), t_ns)
        offset_ns = self._offset_ns(hand)
        captured_ns = hand.capture_ns + offset_ns if offset_ns is not None else t_ns
        seen = {name: getattr(hand, name) for name in HAND_POINTS}
        spread = {name: getattr(hand.covariance, name, None) for name in HAND_POINTS}
        named = {name: (at, spread[name]) for name, at in seen.items() if at is not None}
        cloud = foxglove.points(session.since_1970_ns(captured_ns), OPERATOR_FRAME, named, HAND_POINTS)
        session.add(hand_topic(operator), cloud, t_ns, captured_ns)
        return hand.sent_ns + offset_ns if hand.sent_ns is not None and offset_ns is not None else None

    def _remember(self, operator: str, clock: ClockSync) -> None:
        """Keep the newest clock of the operators whose clock has changed last."""
        self._clocks.pop(operator, None)
        self._clocks[operator] = clock
        if len(self._clocks) > MOST_NAMES:
            del self._clocks[next(iter(self._clocks))]

    def _offset_ns(self, hand: HandArm) -> int | None:
        """From the operator's clock to the recording's, None where it is not known."""
        if not self._at_remote:
            return 0
        return hand.clock.remote_minus_local_ns if hand.clock is not None else None


def add_episode(session: RecordingSession, event: EpisodeEvent) -> None:
    """Keep an event of an episode, as data and as a line of the log."""
    session.add(EPISODE, msgspec.json.encode(event), event.t_ns)
    said = f"episode {event.episode}: {event.event.value} by {event.by}, {event.outcome.value}, {event.task!r}"
    add_log(session, event.t_ns, "episode", said)


def add_log(session: RecordingSession, t_ns: int, name: str, sentence: str) -> None:
    """Keep a line of the log."""
    session.add(LOG, foxglove.log_line(session.since_1970_ns(t_ns), name, sentence), t_ns)
