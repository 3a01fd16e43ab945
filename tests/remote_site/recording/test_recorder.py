"""The recorder of a cell: what it keeps, when it begins and ends, and that nothing of it reaches control."""

import json
import resource
import stat
from dataclasses import replace
from datetime import timedelta
from itertools import pairwise
from pathlib import Path

import pytest
from mcap.reader import make_reader
from mcap_protobuf.decoder import DecoderFactory
from structlog.testing import capture_logs

from common.messages.codec import decode, encode
from common.messages.hand import HandArm
from common.messages.recording import EpisodeOutcome
from common.messages.requests import EngagementAction, RecordAction
from common.messages.robot import SessionState
from common.messages.video import VideoFrame
from common.recording.config import EpisodeBounds, RecordConfig, StartPolicy
from common.recording.reader import RecordingReader
from remote_site.kinematics.limits import load_arm
from remote_site.recording.cycle_record import decode_input, decode_outcome
from remote_site.recording.kept_config import decode_config
from remote_site.recording.memory import RecordingMemory
from remote_site.recording.taps import ControlTap
from remote_site.teleop.pipeline import TeleopPipeline
from tests.present import present
from tests.remote_site.driven_loop import CONFIG
from tests.remote_site.recording.recorded_site import BEGAN, CAMERA, CELL, KEY, RecordedSite

LARGE = 1_000_000


def kept(path: Path, *topics: str) -> list[bytes]:
    with RecordingReader(path) as reader:
        return [message.data for message in reader.messages(topics)]


def events(path: Path) -> list[tuple[str, int, str, str]]:
    found = (json.loads(data) for data in kept(path, "/episode"))
    return [(event["event"], event["episode"], event["by"], event["outcome"]) for event in found]


@pytest.fixture
def site(tmp_path: Path) -> RecordedSite:
    return RecordedSite(tmp_path)


def engaged(site: RecordedSite) -> None:
    """Activate the robot, and follow a moving hand for a second."""
    site.loop.link.activate(CONFIG.robot.start)
    site.run(0.4)
    site.loop.ask(EngagementAction.ENGAGE)
    site.note()
    site.run(1.0, speed_m_s=0.05)
    assert site.loop.state is SessionState.ENGAGED


def test_the_cycles_of_a_recording_are_replayed_bit_for_bit(site: RecordedSite) -> None:
    engaged(site)
    site.end()
    (path,) = site.files
    inputs = [decode_input(data) for data in kept(path, "/cycle/input")]
    outcomes = [decode_outcome(data) for data in kept(path, "/cycle/outcome")]
    assert [outcome.number for outcome in outcomes] == list(range(1, len(inputs) + 1))
    with RecordingReader(path) as reader:
        config = decode_config(reader.document("remote.json"))
        assert reader.document("robot.urdf") == CONFIG.robot.urdf.read_bytes()
    pipeline = TeleopPipeline(config, *load_arm(config.robot))
    for given, outcome in zip(inputs, outcomes, strict=True):
        assert pipeline.cycle(given).motion.q.tobytes() == outcome.motion.q.tobytes()


def test_each_action_names_its_sample_and_is_what_the_robot_was_given(site: RecordedSite) -> None:
    engaged(site)
    site.end()
    (path,) = site.files
    samples = {(hand.session, hand.seq): hand for hand in (decode(d, HandArm, LARGE) for d in kept(path, KEY))}
    actions = [json.loads(data) for data in kept(path, "/action")]
    causes = [action["cause"] for action in actions if action["cause"] is not None]
    assert len(causes) > 200
    for cause in causes:
        assert samples[cause["session"], cause["seq"]].capture_ns == cause["capture_ns"]
    by_number = {action["command"]: action for action in actions}
    outcomes = [decode_outcome(data) for data in kept(path, "/cycle/outcome")]
    given = [o.written for o in outcomes if o.written is not None and o.written.seq in by_number]
    assert len(given) > 300
    assert all(by_number[written.seq]["q"] == written.q.tolist() for written in given)


def test_others_read_it_by_its_schemas(site: RecordedSite) -> None:
    engaged(site)
    site.end()
    with site.files[0].open("rb") as file:
        reader = make_reader(file, decoder_factories=[DecoderFactory()])
        topics = ["/joints/measured", "/joints/commanded", "/tool/measured", f"/camera/{CAMERA}", "/hand/operator-7"]
        found = reader.iter_decoded_messages([*topics, "/tf", "/log"])
        seen = {channel.topic: message for _, channel, _, message in found}
    assert [joint.name for joint in seen["/joints/measured"].joints] == [f"joint_{k}" for k in range(1, 7)]
    assert seen["/tool/measured"].frame_id == "base_link"
    assert seen[f"/camera/{CAMERA}"].format == "jpeg"
    assert len(seen["/hand/operator-7"].data) == 4 * seen["/hand/operator-7"].point_stride
    assert {"/tf", "/log"} <= seen.keys()


