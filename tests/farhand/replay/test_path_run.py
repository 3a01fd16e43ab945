"""Runs on a path through the whole remote site and the simulated cell: approach, holds, the gripper, the key."""

from copy import deepcopy

import numpy as np
import pytest
from msgspec.structs import replace

from common.clock import NS_PER_S
from common.errors import RefusedError
from common.messages.hand import Locks
from common.messages.robot import GripperCommand, GripperStatus, SessionState
from lab.stage.stepped.site import SESSION
from local_site.programmed.approach import approach
from local_site.programmed.path_progress import PathProgress
from local_site.programmed.path_run import ENDED, WAITS
from local_site.programmed.tool_trajectory import GripperAction, ToolTrajectory
from remote_site.kinematics.limits import load_arm
from remote_site.session.config import EngagementMode
from tests.led_cell import CONFIG, LedCell

NEAR_M = 1e-3
PATIENT = replace(CONFIG, safety=replace(CONFIG.safety, t_latch_ms=1000.0))  # a cut of half a second is a hold


def start_pose():
    model, _ = load_arm(CONFIG.robot)
    return model.forward(np.array(CONFIG.robot.start))


def some_path(*actions):
    """120 mm back and down in two seconds, from 60 mm beside where the arm stands."""
    base_T_tool = start_pose()
    t_s = np.linspace(0.0, 2.0, 101)
    part = (t_s / 2.0) ** 3 * (10 - 15 * t_s / 2.0 + 6 * (t_s / 2.0) ** 2)
    positions = base_T_tool[:3, 3] + [-0.05, 0.03, -0.02] + part[:, None] * np.array([-0.08, 0.0, -0.09])
    orientations = np.tile([0.0, np.sqrt(0.5), 0.0, np.sqrt(0.5)], (101, 1))
    return ToolTrajectory(t_s, positions, orientations, actions=actions)


def cell_on(path, gripper_at_start=None, *, goes_on=True):
    return LedCell(PathProgress(path, 1.0, stepwise=False), gripper_at_start, goes_on=goes_on, config=PATIENT)


def engaged(cell):
    """Press the key once the arm is ready, and hold it until the run approaches its path."""
    cell.pass_s(1.0)
    cell.key_held = True
    cell.until("approaches")
    return cell


def off_m(cell, path, t_s):
    return np.linalg.norm(cell.base_T_tool[:3, 3] - path.base_T_tool(t_s)[:3, 3])


@pytest.mark.slow
def test_nothing_moves_before_the_key_is_held_and_then_the_path_is_run_from_where_the_arm_stands():
    path = some_path(GripperAction(2.0, GripperCommand.CLOSED))
    cell = cell_on(path, GripperCommand.OPEN)
    stood = cell.base_T_tool
    cell.pass_s(1.0)
    assert cell.reason == WAITS
    assert cell.base_T_tool == pytest.approx(stood, abs=1e-6)
    engaged(cell)
    fastest, before = 0.0, cell.base_T_tool
    while "approaches" in cell.reason:
        cell.pass_s(0.1)
        fastest = max(fastest, float(np.linalg.norm(cell.base_T_tool[:3, 3] - before[:3, 3])) / 0.1)
        before = cell.base_T_tool
    assert fastest < 0.08
    assert off_m(cell, path, 0.0) < 0.02
    cell.until("done")
    cell.pass_s(1.0)
    assert off_m(cell, path, 2.0) < NEAR_M
    assert cell.site.gripper.status is GripperStatus.CLOSED


@pytest.mark.slow
def test_the_key_let_go_stops_the_arm_and_a_new_engagement_begins_with_an_approach_again():
    path = some_path()
    cell = engaged(cell_on(path, goes_on=False))
    cell.until("runs")
    cell.pass_s(1.0)
    cell.key_held = False
    cell.pass_s(1.0)
    stood = cell.base_T_tool
    cell.pass_s(0.5)
    assert cell.base_T_tool == pytest.approx(stood, abs=1e-6)
    assert off_m(cell, path, 0.0) > 0.02
    assert cell.site.snapshot.state is SessionState.DISENGAGED
    engaged(cell)
    assert cell.base_T_tool == pytest.approx(stood, abs=5e-3), "no jump into the middle of the path"
    cell.until("done")
    cell.pass_s(1.0)
    assert off_m(cell, path, 2.0) < NEAR_M


