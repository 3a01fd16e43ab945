"""The gripper's status: watched until its opening is stable, and with KEEP judged by what is measured."""

from collections.abc import Sequence

import pytest

from common.clock import NS_PER_MS
from common.messages.robot import GripperCommand, GripperStatus
from remote_site.drivers.driver import GripperReading
from remote_site.drivers.supervisor.grip import GripSettings, GripWatch
from tests.remote_site.drivers.supervisor.supervised import Supervised

OPEN, CLOSED, KEEP = GripperCommand.OPEN, GripperCommand.CLOSED, GripperCommand.KEEP
WIDE, BETWEEN, SHUT = [0.065] * 20, [0.03] * 20, [0.001] * 20  # 200 ms each


class Watched:
    """A gripper that is watched every 10 ms."""

    def __init__(self) -> None:
        self._watch, self._now_ns = GripWatch(GripSettings()), 0

    def see(self, openings_m: Sequence[float], command: GripperCommand, force_n: float | None = None) -> GripperStatus:
        """The status after these openings under a command."""
        for opening_m in openings_m:
            self._now_ns += 10 * NS_PER_MS
            self._watch.observe(GripperReading(opening_m, force_n), self._now_ns, command)
        assert self._watch.state is not None
        assert self._watch.state.commanded is command
        return self._watch.state.status


@pytest.mark.parametrize(
    ("openings_m", "command", "status"),
    [
        ([0.065, 0.03, 0.001, *SHUT], CLOSED, GripperStatus.CLOSED),
        ([0.065, 0.055, 0.05] + [0.0501, 0.0499] * 10, CLOSED, GripperStatus.HOLDING),
        ([0.05, 0.06, 0.065, *WIDE], OPEN, GripperStatus.OPEN),
        ([0.05, 0.06] + [0.065] * 5, OPEN, GripperStatus.MOVING),
        ([0.065] * 260, CLOSED, GripperStatus.TIMED_OUT),
        ([0.01, 0.02] + [0.03] * 260, OPEN, GripperStatus.TIMED_OUT),
        ([0.065, 0.05] + [0.05] * 30 + [0.03, 0.001, *SHUT], CLOSED, GripperStatus.CLOSED),
    ],
)
def test_the_gripper_is_watched_until_it_is_stable(
    openings_m: list[float], command: GripperCommand, status: GripperStatus
) -> None:
    watched = Watched()
    watched.see([openings_m[0]] * 20, KEEP)
    assert watched.see(openings_m, command) is status


@pytest.mark.parametrize(
    ("opening_m", "force_n", "status"),
    [
        (0.001, None, GripperStatus.CLOSED),
        (0.001, 25.0, GripperStatus.CLOSED),
        (0.065, None, GripperStatus.OPEN),
        (0.065, 0.0, GripperStatus.OPEN),
        (0.03, 25.0, GripperStatus.HOLDING),
        (0.05, 25.0, GripperStatus.HOLDING),
        (0.03, 0.5, GripperStatus.UNKNOWN),
        (0.03, None, GripperStatus.UNKNOWN),
    ],
)
def test_with_nothing_commanded_the_measurements_decide_once_they_are_stable_and_nothing_times_out(
    opening_m: float, force_n: float | None, status: GripperStatus
) -> None:
    watched = Watched()
    assert watched.see([opening_m] * 10, KEEP, force_n) is GripperStatus.MOVING
    assert watched.see([opening_m] * 300, KEEP, force_n) is status
    assert watched.see([0.02, 0.025], KEEP, force_n) is GripperStatus.MOVING


@pytest.mark.parametrize(("opening_m", "status"), [(0.001, GripperStatus.CLOSED), (0.03, GripperStatus.HOLDING)])
def test_a_gripper_that_is_closed_already_need_not_move_to_be_closed(opening_m: float, status: GripperStatus) -> None:
    watched = Watched()
    watched.see([opening_m] * 20, KEEP)
    assert watched.see([opening_m] * 300, CLOSED) is status


def test_what_a_command_has_reached_is_kept_with_keep_until_the_gripper_moves() -> None:
    watched = Watched()
    watched.see(WIDE, KEEP)
    assert watched.see([0.05, *BETWEEN], CLOSED) is GripperStatus.HOLDING
    assert watched.see([0.03] * 300, KEEP) is GripperStatus.HOLDING
    assert watched.see([0.03] * 2, CLOSED) is GripperStatus.MOVING
    assert watched.see([0.03] * 300, CLOSED) is GripperStatus.HOLDING
    assert watched.see([0.03] * 300, KEEP) is GripperStatus.HOLDING
    assert watched.see(WIDE, KEEP) is GripperStatus.OPEN
    assert watched.see(BETWEEN, KEEP) is GripperStatus.UNKNOWN


def test_a_command_that_has_timed_out_is_forgotten_with_keep() -> None:
    watched = Watched()
    watched.see(WIDE, KEEP)
    assert watched.see([0.065] * 260, CLOSED) is GripperStatus.TIMED_OUT
    assert watched.see([0.065] * 260, KEEP) is GripperStatus.OPEN


def test_a_gripper_that_reverses_has_to_move_again() -> None:
    watched = Watched()
    watched.see(WIDE, KEEP)
    watched.see([0.06, 0.05, 0.04], CLOSED)
    assert watched.see([0.04] * 20, OPEN) is GripperStatus.MOVING
    watched.see([0.05], OPEN)
    assert watched.see([0.05] * 20, CLOSED) is GripperStatus.MOVING


def test_the_gripper_is_reported_with_its_command_and_only_while_it_is_measured(rig: Supervised) -> None:
    rig.robot.opening_m = 0.05
    rig.activate()
    for _ in range(3):
        rig.command(rig.sent, gripper=CLOSED)
    gripper = rig.supervisor.grip.state
    assert gripper is not None
    assert (gripper.opening, gripper.force, gripper.commanded) == (0.05, None, CLOSED)
    rig.robot.opening_m = None
    rig.command(rig.sent, gripper=CLOSED)
    assert rig.supervisor.grip.state is None
