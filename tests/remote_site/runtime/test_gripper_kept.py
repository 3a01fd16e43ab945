"""What the gripper holds is kept by every start, activation, reset and engagement; only a toggle moves it."""

from collections.abc import Callable

import pytest

from common.messages.requests import EngagementAction
from common.messages.robot import GripperCommand, GripperStatus
from remote_site.drivers.faults import STOPPED
from tests.remote_site.runtime.started_site import (
    OBJECT_M,
    TURN_MS,
    TURNS_PER_TICK,
    Robot,
    StartedSite,
    a465_holding,
    simulated_closed,
)

OPEN, CLOSED, KEEP = GripperCommand.OPEN, GripperCommand.CLOSED, GripperCommand.KEEP
TICK_MS = TURN_MS * TURNS_PER_TICK
GRIP_MS = 1500  # to open or to close
MAKES = pytest.mark.parametrize("make", [simulated_closed, a465_holding])
Make = Callable[[], Robot]


@MAKES
def test_a_start_of_the_remote_site_does_not_open_the_gripper(make: Make) -> None:
    robot = make()
    held_m = robot.opening_m()
    StartedSite(robot).ready().run(GRIP_MS)
    assert robot.opening_m() == pytest.approx(held_m, abs=1e-4)


@pytest.mark.slow
@MAKES
def test_an_engagement_does_not_move_the_gripper_whatever_was_counted_before(make: Make) -> None:
    robot = make()
    held_m, site = robot.opening_m(), StartedSite(robot).ready()
    site.toggles = 3
    site.engaged().run(GRIP_MS)
    site.run(TICK_MS, EngagementAction.DISENGAGE)
    site.toggles += 1
    site.engaged().run(GRIP_MS)
    assert robot.opening_m() == pytest.approx(held_m, abs=1e-4)
    assert site.snapshot.gripper_toggles == 0


@pytest.mark.slow
@MAKES
def test_a_restart_a_stop_and_a_reset_keep_what_a_toggle_has_done(make: Make) -> None:
    robot = make()
    site = StartedSite(robot).ready().engaged().closed()
    held_m = robot.opening_m()
    site.supervisor.stop(STOPPED, site.clock.now_ns())
    site.run(GRIP_MS)
    site.run(TICK_MS, EngagementAction.RESET)
    site.run(GRIP_MS)
    assert robot.opening_m() == pytest.approx(held_m, abs=1e-4)
    assert site.link.read().ready
    site.engaged().run(GRIP_MS)
    StartedSite(robot).ready().engaged().run(GRIP_MS)
    assert robot.opening_m() == pytest.approx(held_m, abs=1e-4)


def test_after_a_reset_no_command_is_given_again_until_a_toggle() -> None:
    """Somebody has opened the gripper by hand while the robot was stopped: the reset does not close it."""
    robot = a465_holding()
    site = StartedSite(robot).ready().engaged().closed()
    site.supervisor.stop(STOPPED, site.clock.now_ns())
    site.run(GRIP_MS)
    robot.open_by_hand()
    site.run(TICK_MS, EngagementAction.RESET)
    site.run(GRIP_MS)
    assert robot.opening_m() > OBJECT_M
    assert site.snapshot.gripper_next is CLOSED


def test_a_simulated_gripper_that_is_closed_is_opened_by_the_first_toggle() -> None:
    robot = simulated_closed()
    site = StartedSite(robot).ready().engaged()
    assert site.snapshot.gripper_next is OPEN
    site.toggled(1)
    assert robot.opening_m() > 0.06
    assert site.snapshot.gripper_next is CLOSED


def test_a_load_that_no_measurement_shows_is_gripped_again_by_the_first_toggle_and_dropped_by_the_second() -> None:
    robot = a465_holding()
    site = StartedSite(robot).ready().engaged()
    assert site.status is GripperStatus.UNKNOWN
    assert site.snapshot.gripper_next is CLOSED
    site.toggled(1)
    assert robot.opening_m() == OBJECT_M
    assert site.status is GripperStatus.HOLDING
    assert site.snapshot.gripper_next is OPEN
    site.toggled(1)
    assert robot.opening_m() > OBJECT_M


@pytest.mark.slow
@MAKES
def test_another_operator_finds_the_gripper_as_it_was_left(make: Make) -> None:
    robot = make()
    site = StartedSite(robot).ready().engaged()
    held_m = robot.opening_m()
    site.hand_over("ben")
    site.engaged().run(GRIP_MS)
    assert robot.opening_m() == pytest.approx(held_m, abs=1e-4)
    site.closed()
    closed_m = robot.opening_m()
    site.hand_over("anna")
    site.engaged().run(GRIP_MS)
    assert robot.opening_m() == pytest.approx(closed_m, abs=1e-4)
    assert site.snapshot.gripper_next is OPEN


def test_a_start_commands_nothing_of_the_gripper() -> None:
    site = StartedSite(a465_holding()).ready().engaged()
    site.run(GRIP_MS)
    assert site.driven.report.gripper is not None
    assert site.driven.report.gripper.commanded is KEEP


@pytest.mark.slow
@MAKES
def test_the_second_of_two_quick_toggles_undoes_the_first_while_the_fingers_still_move(make: Make) -> None:
    robot = make()
    site = StartedSite(robot).ready().engaged().closed()
    closed_m, toggles = robot.opening_m(), site.snapshot.gripper_toggles
    site.toggles += 1
    site.run(200)
    assert site.status is GripperStatus.MOVING
    assert site.snapshot.gripper_next is CLOSED
    site.toggled(1)
    assert robot.opening_m() == pytest.approx(closed_m, abs=1e-4)
    assert site.snapshot.gripper_toggles == toggles + 2
