"""A recording whose check sums are right and whose content is not: each reader of it says so, and none crashes."""

import msgspec
import numpy as np
import pytest
import simplejpeg
from foxglove_schemas_protobuf.CompressedImage_pb2 import CompressedImage
from foxglove_schemas_protobuf.Log_pb2 import Log

from common.errors import RecordingError
from common.messages.requests import EngagementAction
from common.messages.robot import GripperCommand, GripperState, GripperStatus
from common.recording.config import RecordConfig
from common.recording.foxglove import joint_states, pose_in_frame
from common.recording.hand_transcript import EPISODE, LOG
from common.recording.mcap_file import McapFile
from common.recording.reader import CLOCK_TABLE, EPOCH_KEY, RecordingReader
from common.recording.topics import MessageSchema, Topic
from farhand.export.recording import open_sessions
from farhand.replay.recorded_cycles import recorded_pipeline
from farhand.replay.recorded_scene import RecordedScene
from farhand.replay.recorded_tool_path import recorded_path
from remote_site.recording.topics import ACTION, GRIPPER, MEASURED, TOOL_MEASURED, WRITTEN, image_topic
from remote_site.recording.transcript import CELL_TABLE, CONFIG_FILE, URDF_FILE
from tests.remote_site.driven_loop import CONFIG
from tests.remote_site.recording.recorded_site import CAMERA, RecordedSite

GARBAGE = b"\xff\xff\xff\xff"
PICTURES = image_topic(CAMERA).name


@pytest.fixture(scope="module")
def recorded(tmp_path_factory):
    site = RecordedSite(tmp_path_factory.mktemp("site"), RecordConfig(task="wave"))
    site.loop.link.activate(CONFIG.robot.start)
    site.run(0.4)
    site.loop.ask(EngagementAction.ENGAGE)
    site.note()
    site.run(0.6)
    site.end()
    (path,) = site.out.iterdir()
    return path


@pytest.fixture
def altered(recorded, tmp_path):
    """Makes a copy with other data in messages, tables and documents of some names; None leaves them out."""

    def make(**others):
        path = tmp_path / "altered.mcap"
        file = McapFile(path, "test")
        with RecordingReader(recorded) as reader:
            epoch_ns = reader.epoch_minus_clock_ns
            for name in (CLOCK_TABLE, CELL_TABLE):
                table = others.get(name, reader.table(name))
                if table is not None:
                    file.describe(name, table)
            for name in (CONFIG_FILE, URDF_FILE):
                document = others.get(name, reader.document(name))
                if document is not None:
                    file.attach(name, "x", document, 0)
            for topic, t_ns, published_ns, data in reader.messages():
                given = others.get(topic, data)
                file.add(Topic(topic, "x", MessageSchema("s")), given, t_ns + epoch_ns, published_ns + epoch_ns)
        file.finish()
        return path

    return make


def export(path):
    with open_sessions([path]) as (session,):
        session.signals()
        return len(list(session.pictures(session.facts.begin_ns, session.facts.end_ns)))


def test_a_copy_is_read_as_the_recording_itself(recorded, altered):
    assert export(altered()) == export(recorded) > 0


@pytest.mark.parametrize(
    "topic", [MEASURED.name, WRITTEN.name, TOOL_MEASURED.name, GRIPPER.name, ACTION.name, EPISODE.name, PICTURES]
)
def test_messages_that_are_none_are_refused_by_an_export(topic, altered):
    with pytest.raises(RecordingError, match=r"altered\.mcap: what is in it cannot be read .*use the release"):
        export(altered(**{topic: GARBAGE}))


def event(**others):
    known = {"event": "begin", "episode": 1, "t_ns": 0, "by": "", "task": "t", "outcome": "unknown", "note": ""}
    return known | others


def action(**cause):
    hand = {"session": 1, "seq": 1, "capture_ns": 0, "born_ns": 0} | cause
    order = {"command": 1, "sent_ns": 0, "q": [], "gripper": "keep", "written_command": None, "written_ns": None}
    return order | {"cause": hand}


@pytest.mark.parametrize(
    ("topic", "data", "why"),
    [
        (TOOL_MEASURED, pose_in_frame(0, "base_link", np.eye(4) + 1e300 * np.eye(4, k=3)), "which no arm has"),
        (GRIPPER, GripperState(1e300, None, GripperCommand.KEEP, GripperStatus.OPEN), "which no arm has"),
        *((EPISODE, event(episode=number), r"\$\.episode") for number in (-1, 2**63)),
        *((EPISODE, event(t_ns=t_ns), r"\$\.t_ns") for t_ns in (-(2**64) + 1, 2**64 - 1)),
        (EPISODE, event(task="t" * 401), r"\$\.task"),
        (ACTION, action(born_ns=2**61), "an action at .* by a hand at"),
        (ACTION, action(capture_ns=2**62), "an action at .* by a hand at"),
        (ACTION, b'{"x":' + b"[" * 9000 + b"]" * 9000 + b"}", "recursion"),
    ],
)
def test_figures_that_no_arm_and_no_recorder_gives_are_refused_by_an_export(topic, data, why, altered):
    given = data if isinstance(data, bytes) else msgspec.json.encode(data)
    with pytest.raises(RecordingError, match=rf"altered\.mcap: what is in it cannot be read .*{why}"):
        export(altered(**{topic.name: given}))


