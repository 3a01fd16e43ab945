"""Through the whole pipeline: what the hand did while it did not lead the arm never moves the gripper afterwards."""

from collections.abc import Callable
from typing import Any

import pytest

from common.messages.hand import Intent, OperatorSettings, TrackingStatus
from common.messages.requests import EngagementAction
from common.messages.robot import GripperCommand, SessionState
from remote_site.teleop.pipeline import TeleopPipeline
from tests.remote_site.mutation import Mutation
from tests.remote_site.remote_loop import RemoteLoop

EVERY = 8  # ticks per sample
GOOD = 31 * EVERY


def still(_t_ns: int) -> tuple[float, float, float]:
    return (0.0, 0.0, 0.3)


def engaged(toggles: int = 0) -> RemoteLoop:
    loop = RemoteLoop()
    loop.run(GOOD, still, gripper_toggles=toggles)
    assert loop.states[-1] is SessionState.ENGAGED
    return loop


Interrupt = Callable[..., dict[str, Any]]


def disengaged(loop: RemoteLoop, **changes: Any) -> dict[str, Any]:
    """Disengage, let the hand do this, and engage; what else the samples hold afterwards."""
    loop.ask(EngagementAction.DISENGAGE)
    loop.run(GOOD, still, **changes)
    loop.ask(EngagementAction.ENGAGE)
    return {}


def held(loop: RemoteLoop, **changes: Any) -> dict[str, Any]:
    loop.run(40)
    assert loop.states[-1] is SessionState.HOLDING
    loop.run(8 * EVERY, still, **changes)
    return {}


def renewed(loop: RemoteLoop, **changes: Any) -> dict[str, Any]:
    for revision in range(1, 6):
        intent = Intent(settings=OperatorSettings(lease=loop.lease, revision=revision))
        loop.run(EVERY, still, intent=intent, **changes)
    return {"intent": intent}


def lost(loop: RemoteLoop, **changes: Any) -> dict[str, Any]:
    loop.run(EVERY, still, status=TrackingStatus.LOST)
    loop.run(8 * EVERY, still, **changes)
    return {}


def a_toggle_is_forgotten(interrupt: Interrupt) -> None:
    loop = engaged(3)
    afterwards = interrupt(loop, gripper_toggles=4)
    loop.run(GOOD, still, gripper_toggles=4, **afterwards)
    assert loop.states[-1] is SessionState.ENGAGED
    assert (loop.gripper, loop.snapshot.gripper_toggles) == (GripperCommand.KEEP, 0)


@pytest.mark.parametrize("interrupt", [disengaged, held, renewed, lost])
def test_a_toggle_meanwhile_never_moves_the_gripper(interrupt: Interrupt) -> None:
    a_toggle_is_forgotten(interrupt)


@pytest.mark.parametrize("interrupt", [disengaged, held, renewed, lost])
def test_a_hand_that_opened_meanwhile_and_is_counted_afterwards_never_moves_the_gripper(
    interrupt: Interrupt,
) -> None:
    loop = engaged()
    afterwards = interrupt(loop, hand_open=True)
    loop.run(10 * EVERY, still, hand_open=True, gripper_toggles=1, **afterwards)
    loop.run(10 * EVERY, still, gripper_toggles=1, **afterwards)
    assert loop.states[-1] is SessionState.ENGAGED
    assert (loop.gripper, loop.snapshot.gripper_toggles) == (GripperCommand.KEEP, 0)
    loop.run(10 * EVERY, still, hand_open=True, gripper_toggles=2, **afterwards)
    assert (loop.gripper, loop.snapshot.gripper_toggles) == (GripperCommand.CLOSED, 1)


@pytest.mark.parametrize("ended", ["stopped", "faulted"])
def test_a_stop_and_a_fault_withdraw_what_the_gripper_was_ordered(ended: str) -> None:
    loop = engaged()
    loop.run(10 * EVERY, still, gripper_toggles=1)
    assert loop.gripper is GripperCommand.CLOSED
    if ended == "stopped":
        loop.ask(EngagementAction.STOP)
    else:
        loop.session.fault("the video process ended", loop.clock.now_ns())
    loop.run(EVERY, still, gripper_toggles=1)
    assert loop.gripper is GripperCommand.KEEP
    loop.ask(EngagementAction.RESET)
    loop.run(GOOD, still, gripper_toggles=1)
    loop.ask(EngagementAction.ENGAGE)
    loop.run(GOOD, still, gripper_toggles=1)
    assert loop.states[-1] is SessionState.ENGAGED
    assert loop.gripper is GripperCommand.KEEP
    loop.run(EVERY, still, gripper_toggles=2)
    assert loop.gripper is GripperCommand.OPEN


def test_a_hand_lost_for_a_single_frame_between_two_ticks_counts_nothing_either() -> None:
    loop = engaged()
    loop.run(1, still, status=TrackingStatus.LOST)
    loop.run(1, still, hand_open=True, gripper_toggles=1)
    loop.run(10 * EVERY, still, hand_open=True, gripper_toggles=1)
    assert loop.snapshot.gripper_toggles == 0


def test_a_toggle_in_a_sample_that_jumps_is_another_hands_and_counts_nothing() -> None:
    loop = engaged()
    loop.run(1, lambda _t_ns: (1.0, 0.0, 0.3), hand_open=True, gripper_toggles=1)
    assert loop.states[-1] is SessionState.ENGAGED
    loop.run(10 * EVERY, still, gripper_toggles=1)
    assert (loop.states[-1], loop.gripper) == (SessionState.ENGAGED, GripperCommand.KEEP)
    loop.run(10 * EVERY, still, hand_open=True, gripper_toggles=2)
    assert loop.gripper is GripperCommand.CLOSED


def test_a_count_as_large_as_a_message_can_hold_moves_nothing_whatever_follows_it() -> None:
    loop, most = engaged(), 2**63 - 1
    for k in range(6):
        loop.run(2 * EVERY, still, gripper_toggles=most * (k % 2))
        assert (loop.snapshot.gripper_toggles, loop.gripper) == (0, GripperCommand.KEEP)
    assert loop.states[-1] is SessionState.ENGAGED


@pytest.mark.parametrize(
    ("function", "line", "interrupt"),
    [
        ("_begin", "self._gripper.rebase(latest.sample, settings.revision)", disengaged),
        ("_begin", "self._gripper.rebase(latest.sample, settings.revision)", held),
    ],
)
def test_without_the_baseline_at_the_engagement_the_gripper_would_move(
    function: str, line: str, interrupt: Interrupt, monkeypatch: pytest.MonkeyPatch
) -> None:
    Mutation(TeleopPipeline, function, line, "pass").apply(monkeypatch)
    with pytest.raises(AssertionError):
        a_toggle_is_forgotten(interrupt)
