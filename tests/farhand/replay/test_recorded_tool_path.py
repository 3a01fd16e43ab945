"""The path of a recorded episode: the tool's targets while the arm followed, and the gripper's toggles."""

import os

import msgspec
import numpy as np
import pytest
from msgspec.structs import replace

from common.clock import NS_PER_MS
from common.errors import RecordingError, RefusedError
from common.geometry import rotation_from_vector, transform
from common.link import channels
from common.messages.codec import encode
from common.messages.recording import EpisodeOutcome
from common.messages.requests import RecordAction
from common.messages.robot import Engagement, GripperCommand, Pose, SessionState
from common.recording.config import RecordConfig
from common.recording.episodes import EpisodeEvent, EpisodeEventKind
from common.recording.hand_transcript import EPISODE
from common.recording.mcap_file import McapFile
from common.recording.reader import CLOCK_TABLE, EPOCH_KEY
from common.recording.repair import repair
from common.recording.topics import MessageSchema, Topic
from farhand.replay.recorded_scene import recorded_cell
from farhand.replay.recorded_tool_path import check_cell, path_of, recorded_path
from local_site.programmed.approach import SPEED_M_S
from local_site.programmed.tool_trajectory import GripperAction
from remote_site.teleop.gripper_toggles import OPPOSITE
from tests.common.messages.golden_examples import STATE
from tests.common.recording.damaged_files import takes_at_most
from tests.farhand.replay.recorded_states import moves_back, recorded_states
from tests.present import present
from tests.remote_site.driven_loop import CONFIG
from tests.remote_site.recording.recorded_site import RecordedSite
from tests.remote_site.runtime.started_site import StartedSite, a465_holding

STEP_NS = 10_000_000
TOOL = transform(rotation_from_vector(np.array([0.1, 0.0, 0.3])), np.array([0.4, 0.1, 0.3]))


def stretch(begin_ns, count, x_m, number=1, toggles=0, gripper_next=GripperCommand.CLOSED):
    """States at 100 Hz with the target moving along x at 100 mm/s."""
    engagement = Engagement(number, number, Pose.from_transform(TOOL))
    return [
        replace(
            STATE,
            t_ns=begin_ns + k * STEP_NS,
            target=Pose.from_transform(TOOL + np.array([[0, 0, 0, x_m + 1e-3 * k], *[[0] * 4] * 3])),
            engagement=engagement,
            gripper_toggles_applied=toggles,
            gripper_next=gripper_next,
        )
        for k in range(count)
    ]


def test_targets_and_times_are_those_of_the_states():
    path = path_of(stretch(5_000, 201, 0.0))
    assert path.duration_s == pytest.approx(2.0)
    assert path.base_T_tool(1.0)[:3, 3] == pytest.approx(TOOL[:3, 3] + [0.1, 0, 0])
    assert path.base_T_tool(1.0)[:3, :3] == pytest.approx(TOOL[:3, :3])


@pytest.mark.slow
def test_states_are_read_one_after_the_other_and_not_all_kept(tmp_path):
    path = tmp_path / "x.mcap"
    file = McapFile(path, "test")
    file.describe(CLOCK_TABLE, {EPOCH_KEY: "0"})
    kind, outcome = EpisodeEventKind.BEGIN, EpisodeOutcome.UNKNOWN
    begin = EpisodeEvent(event=kind, episode=1, t_ns=1, by="anna", task="", outcome=outcome, note="")
    file.add(EPISODE, msgspec.json.encode(begin), 1, 1)
    first, last = (encode(state) for state in stretch(0, 2, 0.0))
    topic = Topic(channels.STATE.key_for("cell"), "x", MessageSchema("s"))
    for k, state in enumerate([first, *[last] * 10_000]):
        file.add(topic, state, k + 1, k + 1)
        if k % 1000 == 999:
            file.flush()
    file.finish()
    with takes_at_most(12 << 20):
        found = recorded_path(path, "cell", None)
    assert found.path.duration_s == pytest.approx(0.01)