def test_frames_as_they_were_sent_come_together_again(site: RecordedSite) -> None:
    site.run(0.3)
    site.setting = replace(site.setting, quality=40)
    site.run(0.3)
    site.end()
    frames = [decode(data, VideoFrame, LARGE) for data in kept(site.files[0], f"farhand/{CELL}/camera/{CAMERA}")]
    with RecordingReader(site.files[0]) as reader:
        exposures = {message.t_ns for message in reader.messages([f"/camera/{CAMERA}"])}
    assert {frame.capture_ns for frame in frames} == exposures
    assert {bool(frame.data) for frame in frames} == {True, False}  # with a poorer one of its own, or without


def test_messages_are_kept_byte_for_byte(site: RecordedSite) -> None:
    site.run(0.5)
    site.end()
    hands = kept(site.files[0], KEY)
    assert len(hands) > 10
    assert all(encode(decode(data, HandArm, LARGE)) == data for data in hands)


def test_file_and_folder_are_their_owners_alone(site: RecordedSite) -> None:
    site.run(0.1)
    site.end()
    assert stat.S_IMODE(site.files[0].stat().st_mode) == 0o600
    assert stat.S_IMODE(site.out.stat().st_mode) == 0o700


def test_an_engagement_is_an_episode_and_gets_its_label_afterwards(site: RecordedSite) -> None:
    engaged(site)
    site.loop.ask(EngagementAction.DISENGAGE)
    site.run(0.4)
    site.order(RecordAction.LABEL, outcome=EpisodeOutcome.SUCCESS, note="clean")
    site.end()
    assert events(site.files[0]) == [
        ("begin", 1, "engagement", "unknown"),
        ("end", 1, "engagement", "unknown"),
        ("label", 1, "anna", "success"),
    ]


def test_where_requests_bound_episodes_engagements_do_not(tmp_path: Path) -> None:
    site = RecordedSite(tmp_path, RecordConfig(episodes=EpisodeBounds.REQUESTS))
    engaged(site)
    site.order(RecordAction.BEGIN, task="push")
    site.run(0.2)
    site.order(RecordAction.END, outcome=EpisodeOutcome.FAILURE)
    site.end()
    assert events(site.files[0]) == [("begin", 1, "anna", "unknown"), ("end", 1, "anna", "failure")]


def test_on_request_nothing_is_kept_before_it_is_asked_for_and_after(tmp_path: Path) -> None:
    site = RecordedSite(tmp_path, RecordConfig(start=StartPolicy.ON_REQUEST))
    site.run(0.3)
    assert site.files == []
    state = site.tap.state(site.clock.now_ns())
    assert state is not None
    assert (state.writing, state.on_request) == (False, True)
    site.order(RecordAction.START)
    site.run(0.3)
    assert present(site.tap.state(site.clock.now_ns())).writing
    site.order(RecordAction.STOP)
    site.run(0.3)
    assert not present(site.tap.state(site.clock.now_ns())).writing
    numbers = [decode_outcome(data).number for data in kept(site.files[0], "/cycle/outcome")]
    assert 70 < numbers[0] < 80
    assert 145 < numbers[-1] <= 150


def test_the_state_says_how_long_and_how_much_is_recorded_and_the_episodes_clock(tmp_path: Path) -> None:
    site = RecordedSite(tmp_path, RecordConfig(episodes=EpisodeBounds.REQUESTS, split_minutes=0.1))
    site.run(1.0)
    site.idle(2.0)
    site.order(RecordAction.BEGIN, task="push")
    site.idle(4.0)
    state = site.recorder.state()
    assert state.seconds == pytest.approx(7.0, abs=0.2)
    assert state.episode_seconds == pytest.approx(4.0, abs=0.2)
    before = state.size_bytes
    assert before == pytest.approx(sum(file.stat().st_size for file in site.files), rel=0.5)
    site.order(RecordAction.END)
    site.idle(3.0)  # into the next file
    assert len(site.files) == 2
    state = site.recorder.state()
    assert state.seconds == pytest.approx(10.0, abs=0.3)
    assert state.episode_seconds == pytest.approx(4.0, abs=0.2)
    assert state.size_bytes > before
    site.end()
    assert (site.recorder.state().seconds, site.recorder.state().size_bytes) == (0.0, 0)


def test_what_was_asked_of_one_run_of_the_site_is_not_of_the_next(tmp_path: Path) -> None:
    site = RecordedSite(tmp_path, RecordConfig(start=StartPolicy.ON_REQUEST))
    site.run(0.1)
    site.order(RecordAction.START)
    site.run(0.1)
    site.end()
    site.memory = RecordingMemory.create(tmp_path / "memory", site.clock.now_ns())
    site.tap = ControlTap(site.memory, site.clock)
    site.clock.advance_ms(1000)
    site.run(0.3)
    assert len(site.files) == 1
    assert not site.recorder.state().writing


