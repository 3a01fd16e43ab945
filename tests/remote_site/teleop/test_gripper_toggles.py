"""Gripper toggles: a count that is applied once, and only while engaged."""

from hypothesis import given
from hypothesis import strategies as st

from remote_site.teleop.gripper_toggles import GripperToggles


def test_each_new_count_toggles_once() -> None:
    gripper = GripperToggles(is_open=True)
    gripper.rebase(5)
    states = []
    for count in (5, 5, 6, 6, 7, 9):
        gripper.follow(count)
        states.append(gripper.is_open)
    assert states == [True, True, False, False, True, True]
    assert gripper.applied == 4


def test_what_was_counted_before_the_engagement_is_never_applied() -> None:
    gripper = GripperToggles(is_open=False)
    gripper.rebase(2)
    gripper.rebase(5)
    gripper.follow(5)
    assert (gripper.is_open, gripper.applied) == (False, 0)


def test_a_count_that_falls_is_a_new_baseline() -> None:
    gripper = GripperToggles(is_open=True)
    gripper.rebase(5)
    gripper.follow(0)
    gripper.follow(1)
    assert (gripper.is_open, gripper.applied) == (False, 1)


@given(st.lists(st.booleans(), max_size=50))
def test_losing_or_doubling_messages_changes_nothing_in_the_end(seen: list[bool]) -> None:
    every, some = GripperToggles(is_open=True), GripperToggles(is_open=True)
    every.rebase(0)
    some.rebase(0)
    for count, is_seen in enumerate(seen, start=1):
        every.follow(count)
        if is_seen:
            some.follow(count)
            some.follow(count)
    every.follow(len(seen))
    some.follow(len(seen))
    assert (some.is_open, some.applied) == (every.is_open, every.applied)
