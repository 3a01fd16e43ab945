"""The operator's recorder keeps what it hears byte for byte, and says whether pictures of the operator are with it."""

import json
from collections.abc import Iterator
from datetime import UTC, datetime
from pathlib import Path

import pytest
from mcap.reader import make_reader
from mcap_protobuf.decoder import DecoderFactory

import tests.common.messages.golden_examples as golden
from common.link.channels import HAND, PREVIEW, STATE
from common.messages.codec import encode
from common.messages.robot import SessionState
from common.messages.video import CameraStatus, Codec, VideoFrame
from common.recording.config import OperatorRecordConfig
from common.recording.guarded import GuardedRecording
from common.recording.reader import RecordingReader
from common.recording.session import RecordingPlan
from local_site.config import LocalConfig
from local_site.recording.recorder import OperatorRecorder
from local_site.recording.source import HeardMessage

CONFIG = LocalConfig(cell="cell", record=OperatorRecordConfig(task="wave", operator_pictures=True))
HAND_KEY = HAND.key_for("cell", operator="anna")
STATE_KEY, VIEW_KEY = STATE.key_for("cell"), PREVIEW.key_for("cell", "left", "anna")
BEGAN = datetime(2026, 3, 4, tzinfo=UTC)
FRAME = VideoFrame(
    camera="left",
    seq=1,
    capture_ns=3 * 10**9,
    capture_estimated=False,
    status=CameraStatus.LIVE,
    reason="",
    width=2,
    height=2,
    codec=Codec.JPEG,
    key=True,
    data=b"\xff\xd8\xff\xd9",
)


class Script:
    """Messages that are heard, each once."""

    def __init__(self) -> None:
        self.lost = 0
        self.waiting: list[HeardMessage] = []

    def hear(self, key: str, t_s: float, payload: bytes) -> None:
        self.waiting.append(HeardMessage(key, round(t_s * 1e9), key != STATE_KEY, payload))

    def take(self) -> Iterator[HeardMessage]:
        while self.waiting:
            yield self.waiting.pop(0)


@pytest.fixture
def heard() -> Script:
    return Script()


@pytest.fixture
def recorder(tmp_path: Path, heard: Script) -> OperatorRecorder:
    plan = RecordingPlan(tmp_path, "cell", "test", CONFIG.record)
    return OperatorRecorder(CONFIG, GuardedRecording(plan, lambda: BEGAN), heard)


def recorded(tmp_path: Path, *topics: str) -> list[bytes]:
    (path,) = tmp_path.iterdir()
    with RecordingReader(path) as reader:
        return [message.data for message in reader.messages(topics)]


def state(session: SessionState) -> bytes:
    return encode(golden.msgspec.structs.replace(golden.STATE, state=session))


def test_what_passed_is_kept_byte_for_byte_and_shown(tmp_path: Path, heard: Script, recorder: OperatorRecorder) -> None:
    heard.hear(HAND_KEY, 3.1, encode(golden.HAND))
    heard.hear(HAND_KEY, 3.2, b"nothing")
    heard.hear(VIEW_KEY, 3.3, encode(FRAME))
    recorder.step(3 * 10**9)
    recorder.end(4 * 10**9)
    assert recorded(tmp_path, HAND_KEY) == [encode(golden.HAND), b"nothing"]
    (path,) = tmp_path.iterdir()
    with path.open("rb") as file:
        reader = make_reader(file, decoder_factories=[DecoderFactory()])
        shown = {c.topic: m for _, c, _, m in reader.iter_decoded_messages(["/hand/anna", "/operator/left"])}
    assert shown["/operator/left"].data == FRAME.data
    assert len(shown["/hand/anna"].data) > 0


def test_an_engagement_is_an_episode(tmp_path: Path, heard: Script, recorder: OperatorRecorder) -> None:
    for t_s, session in enumerate([SessionState.DISENGAGED, SessionState.ENGAGED, SessionState.HOLDING], 1):
        heard.hear(STATE_KEY, t_s, state(session))
    recorder.step(3 * 10**9)
    recorder.end(4 * 10**9)
    events = [json.loads(data) for data in recorded(tmp_path, "/episode")]
    assert [(e["event"], e["by"], e["task"]) for e in events] == [
        ("begin", "engagement", "wave"),
        ("end", "recording", "wave"),
    ]


def test_the_console_is_told_several_times_a_second_whose_pictures_are_kept(recorder: OperatorRecorder) -> None:
    notices = [recorder.step(k * 50_000_000) for k in range(21)]
    told = [notice.state for notice in notices if notice is not None]
    assert 4 <= len(told) <= 6
    assert all(one.writing and one.operator_pictures for one in told)
    recorder.end(2 * 10**9)
    assert not recorder.state().writing
