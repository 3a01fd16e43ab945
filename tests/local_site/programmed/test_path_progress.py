"""A run's progress: through, in steps, back, slower; standing until the gripper has done what it should."""

import numpy as np
import pytest

from common.messages.robot import GripperCommand, GripperState, GripperStatus
from local_site.programmed.path_progress import FASTEST, SLOWEST, PathProgress, RunOrder
from local_site.programmed.tool_trajectory import GripperAction, ToolTrajectory

DT_S = 1 / 60
OPEN = GripperState(0.06, 0.0, GripperCommand.KEEP, GripperStatus.OPEN)
CLOSING = GripperState(0.04, 0.0, GripperCommand.CLOSED, GripperStatus.MOVING)
HOLDS = GripperState(0.03, 9.0, GripperCommand.CLOSED, GripperStatus.HOLDING)


def path(*actions):
    positions = np.column_stack([np.linspace(0.0, 0.4, 5), np.zeros((5, 2))])
    orientations = np.tile([0.0, 0.0, 0.0, 1.0], (5, 1))
    return ToolTrajectory(np.arange(5.0), positions, orientations, marks=(0.0, 1.0, 2.0, 4.0), actions=actions)


def x_mm(progress):
    return round(1e3 * progress.target[0, 3])


def go(progress, seconds, gripper=None, hindered=""):
    """What the gripper was asked to do."""
    return {progress.advance(DT_S, gripper, hindered) for _ in range(round(seconds / DT_S))} - {None}


def test_through_to_the_end_without_a_stop():
    progress = PathProgress(path(), 1.0, stepwise=False)
    go(progress, 3.0)
    assert not progress.is_done
    go(progress, 3.0)
    assert progress.is_done
    assert progress.way_point == progress.way_points == 4


def test_in_steps_it_stands_at_each_way_point_until_the_next_order():
    progress = PathProgress(path(), 1.0, stepwise=True)
    for order, x in [(None, 100), (RunOrder.NEXT, 200), (RunOrder.BACK, 100), (RunOrder.BACK, 0)]:
        if order is not None:
            progress.order(order)
        go(progress, 3.0)
        assert x_mm(progress) == x
    assert progress.why.startswith("paused")
    for _ in range(3):
        progress.order(RunOrder.PAUSE)
        go(progress, 4.0)
    assert progress.is_done


def test_a_pause_stands_and_goes_on_from_there():
    progress = PathProgress(path(), 1.0, stepwise=False)
    go(progress, 1.0)
    progress.order(RunOrder.PAUSE)
    go(progress, 1.0)
    stood = progress.target
    go(progress, 1.0)
    assert progress.target == pytest.approx(stood)
    progress.order(RunOrder.PAUSE)
    go(progress, 6.0)
    assert progress.is_done


def test_the_speed_stays_within_bounds():
    progress = PathProgress(path(), 1.0, stepwise=False)
    for order, most in [(RunOrder.SLOWER, SLOWEST), (RunOrder.FASTER, FASTEST)]:
        for _ in range(40):
            progress.order(order)
        assert progress.speed == most


def test_it_waits_for_the_gripper_and_then_dwells():
    progress = PathProgress(path(GripperAction(2.0, GripperCommand.CLOSED, 1.0)), 1.0, stepwise=False)
    assert go(progress, 4.0, OPEN) == {GripperCommand.CLOSED}
    assert go(progress, 4.0, CLOSING) == {GripperCommand.CLOSED}
    assert "closed" in progress.why
    go(progress, 0.8, HOLDS)
    assert x_mm(progress) == 200
    go(progress, 4.0, HOLDS)
    assert progress.is_done


def test_the_gripper_is_asked_at_every_step_until_it_has_done_it():
    progress = PathProgress(path(GripperAction(2.0, GripperCommand.CLOSED)), 1.0, stepwise=False)
    go(progress, 4.0, OPEN)
    assert progress.acts
    assert [progress.advance(DT_S, CLOSING, "") for _ in range(30)] == [GripperCommand.CLOSED] * 30
    assert progress.acts


def test_a_gripper_that_loses_what_it_holds_begins_its_rest_anew():
    progress = PathProgress(path(GripperAction(2.0, GripperCommand.CLOSED, 1.0)), 1.0, stepwise=False)
    go(progress, 4.0, OPEN)
    for state, seconds in ((HOLDS, 0.7), (CLOSING, 0.5), (HOLDS, 0.9)):
        go(progress, seconds, state)
    assert x_mm(progress) == 200
    go(progress, 0.6, HOLDS)
    assert x_mm(progress) > 200


def test_a_gripper_that_is_so_already_is_asked_nothing():
    progress = PathProgress(path(GripperAction(2.0, GripperCommand.OPEN)), 1.0, stepwise=False)
    assert go(progress, 8.0, OPEN) == set()
    assert progress.is_done


def test_the_way_back_leaves_the_gripper_and_the_way_on_has_it_act_again():
    progress = PathProgress(path(GripperAction(1.0, GripperCommand.CLOSED)), 1.0, stepwise=True)
    go(progress, 2.0, OPEN)
    go(progress, 2.0, HOLDS)
    progress.order(RunOrder.NEXT)
    go(progress, 3.0, HOLDS)
    progress.order(RunOrder.BACK)
    assert go(progress, 3.0, OPEN) == set()
    assert x_mm(progress) == 100
    progress.order(RunOrder.BACK)
    assert go(progress, 3.0, OPEN) == set()
    progress.order(RunOrder.NEXT)
    assert go(progress, 4.0, OPEN) == {GripperCommand.CLOSED}


def test_hindered_it_stands_and_says_so():
    progress = PathProgress(path(), 1.0, stepwise=False)
    go(progress, 1.0)
    go(progress, 1.0, hindered="the arm is 70 mm behind")
    stood = x_mm(progress)
    go(progress, 1.0, hindered="the arm is 70 mm behind")
    assert x_mm(progress) == stood
    assert "behind" in progress.why
