"""The operator's recorder keeps what it hears byte for byte, once it may, and says whose pictures are with it."""

import json
from collections.abc import Iterator
from datetime import UTC, datetime
from pathlib import Path
from typing import Any

import msgspec
import pytest
from mcap.reader import make_reader
from mcap_protobuf.decoder import DecoderFactory
from structlog.testing import capture_logs

import tests.common.messages.golden_examples as golden
from common.link.channels import HAND, PREVIEW, STATE
from common.messages.codec import encode
from common.messages.recording import EpisodeOutcome
from common.messages.requests import RecordAction, RecordRequest
from common.messages.robot import SessionState
from common.messages.video import CameraStatus, Codec, VideoFrame
from common.recording.config import OperatorRecordConfig, StartPolicy
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
    """Messages that are heard and orders that are given, each once; `hears_views` is whether views would be heard."""

    def __init__(self) -> None:
        self.lost = 0
        self.waiting: list[HeardMessage] = []
        self.ordered: list[RecordRequest] = []
        self.hears_views = False

    def hear(self, key: str, t_s: float, payload: bytes) -> None:
        self.waiting.append(HeardMessage(key, round(t_s * 1e9), key != STATE_KEY, payload))

    def take(self) -> Iterator[HeardMessage]:
        while self.waiting:
            yield self.waiting.pop(0)

    def order(self, action: RecordAction, **given: object) -> None:
        self.ordered.append(RecordRequest(id=1, deadline_ns=1, action=action, **given))  # type: ignore[arg-type]

    def orders(self) -> Iterator[RecordRequest]:
        while self.ordered:
            yield self.ordered.pop(0)

    def hear_views(self, *, wanted: bool) -> None:
        self.hears_views = wanted


@pytest.fixture
def heard() -> Script:
    return Script()


def recorder_of(config: LocalConfig, folder: Path, heard: Script) -> OperatorRecorder:
    plan = RecordingPlan(folder, "cell", "test", config.record)
    return OperatorRecorder(config, GuardedRecording(plan, lambda: BEGAN), heard)


@pytest.fixture
def recorder(tmp_path: Path, heard: Script) -> OperatorRecorder:
    return recorder_of(CONFIG, tmp_path, heard)


@pytest.fixture
def asked(tmp_path: Path, heard: Script) -> OperatorRecorder:
    """A recorder that waits to be asked."""
    record = msgspec.structs.replace(CONFIG.record, start=StartPolicy.ON_REQUEST)
    return recorder_of(msgspec.structs.replace(CONFIG, record=record), tmp_path, heard)


def recorded(tmp_path: Path, *topics: str) -> list[bytes]:
    (path,) = tmp_path.iterdir()
    with RecordingReader(path) as reader:
        return [message.data for message in reader.messages(topics)]


def state(session: SessionState) -> bytes:
    return encode(msgspec.structs.replace(golden.STATE, state=session))


def test_names_without_end_are_not_all_remembered(tmp_path: Path, heard: Script, recorder: OperatorRecorder) -> None:
    given = encode(msgspec.structs.replace(golden.HAND, clock=golden.CLOCKS))
    heard.hear(HAND_KEY, 3.0, given)
    heard.hear(HAND_KEY, 3.0, given)
    for k in range(1000):
        heard.hear(HAND.key_for("cell", operator=f"invented-{k}"), 3.1, given)
    heard.hear(HAND_KEY, 3.2, given)
    recorder.step(3 * 10**9)
    recorder.end(4 * 10**9)
    clocks = [json.loads(data)["operator"] for data in recorded(tmp_path, "/clock")]
    assert len(clocks) == 1002
    assert clocks.count("anna") == 2


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


