"""Recordings as exporters read them: what the recorder kept of a site, found again."""

from pathlib import Path

import numpy as np
import pytest

from common.clock import NS_PER_MS
from common.errors import ExportError, RecordingError
from common.messages.recording import EpisodeOutcome
from common.messages.requests import EngagementAction, RecordAction
from common.messages.robot import GripperCommand
from common.recording.config import RecordConfig
from common.recording.mcap_file import McapFile
from common.recording.reader import CLOCK_TABLE, EPOCH_KEY, RecordingReader
from common.recording.recorded_episodes import RecordedEpisode
from farhand.export.recording import open_sessions, parts_by_session, within
from farhand.export.session import SessionEpisode
from farhand.export.videos.h264 import decoded
from remote_site.recording.cycle_record import decode_outcome
from remote_site.recording.topics import image_topic
from remote_site.recording.transcript import CELL_TABLE
from tests.farhand.export.lerobot.made_dataset import episodes, export, frames, pictures
from tests.remote_site.driven_loop import CONFIG
from tests.remote_site.recording.recorded_site import BEGAN, CAMERA, RecordedSite

FPS = 20


@pytest.fixture(scope="module")
def recorded(tmp_path_factory: pytest.TempPathFactory) -> Path:
    """A site that engages, follows a moving hand for two seconds, and ends."""
    site = RecordedSite(tmp_path_factory.mktemp("site"), RecordConfig(task="wave"))
    site.loop.link.activate(CONFIG.robot.start)
    site.run(0.4)
    site.loop.ask(EngagementAction.ENGAGE)
    site.note()
    site.run(2.0, speed_m_s=0.05)
    site.order(RecordAction.LABEL, outcome=EpisodeOutcome.SUCCESS, note="gently")
    site.end()
    (path,) = site.out.iterdir()
    return path


def outcomes(path):
    with RecordingReader(path) as reader:
        return [decode_outcome(kept.data) for kept in reader.messages(["/cycle/outcome"])]


def test_the_session_is_described_as_it_was(recorded):
    with open_sessions([recorded]) as (session,):
        facts = session.facts
        (episode,) = facts.episodes
    assert facts.robot == CONFIG.robot.model
    assert facts.views == {CAMERA: (64, 64)}
    assert (episode.task, episode.success, episode.note) == ("wave", True, "gently")
    assert facts.begin_ns < episode.begin_ns < episode.end_ns <= facts.end_ns
    assert abs(facts.begin_ns + facts.utc_minus_clock_ns - BEGAN.timestamp() * 1e9) < 100 * NS_PER_MS


def test_joints_and_what_was_sent_are_those_of_the_cycles(recorded):
    kept = outcomes(recorded)
    with open_sessions([recorded]) as (session,):
        signals = session.signals()
    measured = {outcome.measured_ns: outcome for outcome in kept}
    assert set(signals.joints.t_ns.tolist()) == set(measured)
    written = {outcome.written.t_ns: outcome.written for outcome in kept if outcome.written is not None}
    assert signals.actions.motion.t_ns.tolist() == sorted(written)
    for t_ns, q in zip(*signals.actions.motion, strict=True):
        assert q.tolist() == written[int(t_ns)].q.tolist()
    ordered = {outcome.ordered.seq: outcome for outcome in kept if outcome.ordered is not None}
    causes = [ordered[written[int(t)].seq].obeys for t in signals.actions.motion.t_ns if written[int(t)].seq in ordered]
    assert sum(cause is not None for cause in causes) > 200
    followed = [cause.born_ns if cause else 0 for cause in causes]
    assert signals.actions.hand_ns.tolist()[-len(followed) :] == followed
    keeps = [written[int(t)].gripper is GripperCommand.KEEP for t in signals.actions.motion.t_ns]
    assert (np.isnan(signals.actions.opening) | ~np.array(keeps)).all()
    assert signals.states.at(np.array([session.facts.end_ns])) == ["engaged"]


def test_pictures_of_a_time_are_those_of_the_camera(recorded):
    with RecordingReader(recorded) as reader:
        exposed = [kept.t_ns for kept in reader.messages([f"/camera/{CAMERA}"])]
    with open_sessions([recorded]) as (session,):
        found = list(session.pictures(exposed[5], exposed[9]))
    assert [one.capture_ns for one in found] == exposed[5:9]
    assert {one.view for one in found} == {CAMERA}
    assert decoded(found[0].jpeg, CAMERA).shape == (64, 64, 3)


