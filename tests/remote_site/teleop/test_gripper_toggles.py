"""Gripper toggles: a count that is applied once, only while engaged, and what each of them means."""

import pytest
from hypothesis import given
from hypothesis import strategies as st

from common.messages.hand import HandArm
from common.messages.robot import GripperCommand, GripperState, GripperStatus
from remote_site.teleop.gripper_toggles import MOST_AT_ONCE, GripperToggles
from tests.remote_site.remote_loop import hand

OPEN, CLOSED, KEEP = GripperCommand.OPEN, GripperCommand.CLOSED, GripperCommand.KEEP


def measured(status: GripperStatus, commanded: GripperCommand = KEEP) -> GripperState:
    return GripperState(0.03, None, commanded, status)


def sample(count: int, *, hand_open: bool = False) -> HandArm:
    """A hand sample with this count."""
    return hand(1, 0, gripper_toggles=count, hand_open=hand_open)


def engaged(count: int = 0) -> GripperToggles:
    gripper = GripperToggles()
    gripper.rebase(sample(count), 0)
    return gripper


def test_each_new_count_toggles_once() -> None:
    gripper, commands = engaged(5), []
    for count in (5, 5, 6, 6, 7, 9):
        gripper.follow(sample(count), 0, None)
        commands.append(gripper.command)
    assert commands == [KEEP, KEEP, CLOSED, CLOSED, OPEN, OPEN]
    assert gripper.applied == 4


def test_what_was_counted_before_the_engagement_is_never_applied() -> None:
    gripper = engaged(2)
    gripper.rebase(sample(5), 0)
    gripper.follow(sample(5), 0, None)
    assert (gripper.command, gripper.applied) == (KEEP, 0)


def test_a_count_that_falls_is_a_new_baseline() -> None:
    gripper = engaged(5)
    gripper.follow(sample(0), 0, None)
    gripper.follow(sample(1), 0, None)
    assert (gripper.command, gripper.applied) == (CLOSED, 1)


@pytest.mark.parametrize(
    ("status", "command"),
    [
        (GripperStatus.CLOSED, OPEN),
        (GripperStatus.HOLDING, OPEN),
        (GripperStatus.OPEN, CLOSED),
        (GripperStatus.MOVING, CLOSED),
        (GripperStatus.TIMED_OUT, CLOSED),
        (GripperStatus.UNKNOWN, CLOSED),
        (None, CLOSED),
    ],
)
def test_the_first_toggle_opens_what_is_closed_or_holds_and_closes_anything_else(
    status: GripperStatus | None, command: GripperCommand
) -> None:
    gripper, state = engaged(), measured(status) if status is not None else None
    assert gripper.next(state) is command
    gripper.follow(sample(1), 0, state)
    assert gripper.command is command


@pytest.mark.parametrize("status", [*GripperStatus, None])
@pytest.mark.parametrize("first", [GripperStatus.HOLDING, GripperStatus.UNKNOWN])
def test_a_second_toggle_undoes_the_first_as_long_as_nothing_newer_is_measured(
    first: GripperStatus, status: GripperStatus | None
) -> None:
    """Neither a report that is older than the first toggle counts, nor that the fingers move."""
    gripper = engaged()
    gripper.follow(sample(1), 0, measured(first))
    commanded = gripper.command
    state = measured(status) if status is not None else None
    assert gripper.next(state) is not commanded
    assert gripper.next(measured(GripperStatus.MOVING, commanded)) is not commanded
    assert gripper.next(measured(GripperStatus.TIMED_OUT, commanded)) is not commanded


@pytest.mark.parametrize("first", [GripperStatus.HOLDING, GripperStatus.OPEN, GripperStatus.UNKNOWN])
def test_two_toggles_in_one_sample_go_back_and_forth(first: GripperStatus) -> None:
    one, both = engaged(), engaged()
    one.follow(sample(1), 0, measured(first))
    both.follow(sample(2), 0, measured(first))
    assert both.command is not one.command
    assert both.applied == 2
    one.follow(sample(2), 0, measured(first))
    assert one.command is both.command


def test_after_an_activation_the_gripper_is_kept_and_the_measurement_decides_again() -> None:
    gripper = engaged()
    gripper.follow(sample(1), 0, None)
    gripper.keep()
    gripper.rebase(sample(1), 0)
    assert gripper.command is KEEP
    assert gripper.next(measured(GripperStatus.OPEN)) is CLOSED  # somebody has opened it meanwhile
    assert gripper.next(measured(GripperStatus.HOLDING)) is OPEN
    assert gripper.next(measured(GripperStatus.UNKNOWN)) is OPEN  # as far as is known it is still closed


@pytest.mark.parametrize("ahead", [MOST_AT_ONCE + 1, 2**53 + 1, 2**63 - 1])
def test_a_count_that_no_hand_makes_moves_nothing_and_is_a_new_baseline(ahead: int) -> None:
    """A load would be dropped by a number that is damaged or forged, and the sum of such numbers has no bound."""
    gripper = engaged()
    for _ in range(3):
        gripper.follow(sample(ahead), 0, None)
        assert (gripper.command, gripper.applied) == (KEEP, 0)
        gripper.follow(sample(0), 0, None)
    gripper.follow(sample(1), 0, None)
    assert (gripper.command, gripper.applied) == (CLOSED, 1)


def test_as_many_as_a_hand_can_make_while_samples_are_lost_count() -> None:
    gripper = engaged()
    gripper.follow(sample(MOST_AT_ONCE), 0, None)
    assert (gripper.command, gripper.applied) == (OPEN, MOST_AT_ONCE)


@given(st.lists(st.booleans(), max_size=50), st.sampled_from([*GripperStatus, None]))
def test_losing_or_doubling_messages_changes_nothing_in_the_end(seen: list[bool], status: GripperStatus | None) -> None:
    every, some, state = engaged(), engaged(), measured(status) if status is not None else None
    for count, is_seen in enumerate(seen, start=1):
        every.follow(sample(count), 0, state)
        if is_seen:
            some.follow(sample(count), 0, state)
            some.follow(sample(count), 0, state)
    every.follow(sample(len(seen)), 0, state)
    some.follow(sample(len(seen)), 0, state)
    assert (some.command, some.applied) == (every.command, every.applied)


def test_a_hand_that_was_open_at_the_engagement_has_to_be_seen_closed_first() -> None:
    gripper = GripperToggles()
    gripper.rebase(sample(4, hand_open=True), 0)
    gripper.follow(sample(5, hand_open=True), 0, None)
    gripper.follow(sample(5), 0, None)
    assert gripper.applied == 0
    gripper.follow(sample(6, hand_open=True), 0, None)
    assert gripper.applied == 1


def test_a_hand_that_was_lost_has_to_be_seen_closed_again() -> None:
    gripper = engaged()
    gripper.interrupt()
    gripper.follow(sample(1, hand_open=True), 0, None)
    assert gripper.applied == 0


def test_a_toggle_with_new_origins_is_not_applied() -> None:
    gripper = engaged()
    gripper.follow(sample(1, hand_open=True), 1, None)
    gripper.follow(sample(2, hand_open=True), 2, None)
    gripper.follow(sample(2), 2, None)
    assert gripper.applied == 0
    gripper.follow(sample(3, hand_open=True), 2, None)
    assert gripper.applied == 1