def test_samples_and_views_of_any_time_leave_a_recording_that_can_be_read(
    tmp_path: Path, heard: Script, recorder: OperatorRecorder
) -> None:
    for time_ns in (2**63 - 1, 2**61, 0):
        hand = msgspec.structs.replace(golden.HAND, capture_ns=time_ns, sent_ns=time_ns)
        heard.hear(HAND_KEY, 3.1, encode(hand))
        heard.hear(VIEW_KEY, 3.3, encode(msgspec.structs.replace(FRAME, capture_ns=time_ns)))
    recorder.step(3 * 10**9)
    recorder.end(4 * 10**9)
    assert len(recorded(tmp_path, "/hand/anna", "/operator/left", HAND_KEY, VIEW_KEY)) == 12


def test_a_recorder_says_once_that_it_waits_and_once_that_the_site_is_there(
    heard: Script, recorder: OperatorRecorder
) -> None:
    with capture_logs() as log:
        for t_s in (1, 2, 3):
            recorder.step(t_s * 10**9)
        heard.hear(HAND_KEY, 3.5, encode(golden.HAND))
        for t_s in (4, 5):
            recorder.step(t_s * 10**9)
        recorder.step(9 * 10**9)
    told = [(line["event"], line["endpoint"]) for line in log if "site" in line["event"]]
    waits = "waiting for the local site: nothing of it comes yet"
    endpoint = CONFIG.links.listen
    assert told == [(waits, endpoint), ("the local site is there", endpoint), (waits, endpoint)]


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


def test_on_request_nothing_is_kept_or_looked_at_before_it_is_asked_for_and_after(
    tmp_path: Path, heard: Script, asked: OperatorRecorder
) -> None:
    asked.step(10**9)
    assert (asked.state().writing, asked.state().on_request, heard.hears_views) == (False, True, False)
    assert list(tmp_path.iterdir()) == []
    kept = []
    for t_s, action in ((2, RecordAction.START), (3, RecordAction.STOP), (4, None)):
        if action is not None:
            heard.order(action)
        heard.hear(HAND_KEY, t_s, b"%d" % t_s)
        asked.step(t_s * 10**9)
        kept.append((asked.state().writing, heard.hears_views))
    assert kept == [(True, True), (False, False), (False, False)]
    assert recorded(tmp_path, HAND_KEY) == [b"2", b"3"]


def test_what_was_asked_of_one_run_of_the_local_site_is_not_of_the_next(
    tmp_path: Path, heard: Script, asked: OperatorRecorder
) -> None:
    heard.order(RecordAction.START)
    for t_s in (1, 5, 9):  # the remote site goes on
        heard.hear(HAND_KEY, t_s, b"hand")
        asked.step(t_s * 10**9)
    assert asked.state().writing
    heard.hear(STATE_KEY, 14.5, state(SessionState.DISENGAGED))
    asked.step(145 * 10**8)
    assert not asked.state().writing
    heard.hear(HAND_KEY, 20, b"hand")
    asked.step(20 * 10**9)
    assert not asked.state().writing
    assert len(list(tmp_path.iterdir())) == 1


def test_the_operator_bounds_and_labels_episodes(tmp_path: Path, heard: Script, recorder: OperatorRecorder) -> None:
    orders: list[tuple[RecordAction, dict[str, Any]]] = [
        (RecordAction.BEGIN, {"task": "push"}),
        (RecordAction.END, {}),
        (RecordAction.LABEL, {"outcome": EpisodeOutcome.FAILURE}),
    ]
    for k, (action, given) in enumerate(orders):
        recorder.step(k * 10**9)  # orders come to a recording that is under way
        heard.order(action, **given)
        recorder.step(k * 10**9 + 1)
    recorder.end(4 * 10**9)
    events = [json.loads(data) for data in recorded(tmp_path, "/episode")]
    who = CONFIG.authority.name
    assert [(e["event"], e["by"], e["task"], e["outcome"]) for e in events] == [
        ("begin", who, "push", "unknown"),
        ("end", who, "push", "unknown"),
        ("label", who, "push", "failure"),
    ]
