"""The clutch through the whole pipeline: the arm rests while the hand is moved, and goes on from there."""

from collections.abc import Callable
from typing import Any

import numpy as np
import pytest

from common.clock import NS_PER_S
from common.geometry import Array
from common.messages.hand import ClutchKey, HandArm, Intent, TrackingStatus
from common.messages.requests import EngagementAction
from common.messages.robot import GripperCommand, SessionState
from remote_site.config import RemoteConfig
from remote_site.reasons import Code
from remote_site.session.config import EngagementConfig, EngagementMode
from remote_site.teleop.cycle import Command, CycleInput
from remote_site.teleop.pipeline import TeleopPipeline
from tests.remote_site.remote_loop import Point, RemoteLoop, assert_within_limits, hand
from tests.remote_site.teleop.cycle_log import Cycle, first_difference

SAMPLE = 8  # ticks
GOOD = 40 * SAMPLE
CALM = 9 * SAMPLE  # a release, and 200 ms of a calm hand after it
UP, DOWN, UNSEEN = (Intent(clutch=key) for key in ClutchKey)
REACHED: Point = (0.0, -0.06, 0.33)
BACK: Point = (0.0, 0.05, 0.25)


def at(point: Point) -> Callable[[int], Point]:
    return lambda _t_ns: point


def moving(loop: RemoteLoop, start: Point, end: Point, seconds: float) -> Callable[[int], Point]:
    """A hand that goes from one point to another from now on, and rests there."""
    from_ns = loop.clock.now_ns()

    def wrist(t_ns: int) -> Point:
        part = min((t_ns - from_ns) / NS_PER_S / seconds, 1.0)
        x, y, z = ((1 - part) * a + part * b for a, b in zip(start, end, strict=True))
        return x, y, z

    return wrist


def tool(loop: RemoteLoop) -> Array:
    """Where the commanded tool is, mm in the base's frame."""
    return 1e3 * loop.model.forward(loop.sent.q)[:3, 3]


def engaged(**changes: Any) -> RemoteLoop:
    """An arm that has followed the hand to where it can go no farther."""
    loop = RemoteLoop()
    loop.run(GOOD, at((0.0, 0.0, 0.3)), intent=UP, **changes)
    loop.run(GOOD, moving(loop, (0.0, 0.0, 0.3), REACHED, 0.8), intent=UP, **changes)
    assert loop.states[-1] is SessionState.ENGAGED
    return loop


def clutched(**changes: Any) -> RemoteLoop:
    """The same with the hand brought back under the clutch."""
    loop = engaged(**changes)
    loop.run(GOOD, moving(loop, REACHED, BACK, 0.8), intent=DOWN, **changes)
    assert (loop.states[-1], loop.snapshot.reason.code) == (SessionState.HOLDING, Code.CLUTCHED)
    return loop


def test_the_hand_is_brought_back_while_the_arm_rests_and_goes_on_from_there() -> None:
    loop = engaged()
    before = tool(loop)
    loop.run(GOOD, moving(loop, REACHED, BACK, 0.8), intent=DOWN)
    assert loop.sent.resting
    held = tool(loop)
    assert np.linalg.norm(held - before) < 1.0
    loop.run(CALM, at(BACK), intent=UP)
    assert loop.states[-1] is SessionState.ENGAGED
    assert np.linalg.norm(tool(loop) - held) < 0.01
    aside: Point = (0.03, *BACK[1:])
    loop.run(GOOD, moving(loop, BACK, aside, 0.5), intent=UP)
    moved = tool(loop) - held
    assert np.linalg.norm(moved) == pytest.approx(30.0, abs=0.5)
    assert_within_limits(loop)


def test_pressed_in_full_motion_it_stops_within_the_limits() -> None:
    loop = engaged()
    loop.run(10 * SAMPLE, moving(loop, REACHED, BACK, 0.5), intent=UP)
    assert not loop.sent.resting
    loop.run(20 * SAMPLE, moving(loop, REACHED, BACK, 0.5), intent=DOWN)
    assert loop.sent.resting
    assert_within_limits(loop)


def test_the_way_of_the_hand_under_the_clutch_is_no_shift_of_the_reference() -> None:
    loop = clutched()
    loop.run(CALM, at(BACK), intent=UP)
    assert loop.snapshot.engagement is not None
    assert (loop.snapshot.engagement.shift_mm, loop.snapshot.engagement.shift_deg) == (0.0, 0.0)