def held(path, *, goes_on):
    """A run half way, after a hold that a cut of the link has caused."""
    cell = engaged(cell_on(path, goes_on=goes_on))
    cell.until("runs")
    cell.pass_s(1.0)
    number = cell.site.snapshot.engagement.number
    cell.is_cut = True
    cell.pass_s(0.5)
    assert cell.site.snapshot.state is SessionState.HOLDING
    cell.is_cut = False
    while cell.site.snapshot.state is SessionState.HOLDING:
        cell.step()
    assert cell.site.snapshot.engagement.number == number
    return cell


@pytest.mark.slow
def test_a_taught_run_goes_on_after_a_hold_by_an_approach():
    path = some_path()
    cell = held(path, goes_on=True)
    stood = cell.base_T_tool
    cell.until("approaches")
    assert cell.base_T_tool == pytest.approx(stood, abs=5e-3)
    cell.until("done")
    cell.pass_s(1.0)
    assert off_m(cell, path, 2.0) < NEAR_M


@pytest.mark.slow
def test_a_replayed_run_has_ended_with_a_hold():
    cell = held(some_path(), goes_on=False)
    cell.until(ENDED)
    stood = cell.base_T_tool
    cell.pass_s(1.0)
    assert cell.base_T_tool == pytest.approx(stood, abs=5e-3)
    assert cell.reason == ENDED


def test_a_gripper_that_differs_is_refused_with_what_to_do_and_the_arm_cannot_be_engaged():
    cell = cell_on(some_path(GripperAction(1.0, GripperCommand.OPEN)), GripperCommand.CLOSED)
    cell.pass_s(1.0)
    cell.key_held = True
    cell.pass_s(2.0)
    assert "has to be closed at the beginning" in cell.reason
    assert cell.site.snapshot.state is SessionState.DISENGAGED


@pytest.fixture(scope="module")
def cell_under_way():
    """A cell half a second after its run has begun; its time stands still."""
    cell = engaged(cell_on(some_path()))
    cell.until("runs")
    cell.pass_s(0.5)
    return cell


@pytest.fixture
def under_way(cell_under_way):
    """Runs of the test's own, one of them under way, their progress, and the time and state of the cell."""
    runs, progress = deepcopy((cell_under_way.runs, cell_under_way.progress))
    return runs, progress, cell_under_way.site.now_ns, cell_under_way.state()


def test_a_lock_on_the_page_stands_the_run_and_is_named(under_way):
    runs, _, now_ns, state = under_way
    locked = replace(state, settings=replace(state.settings, locks=Locks(roll=True)))
    hand = runs.hand(now_ns, locked)
    assert "roll is locked" in hand.reason
    assert hand.status.value == "initialising"


def test_the_hand_goes_as_far_as_the_scale_on_the_page_needs(under_way):
    runs, _, now_ns, state = under_way
    hand = runs.hand(now_ns, state)
    halved = replace(state, settings=replace(state.settings, scale=0.5 * state.settings.scale))
    assert np.linalg.norm(hand.wrist) > 0.01
    assert runs.hand(now_ns, halved).wrist == pytest.approx(2.0 * hand.wrist)


@pytest.mark.slow
def test_a_path_out_of_reach_is_not_run_through_without_the_arm():
    path = some_path()
    far = ToolTrajectory(path.t_s, path.positions + np.array([0.3, 0.0, 0.18]), path.orientations)
    cell = engaged(cell_on(far))
    needed_s = approach(start_pose(), far.base_T_tool(0.0)).duration_s + far.duration_s
    cell.pass_s(needed_s + 2.0)
    assert "behind" in cell.reason
    assert not cell.progress.is_done


@pytest.mark.slow
def test_no_gripper_acts_where_the_arm_cannot_be():
    path = some_path(GripperAction(2.0, GripperCommand.CLOSED))
    x, y, _ = PATIENT.safety.workspace_min_m
    box = replace(PATIENT.safety, workspace_min_m=(x, y, path.positions[-1, 2] + 0.03))
    progress = PathProgress(path, 1.0, stepwise=False)
    cell = engaged(LedCell(progress, GripperCommand.OPEN, config=replace(PATIENT, safety=box)))
    cell.until("the gripper waits")
    cell.pass_s(3.0)
    assert "the gripper waits, the arm is" in cell.reason
    assert cell.site.gripper.status is GripperStatus.OPEN


@pytest.mark.slow
def test_a_run_whose_end_the_arm_has_not_reached_is_not_told_to_be_well():
    cell = engaged(cell_on(some_path()))
    cell.until("done")
    cell.pass_s(1.0)
    assert cell.reason == "the run is done: let the key go"
    state = cell.state()
    x, y, z = state.base_T_tool.position
    off = replace(state, base_T_tool=replace(state.base_T_tool, position=(x, y, z + 0.03)))
    assert "done, but the arm is 30 mm and 0 deg off" in cell.runs.hand(cell.site.now_ns, off).reason