def test_without_a_recorder_nothing_is_left_in_memory(site: RecordedSite) -> None:
    site.run(0.1)
    site.clock.advance_ms(6000)
    before = site.memory.ticks.count, site.memory.pictures.count
    site.idle(1.0, recorder_lives=False)
    assert (site.memory.ticks.count, site.memory.pictures.count) == before
    assert site.tap.state(site.clock.now_ns()) is None


def test_files_are_split_and_each_has_all_that_a_reader_needs(tmp_path: Path) -> None:
    site = RecordedSite(tmp_path, RecordConfig(split_minutes=0.1))
    site.run(0.1)
    site.idle(13.0)
    site.end()
    assert len(site.files) == 3
    numbers = [[decode_outcome(d).number for d in kept(path, "/cycle/outcome")] for path in site.files]
    assert [n for part in numbers for n in part] == list(range(1, sum(map(len, numbers)) + 1))
    for path in site.files:
        with RecordingReader(path) as reader:
            assert reader.table("farhand.cell")["cell"] == CELL
            assert reader.document("robot.urdf")
    assert [path.name for path in site.files] == [f"20260304T050607Z_{CELL}_{k:03d}.mcap" for k in (1, 2, 3)]


@pytest.mark.slow
def test_no_more_is_kept_than_is_allowed(tmp_path: Path) -> None:
    site = RecordedSite(tmp_path, RecordConfig(split_gb=0.001, keep_gb=0.004))
    site.side_px = 256
    site.run(0.1)
    (site.out / "notes.txt").write_text("not a recording")
    for _ in range(12):
        site.idle(1.0)
        assert sum(path.stat().st_size for path in site.files) < 0.004e9 + 2.5e6  # and what comes within a second
    site.end()
    assert (site.out / "notes.txt").exists()
    numbers = [decode_outcome(d).number for path in site.files[:-1] for d in kept(path, "/cycle/outcome")]
    assert numbers[0] > 100
    assert all(b - a == 1 for a, b in pairwise(numbers))


def test_a_full_disk_ends_the_recording_with_an_alarm_and_nothing_else(site: RecordedSite) -> None:
    limits = resource.getrlimit(resource.RLIMIT_FSIZE)
    resource.setrlimit(resource.RLIMIT_FSIZE, (6_000_000, limits[1]))
    try:
        site.side_px = 256
        engaged(site)
        site.idle(4.0)
        state = site.tap.state(site.clock.now_ns())
    finally:
        resource.setrlimit(resource.RLIMIT_FSIZE, limits)
    assert state is not None
    assert not state.writing
    assert "recording has ended" in state.alarm
    site.run(0.1)
    assert site.loop.state is SessionState.ENGAGED
    (path,) = site.files
    numbers = [decode_outcome(data).number for data in kept(path, "/cycle/outcome")]
    assert numbers == list(range(1, len(numbers) + 1))
    assert len(numbers) > 100
    site.began = BEGAN + timedelta(hours=1)
    site.order(RecordAction.START)
    assert site.recorder.state().alarm == ""


def test_a_recorder_says_once_that_it_waits_and_once_that_the_site_is_there(site: RecordedSite, tmp_path: Path) -> None:
    with capture_logs() as log:
        site.run(0.3)
        site.end()
        for _ in range(3):
            site.clock.advance_ms(1000)
            site.recorder.step(site.clock.now_ns())
        RecordingMemory.create(tmp_path / "memory", site.clock.now_ns())
        for _ in range(3):
            site.clock.advance_ms(1000)
            site.recorder.step(site.clock.now_ns())
    told = [(line["event"], line["endpoint"]) for line in log if "remote site" in line["event"]]
    waits = "waiting for the remote site: nothing of it comes yet"
    endpoint = CONFIG.links.control
    assert told == [(waits, endpoint), ("the remote site is there", endpoint)]


def test_a_site_that_starts_again_gets_a_recording_of_its_own(site: RecordedSite, tmp_path: Path) -> None:
    site.run(0.3)
    site.end()
    assert len(site.files) == 1
    site.memory = RecordingMemory.create(tmp_path / "memory", site.clock.now_ns())
    site.tap = ControlTap(site.memory, site.clock)
    site.began = BEGAN + timedelta(hours=1)
    site.clock.advance_ms(1000)
    site.recorder.step(site.clock.now_ns())
    site.run(0.3)
    site.end()
    assert [decode_outcome(data).number for data in kept(site.files[1], "/cycle/outcome")] == list(range(1, 76))