def test_first_and_last_picture_of_an_episode_are_those_of_the_recording(recorded, tmp_path):
    with open_sessions([recorded]) as sessions:
        export(sessions, tmp_path / "dataset", fps=FPS)
        (facts,) = (session.facts for session in sessions)
        source = list(sessions[0].pictures(facts.begin_ns, facts.end_ns))
    (row,) = episodes(tmp_path / "dataset")
    shown = pictures(tmp_path / "dataset", CAMERA, 0.0, row["length"] / FPS)
    assert row["length"] == len(shown) == len(frames(tmp_path / "dataset")["index"])
    exposed = np.array(frames(tmp_path / "dataset")[f"time.images.{CAMERA}"]) * 1e9 + facts.episodes[0].begin_ns
    for picture, at in ((shown[0], exposed[0]), (shown[-1], exposed[-1])):
        errors = [np.abs(picture.astype(int) - decoded(one.jpeg, CAMERA)).mean() for one in source]
        nearest = source[int(np.argmin(errors))]
        assert abs(nearest.capture_ns - at) < NS_PER_MS  # of pictures of noise, each unlike all others
        assert min(errors) < 0.5 * sorted(errors)[1]


def test_parts_of_one_recording_are_one_session(tmp_path):
    site = RecordedSite(tmp_path, RecordConfig(split_minutes=0.1))
    site.loop.link.activate(CONFIG.robot.start)
    site.run(0.4)
    site.order(RecordAction.BEGIN, task="wait")
    site.idle(7.0)
    site.end()
    parts = sorted(site.out.iterdir())
    assert len(parts) == 2
    with open_sessions([parts[1], parts[0]]) as (session,):
        facts = session.facts
        t_ns = session.signals().joints.t_ns
    assert not facts.name.endswith(("_001", "_002"))
    assert [(episode.number, episode.task) for episode in facts.episodes] == [(1, "wait")]
    assert facts.episodes[0].end_ns - facts.episodes[0].begin_ns > 6.9e9
    assert (np.diff(t_ns) > 0).all()
    with open_sessions(parts[1:]) as (rest,):
        assert [episode.begin_ns for episode in rest.facts.episodes] == [rest.facts.begin_ns]


def test_files_are_grouped_by_their_names():
    names = ["a/20260304T050607Z_cell_002.mcap", "a/run.mcap", "a/20260304T050607Z_cell_001.mcap", "a/run.mcap"]
    assert parts_by_session([Path(name) for name in [*names, "b/run.mcap"]]) == {
        Path("a/20260304T050607Z_cell"): [Path(names[2]), Path(names[0])],
        Path("a/run"): [Path("a/run.mcap")],
        Path("b/run"): [Path("b/run.mcap")],
    }


def test_an_episode_that_begins_or_ends_in_another_file_does_so_with_this_one():
    told = "stack", EpisodeOutcome.FAILURE, "n"
    second, first = RecordedEpisode(2, 40, None, *told), RecordedEpisode(1, None, 20, *told)
    assert within([second, first], 5, 99) == (
        SessionEpisode(1, 5, 20, "stack", False, "n"),
        SessionEpisode(2, 40, 99, "stack", False, "n"),
    )


@pytest.mark.parametrize(
    ("begin_ns", "end_ns", "expected"), [(-(2**63), 2**63 - 1, (5, 99)), (200, 300, (99, 99)), (50, 20, (50, 20))]
)
def test_an_episode_is_within_its_file(begin_ns, end_ns, expected):
    (episode,) = within([RecordedEpisode(1, begin_ns, end_ns, "", EpisodeOutcome.UNKNOWN, "")], 5, 99)
    assert (episode.begin_ns, episode.end_ns) == expected


def test_what_is_no_recording_is_refused_with_the_cure(tmp_path):
    path = tmp_path / "cut.mcap"
    path.write_bytes(b"\x89MCAP0\r\n")
    with pytest.raises(RecordingError, match="farhand record repair"), open_sessions([path]):
        pass
    with pytest.raises(RecordingError, match="cannot be read"), open_sessions([tmp_path / "none.mcap"]):
        pass
    with pytest.raises(ExportError, match="name one or more"):
        export([], tmp_path / "none")


@pytest.mark.parametrize("view", ["a\nb", "\u202eside", "x" * 65, "a\0b"])
def test_a_camera_whose_name_would_not_stay_one_is_refused(view, tmp_path):
    path = tmp_path / "hostile.mcap"
    file = McapFile(path, "test")
    file.describe(CLOCK_TABLE, {EPOCH_KEY: "0"})
    file.describe(CELL_TABLE, {"robot": "r", "joints": "a"})
    file.add(image_topic(view), b"", 1, 1)
    file.finish()
    with pytest.raises(RecordingError, match="the name of a camera has "), open_sessions([path]):
        pass