def test_a_hand_that_goes_on_moving_after_the_release_moves_nothing() -> None:
    loop = clutched()
    held = tool(loop)
    loop.run(60 * SAMPLE, moving(loop, BACK, REACHED, 1.0), intent=UP)
    assert loop.states[-1] is SessionState.ENGAGED
    assert np.linalg.norm(tool(loop) - held) < 0.1  # it followed from where the hand came to rest


@pytest.mark.parametrize("grip", [GripperCommand.KEEP, GripperCommand.CLOSED])
def test_openings_under_the_clutch_and_one_under_way_on_its_release_leave_the_gripper(grip: GripperCommand) -> None:
    before = int(grip is GripperCommand.CLOSED)
    loop = engaged(gripper_toggles=0)
    loop.run(10 * SAMPLE, at(REACHED), intent=UP, gripper_toggles=before)
    assert loop.gripper is grip
    for toggles in (1, 2, 3):
        loop.run(10 * SAMPLE, at(BACK), intent=DOWN, hand_open=True, gripper_toggles=before + toggles)
        loop.run(10 * SAMPLE, at(BACK), intent=DOWN, gripper_toggles=before + toggles)
    assert loop.gripper is grip
    loop.run(3 * SAMPLE, at(BACK), intent=DOWN, hand_open=True, gripper_toggles=before + 3)
    loop.run(2 * SAMPLE, at(BACK), intent=UP, hand_open=True, gripper_toggles=before + 3)
    loop.run(CALM, at(BACK), intent=UP, hand_open=True, gripper_toggles=before + 4)  # the opening is counted now
    assert loop.states[-1] is SessionState.ENGAGED
    loop.run(CALM, at(BACK), intent=UP, gripper_toggles=before + 4)
    assert (loop.gripper, loop.snapshot.gripper_toggles) == (grip, before)
    loop.run(CALM, at(BACK), intent=UP, hand_open=True, gripper_toggles=before + 5)
    assert loop.snapshot.gripper_toggles == before + 1


def test_an_opening_that_begins_after_the_release_and_before_the_arm_follows_leaves_the_gripper() -> None:
    loop = clutched(gripper_toggles=0)
    loop.run(5 * SAMPLE, at(BACK), intent=UP, gripper_toggles=0)
    loop.run(4 * SAMPLE, at(BACK), intent=UP, gripper_toggles=0, hand_open=True)
    loop.run(GOOD, at(BACK), intent=UP, gripper_toggles=1, hand_open=True)
    loop.run(GOOD, at(BACK), intent=UP, gripper_toggles=1)
    assert loop.states[-1] is SessionState.ENGAGED
    assert (loop.gripper, loop.snapshot.gripper_toggles) == (GripperCommand.KEEP, 0)


def shuffled(loop: RemoteLoop, keys: list[Intent], order: list[int]) -> None:
    """A sample for each of the keys, captured in a row, that come in this order, one a tick; -1 is a lost one."""
    samples: list[HandArm] = []
    for key in keys:
        loop.hand_seq += 1
        capture_ns = loop.clock.now_ns() - (len(keys) - len(samples)) * 10**6
        samples.append(hand(loop.hand_seq, capture_ns, BACK, lease=loop.lease, intent=key))
    for k in order:
        loop.tick(*([samples[k]] if k >= 0 else []))


@pytest.mark.slow
@pytest.mark.parametrize(
    "order",
    [[1, 0], [1, 0, 0], [1, 1, 0], [2, 0, 1], [-1, 1, 0], [2, 1, 0]],
    ids=["reordered", "doubled late", "doubled", "overtaken", "delayed", "reversed"],
)
def test_samples_of_before_the_press_that_come_after_it_do_not_let_go(order: list[int]) -> None:
    loop = engaged()
    shuffled(loop, [UP, DOWN, DOWN], order)
    loop.run(GOOD, at(BACK), intent=DOWN)
    assert (loop.states[-1], loop.snapshot.reason.code) == (SessionState.HOLDING, Code.CLUTCHED)


def test_a_lost_release_leaves_the_arm_held_until_the_next_sample_tells_it() -> None:
    loop = clutched()
    held = tool(loop)
    loop.run(2 * SAMPLE)  # both that would have told it are lost
    assert loop.snapshot.reason.code is Code.CLUTCHED
    loop.run(CALM, at(BACK), intent=UP)
    assert loop.states[-1] is SessionState.ENGAGED
    assert np.linalg.norm(tool(loop) - held) < 0.01