def test_a_gripper_that_is_not_measured_is_refused_before_anything_moves():
    cell = cell_on(some_path(GripperAction(1.0, GripperCommand.OPEN)))
    hand = cell.runs.hand(cell.site.now_ns, replace(cell.state(), gripper=None))
    assert "none that is measured" in hand.reason
    assert hand.status.value == "initialising"
    without = cell_on(some_path())
    assert without.runs.hand(without.site.now_ns, replace(without.state(), gripper=None)).reason == WAITS


@pytest.mark.slow
def test_a_silent_remote_site_stands_the_run(under_way):
    runs, progress, now_ns, _ = under_way
    before = progress.target
    hand = runs.hand(now_ns, None)
    assert "silent" in hand.reason
    assert progress.target == pytest.approx(before)


def moved_mm(cell, stood):
    return 1e3 * np.linalg.norm(cell.base_T_tool[:3, 3] - stood[:3, 3])


@pytest.mark.slow
@pytest.mark.parametrize("mode", [EngagementMode.AUTOMATIC, EngagementMode.ON_REQUEST])
@pytest.mark.parametrize("goes_on", [True, False])
def test_a_remote_site_that_starts_again_in_another_mode_ends_the_runs_and_the_arm_stays(mode, goes_on):
    cell = engaged(cell_on(some_path(), goes_on=goes_on))
    cell.until("runs")
    cell.pass_s(0.5)
    cell.key_held = False
    cell.restart(PATIENT.engaging(mode))
    stood = cell.base_T_tool
    with pytest.raises(RefusedError, match="would move without a person at the key"):
        cell.pass_s(10.0)
    assert cell.site.snapshot.state is SessionState.DISENGAGED
    assert moved_mm(cell, stood) < 1.0


@pytest.mark.slow
def test_after_a_restart_in_the_same_mode_only_a_key_pressed_anew_begins_a_run_and_from_the_paths_beginning():
    path = some_path()
    cell = engaged(cell_on(path))
    cell.until("runs")
    cell.pass_s(1.0)
    cell.restart(PATIENT)
    stood = cell.base_T_tool
    cell.pass_s(3.0)
    assert moved_mm(cell, stood) < 1.0
    cell.key_held = False
    engaged(cell)
    assert moved_mm(cell, stood) < 5.0
    assert cell.progress.target == pytest.approx(path.base_T_tool(0.0))
    cell.until("done")
    cell.pass_s(1.0)
    assert off_m(cell, path, 2.0) < NEAR_M


@pytest.mark.slow
def test_a_restart_with_another_mapping_is_led_by_that_mapping():
    path = some_path()
    cell = engaged(cell_on(path))
    cell.until("runs")
    cell.key_held = False
    halved = replace(PATIENT, mapping=replace(PATIENT.mapping, scale=0.5 * PATIENT.mapping.scale))
    cell.restart(halved)
    cell.pass_s(1.0)
    engaged(cell)
    cell.until("done")
    cell.pass_s(1.0)
    assert off_m(cell, path, 2.0) < NEAR_M


NOT_OURS = {
    "another operator's": lambda state: replace(state, lease=replace(state.lease, session=SESSION + 1)),
    "nobody's": lambda state: replace(state, lease=None),
    "made without a key": lambda state: replace(state, readiness=replace(state.readiness, held=False)),
}


@pytest.mark.slow
@pytest.mark.parametrize("made", NOT_OURS)
def test_an_engagement_that_another_made_leads_no_run_and_ends_the_one_under_way(made, under_way):
    runs, progress, now_ns, state = under_way
    reached, others = progress.target, NOT_OURS[made](state)
    hands = [runs.hand(now_ns + k * NS_PER_S // 60, others) for k in range(120)]
    assert {hand.reason for hand in hands} == {WAITS}
    assert all(hand.wrist == pytest.approx(hands[0].wrist) for hand in hands)
    assert progress.target == pytest.approx(reached)
    runs.hand(now_ns + 3 * NS_PER_S, state)
    assert progress.target == pytest.approx(some_path().base_T_tool(0.0)), "a run of its own begins anew"


def test_a_path_that_begins_a_thousand_kilometres_away_is_not_approached():
    far = some_path()
    cell = cell_on(ToolTrajectory(far.t_s, far.positions + 1e6, far.orientations))
    stood = cell.base_T_tool
    cell.pass_s(1.0)
    cell.key_held = True
    cell.until("m away")
    cell.pass_s(0.5)
    assert cell.base_T_tool == pytest.approx(stood, abs=1e-6)