@pytest.mark.parametrize("topic", [MEASURED, WRITTEN])
@pytest.mark.parametrize("q", [np.nan, np.inf, -1e300])
def test_joints_that_no_arm_has_are_refused_by_an_export(topic, q, recorded, altered):
    with RecordingReader(recorded) as reader:
        names = reader.table(CELL_TABLE)["joints"].split(",")
    data = joint_states(0, names, np.full(len(names), q), None, None)
    with pytest.raises(RecordingError, match=r"altered\.mcap: .*which no arm has"):
        export(altered(**{topic.name: data}))


@pytest.mark.parametrize("joints", [",".join(f"j{k}" for k in range(17)), "joint_1,joint_1"])
def test_more_joints_than_an_arm_has_and_one_joint_twice_are_refused(joints, altered):
    with pytest.raises(RecordingError, match="joints: give a recording of an arm with at most 16, each once"):
        export(altered(**{CELL_TABLE: {"robot": "r", "joints": joints}}))


def test_more_views_than_a_site_has_are_refused(tmp_path):
    path = tmp_path / "views.mcap"
    file = McapFile(path, "test")
    file.describe(CLOCK_TABLE, {EPOCH_KEY: "0"})
    file.describe(CELL_TABLE, {"robot": "r", "joints": "a"})
    for k in range(17):
        file.add(image_topic(f"v{k}"), b"", 1, 1)
    file.finish()
    with pytest.raises(RecordingError, match=r"17 views: .* at most 16 cameras"):
        export(path)


@pytest.mark.parametrize("line", ["=" * 1_000_000 + " x", "=1+1 (code): sentence"])
def test_only_the_states_of_a_session_are_taken_from_its_log(line, altered):
    data = Log(name="session", message=line).SerializeToString()
    with open_sessions([altered(**{LOG.name: data})]) as (session,):
        assert session.signals().states.names == ()


@pytest.mark.parametrize("table", [None, {}, {"robot": "r", "joints": "no,such"}])
def test_a_cells_table_that_is_none_is_refused_by_an_export(table, altered):
    with pytest.raises(RecordingError, match=r"altered\.mcap"):
        export(altered(**{CELL_TABLE: table}))


def test_a_picture_that_would_take_all_memory_is_not_decoded(altered):
    """A JPEG whose head says 65500 x 65500 pixels: 12.9 GB."""
    jpeg = simplejpeg.encode_jpeg(np.zeros((8, 8, 3), np.uint8))
    at = jpeg.index(b"\xff\xc0") + 5
    jpeg = jpeg[:at] + 2 * (65500).to_bytes(2, "big") + jpeg[at + 4 :]
    with pytest.raises(RecordingError, match="a picture of 65500 x 65500 pixels, more than any camera gives"):
        export(altered(**{PICTURES: CompressedImage(data=jpeg).SerializeToString()}))


@pytest.mark.parametrize(("document", "data"), [(CONFIG_FILE, b"{"), (CONFIG_FILE, None), (URDF_FILE, b"<robot")])
def test_a_configuration_or_an_arm_that_is_none_is_refused_by_a_replay(document, data, altered, tmp_path):
    path = altered(**{document: data})
    for reads in (RecordedScene, recorded_pipeline):
        with pytest.raises(RecordingError):
            reads(path, tmp_path)


def test_a_replay_shows_what_it_can_and_says_from_where_on_it_knows_no_events(altered, tmp_path):
    with RecordedScene(altered(**{EPISODE.name: GARBAGE, PICTURES: GARBAGE}), tmp_path) as scene:
        assert any("no events are known from here on" in event.words for event in scene.events)
        assert len(list(scene.shown(scene.begin_ns))) > 0


def test_a_replay_keeps_no_more_events_than_a_page_can_list(altered, tmp_path):
    line = Log(name="session", message="n" * (9 << 20)).SerializeToString()
    with RecordedScene(altered(**{LOG.name: line}), tmp_path) as scene:
        assert "no events are known from here on" in scene.events[-1].words
        assert "more events than a page can list" in scene.events[-1].words
        assert sum(len(event.words) for event in scene.events) < 10_000


def test_the_path_of_an_episode_that_is_none_is_refused(altered):
    with pytest.raises(RecordingError, match=r"altered\.mcap: what is in it cannot be read"):
        recorded_path(altered(**{EPISODE.name: GARBAGE}), CONFIG.cell, None)