def test_a_page_that_falls_silent_under_the_clutch_leaves_the_arm_held_and_then_disengaged() -> None:
    loop = clutched()
    held = loop.sent.q
    loop.run(5 * SAMPLE, at(BACK), intent=None)
    assert loop.snapshot.reason.code is Code.PAGE_SILENT
    loop.run(5 * SAMPLE, moving(loop, BACK, REACHED, 1.0), intent=UP)
    assert (loop.snapshot.state, loop.snapshot.reason.code) == (SessionState.HOLDING, Code.CLUTCH_UNSEEN)
    loop.run(60 * SAMPLE, at(REACHED), intent=UP)
    assert loop.states[-1] is SessionState.DISENGAGED
    assert np.array_equal(loop.sent.q, held)
    assert loop.ask(EngagementAction.ENGAGE).reason.code is Code.CLUTCH_UNSEEN
    loop.run(2 * SAMPLE, at(REACHED), intent=DOWN)
    loop.run(GOOD, at(REACHED), intent=UP)
    assert loop.ask(EngagementAction.ENGAGE).done


def test_another_operators_samples_neither_clutch_nor_let_go() -> None:
    loop = engaged()
    loop.run(2 * SAMPLE, at(REACHED), intent=UP)
    loop.sender = "another"
    loop.run(1, at(REACHED), intent=DOWN)
    loop.sender = ""
    loop.run(SAMPLE, at(REACHED), intent=UP)
    assert loop.states[-1] is SessionState.ENGAGED
    loop.run(SAMPLE, at(REACHED), intent=DOWN)
    loop.sender = "another"
    loop.run(CALM // 4, at(REACHED), intent=UP)
    loop.sender = ""
    loop.run(1, at(REACHED), intent=DOWN)
    assert loop.snapshot.reason.code is Code.CLUTCHED


def test_a_recorded_clutch_comes_again_bit_for_bit(monkeypatch: pytest.MonkeyPatch) -> None:
    cycles: list[Cycle] = []
    true_cycle = TeleopPipeline.cycle

    def recording(pipeline: TeleopPipeline, given: CycleInput) -> Command:
        command = true_cycle(pipeline, given)
        cycles.append((given, command))
        return command

    monkeypatch.setattr(TeleopPipeline, "cycle", recording)
    loop = clutched()
    loop.run(5 * SAMPLE, at(BACK), intent=UNSEEN)
    loop.run(5 * SAMPLE, at(BACK), intent=DOWN)
    loop.run(CALM, at(BACK), intent=UP)
    loop.run(GOOD, moving(loop, BACK, (0.03, *BACK[1:]), 0.5), intent=UP)
    monkeypatch.undo()
    codes = {command.snapshot.reason.code for _, command in cycles}
    assert codes >= {Code.CLUTCHED, Code.CLUTCH_UNSEEN, Code.CLUTCH_SETTLING, Code.OK}
    assert first_difference(loop.config, cycles) == ""


def test_a_stop_under_the_clutch_is_a_stop() -> None:
    loop = clutched()
    assert loop.ask(EngagementAction.STOP).done
    loop.run(GOOD, at(BACK), intent=UP)
    assert (loop.snapshot.state, loop.snapshot.reason.code) == (SessionState.DISENGAGED, Code.STOPPED)


def test_the_hand_may_be_hidden_for_a_moment_under_the_clutch_and_not_for_long() -> None:
    loop = clutched()
    loop.run(5 * SAMPLE, at(BACK), intent=DOWN, status=TrackingStatus.LOST)
    loop.run(5 * SAMPLE, at(BACK), intent=DOWN)
    assert loop.snapshot.reason.code is Code.CLUTCHED
    loop.run(20 * SAMPLE, at(BACK), intent=DOWN, status=TrackingStatus.LOST)
    assert loop.states[-1] is SessionState.DISENGAGED


def test_in_hold_to_run_the_arm_waits_under_the_clutch_only_while_the_enabling_key_is_held_too() -> None:
    loop = RemoteLoop(RemoteConfig(engagement=EngagementConfig(mode=EngagementMode.HOLD_TO_RUN)))
    loop.run(GOOD, at(REACHED), intent=UP)
    loop.run(2 * SAMPLE, at(REACHED), intent=Intent(hold=True))
    assert loop.states[-1] is SessionState.ENGAGED
    loop.run(GOOD, at(REACHED), intent=Intent(hold=True, clutch=ClutchKey.DOWN))
    assert loop.states[-1] is SessionState.HOLDING
    loop.run(1, at(REACHED), intent=DOWN)
    assert (loop.snapshot.state, loop.snapshot.reason.code) == (SessionState.DISENGAGED, Code.LET_GO)
