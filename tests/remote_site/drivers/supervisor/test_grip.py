"""The gripper's status: watched until its opening is stable."""

import pytest

from common.clock import NS_PER_MS
from common.messages.robot import GripperStatus
from remote_site.drivers.supervisor.grip import GripSettings, GripWatch
from tests.remote_site.drivers.supervisor.supervised import Supervised


@pytest.mark.parametrize(
    ("openings_m", "wanted_open", "status"),
    [
        ([0.065, 0.03, 0.001] + [0.001] * 20, False, GripperStatus.CLOSED),
        ([0.065, 0.055, 0.05] + [0.0501, 0.0499] * 10, False, GripperStatus.HOLDING),
        ([0.05, 0.06, 0.065] + [0.065] * 20, True, GripperStatus.OPEN),
        ([0.05, 0.06] + [0.065] * 5, True, GripperStatus.MOVING),
        ([0.065] * 260, False, GripperStatus.TIMED_OUT),
        ([0.01, 0.02] + [0.03] * 260, True, GripperStatus.TIMED_OUT),
        ([0.065, 0.05] + [0.05] * 30 + [0.03, 0.001] + [0.001] * 20, False, GripperStatus.CLOSED),
    ],
)
def test_the_gripper_is_watched_until_it_is_stable(
    openings_m: list[float], wanted_open: bool, status: GripperStatus
) -> None:
    watch = GripWatch(GripSettings())
    watch.judge(0, openings_m[0], wanted_open=not wanted_open)
    for k, opening_m in enumerate(openings_m, start=1):
        seen = watch.judge(k * 10 * NS_PER_MS, opening_m, wanted_open=wanted_open)
    assert seen is status


def test_the_gripper_is_reported_with_its_command(rig: Supervised) -> None:
    rig.robot.opening_m = 0.05
    rig.activate()
    for _ in range(3):
        rig.command(rig.sent, gripper_open=False)
    gripper = rig.supervisor.grip.state
    assert (gripper.opening, gripper.force, gripper.commanded_open) == (0.05, None, False)