def test_a_path_longer_than_any_is_refused(monkeypatch):
    monkeypatch.setattr("farhand.replay.recorded_tool_path.MOST_POSES", 100)
    with pytest.raises(RecordingError, match=r"more than 100 places: choose a shorter episode"):
        path_of(stretch(0, 101, 0.0))


def test_a_toggle_becomes_what_it_commanded_at_its_time():
    first, then = stretch(0, 101, 0.0), stretch(101 * STEP_NS, 100, 0.101, toggles=1, gripper_next=GripperCommand.OPEN)
    last = stretch(201 * STEP_NS, 50, 0.201, toggles=2)
    actions = path_of([*first, *then, *last]).actions
    assert [action.command for action in actions] == [GripperCommand.CLOSED, GripperCommand.OPEN]
    assert [action.t_s for action in actions] == pytest.approx([1.01, 2.01])


def slow(states, period_ns):
    """The same states of a robot that is read so seldom."""
    return [replace(state, t_ns=state.t_ns - state.t_ns % period_ns) for state in states]


@pytest.mark.parametrize("period_ms", [10, 20, 67, 100])
def test_every_toggle_of_a_robot_however_seldom_read_becomes_an_action_in_order_and_at_its_time(period_ms):
    count, every = 36, 41  # states from one toggle to the next
    states, grip = stretch(0, every, 0.0), GripperCommand.CLOSED
    for k in range(1, count + 1):
        grip = OPPOSITE[grip]
        states += stretch(k * every * STEP_NS, every, 0.001 * k * every, toggles=k, gripper_next=grip)
    actions = path_of(slow(states, period_ms * NS_PER_MS)).actions
    assert [action.command for action in actions] == [GripperCommand.CLOSED, GripperCommand.OPEN] * (count // 2)
    assert [action.t_s for action in actions] == pytest.approx(
        [k * every * 0.01 for k in range(1, count + 1)], abs=period_ms / 1000
    )


@pytest.mark.parametrize("word", [SessionState.HOLDING, SessionState.DISENGAGED])
def test_a_toggle_that_is_first_seen_where_the_arm_does_not_follow_counts_where_it_stood(word):
    first, between = stretch(0, 101, 0.0), stretch(101 * STEP_NS, 20, 0.101, toggles=1)
    between = [replace(state, state=word, target=None) for state in between]
    then = stretch(300 * STEP_NS, 50, 0.101, number=2, toggles=1, gripper_next=GripperCommand.OPEN)
    (action,) = path_of([*first, *between, *then]).actions
    assert action == GripperAction(action.t_s, GripperCommand.CLOSED)
    assert action.t_s == pytest.approx(1.0)


def test_of_toggles_at_once_the_gripper_does_what_they_commanded_in_the_end():
    first, then = stretch(0, 50, 0.0), stretch(50 * STEP_NS, 50, 0.05, toggles=2)
    assert [action.command for action in path_of([*first, *then]).actions] == [GripperCommand.OPEN]


def test_a_toggle_counts_once_also_where_states_come_late_or_the_remote_site_has_started_again():
    first, then = stretch(0, 50, 0.0, toggles=3), stretch(50 * STEP_NS, 50, 0.05, toggles=4)
    again = [replace(state, session=state.session + 1) for state in stretch(200 * STEP_NS, 50, 0.1, number=1)]
    toggled = stretch(250 * STEP_NS, 9, 0.15, toggles=1, gripper_next=GripperCommand.OPEN)
    states = [*first, *then[:5], first[9], *then[5:], *again, *(replace(s, session=s.session + 1) for s in toggled)]
    assert [action.command for action in path_of(states).actions] == [GripperCommand.CLOSED] * 2


@pytest.mark.slow
def test_all_toggles_of_the_emulated_a465_are_replayed():
    site = StartedSite(a465_holding()).ready().engaged()
    states, commanded = [], []
    for _ in range(16):
        site.toggles += 1
        for _ in range(75):
            states.append(state_of(site))
            site.run(20)
        commanded.append(present(site.driven.command).gripper)
    states.append(state_of(site))
    assert [action.command for action in path_of(states).actions] == commanded
    assert len(set(commanded)) == 2


def state_of(site):
    """The state that control would publish now, of a tool at rest."""
    report, snapshot = site.driven.report, site.snapshot
    return replace(
        STATE,
        t_ns=report.t_ns,
        state=snapshot.state,
        engagement=snapshot.engagement,
        target=Pose.from_transform(snapshot.target),
        gripper=report.gripper,
        gripper_toggles_applied=snapshot.gripper_toggles,
        gripper_next=snapshot.gripper_next,
    )


def test_a_pause_is_cut_out_and_what_the_arm_was_moved_meanwhile_is_crossed_slowly():
    path = path_of([*stretch(0, 101, 0.0), *stretch(60_000 * STEP_NS, 101, 0.5, number=2)])
    assert 0.4 / SPEED_M_S < path.duration_s - 2.0 < 20.0
    steps = np.linalg.norm(np.diff(path.positions, axis=0), axis=1) / np.diff(path.t_s)
    assert max(steps) < 0.11


def test_states_that_come_twice_or_late_are_left_out():
    states = stretch(0, 50, 0.0)
    assert path_of([*states, states[10], *stretch(50 * STEP_NS, 10, 0.05)]).duration_s == pytest.approx(0.59)


@pytest.mark.slow
def test_an_episode_without_motion_and_one_that_is_not_there_are_refused_by_name(tmp_path):
    file = recorded_states(tmp_path).file
    cell = recorded_cell(file, tmp_path).cell
    with pytest.raises(RecordingError, match=r"no episode 7: choose one by --episode\n  1: 4.0 s$"):
        recorded_path(file, cell, 7)
    assert recorded_path(file, cell, None).episode == 1


@pytest.mark.slow
def test_an_episode_lasts_to_the_end_of_a_recording_that_was_cut(tmp_path):
    recorded = recorded_states(tmp_path, moves_back)
    cell = recorded_cell(recorded.file, tmp_path).cell
    whole = recorded_path(recorded.file, cell, None).path.duration_s
    cut = tmp_path / "cut.mcap"
    cut.write_bytes(recorded.file.read_bytes())
    os.truncate(cut, round(0.8 * cut.stat().st_size))
    repair(cut)
    assert 0.4 * whole < recorded_path(cut, cell, 1).path.duration_s < whole


def test_episodes_are_listed_with_what_was_said_of_them_and_one_from_before_is_refused(tmp_path):
    site = RecordedSite(tmp_path, RecordConfig(split_minutes=0.1))
    site.loop.link.activate(CONFIG.robot.start)
    site.run(0.4)
    site.order(RecordAction.BEGIN, task="wait")
    site.idle(7.0)
    site.order(RecordAction.BEGIN, task="push")
    site.idle(1.0)
    site.order(RecordAction.END, outcome=EpisodeOutcome.FAILURE, note="slipped")
    site.end()
    first, second = sorted(site.out.iterdir())
    with pytest.raises(
        RecordingError, match=r"has 2 episodes.*\n  1: 7.\d s, wait\n  2: 1.\d s, failure, push, slipped$"
    ):
        recorded_path(first, CONFIG.cell, None)
    with pytest.raises(RecordingError, match=r"episode 1 begins in a file before .*_002.mcap"):
        recorded_path(second, CONFIG.cell, 1)
    with pytest.raises(RecordingError, match="never followed the hand"):
        recorded_path(first, CONFIG.cell, 2)


@pytest.mark.slow
def test_another_arm_is_refused(tmp_path):
    cell = recorded_cell(recorded_states(tmp_path).file, tmp_path)
    check_cell(cell, cell)
    with pytest.raises(RefusedError, match=r"this cell has a UR5"):
        check_cell(cell, replace(cell, robot="a UR5"))


def test_a_recording_whose_targets_leap_a_thousand_kilometres_is_refused():
    with pytest.raises(RecordingError, match="1000000 m away"):
        path_of([*stretch(0, 11, 0.0), *stretch(60_000 * STEP_NS, 11, 1e6, number=2)])
