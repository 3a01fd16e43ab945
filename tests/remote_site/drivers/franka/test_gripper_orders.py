"""An order to the FR3's gripper is done within a second, over a link that was up, by no later activation; or never."""

from collections.abc import Callable

import pytest

from common.clock import NS_PER_MS
from common.messages.robot import GripperCommand
from remote_site.drivers.gripper_orders import ORDER_NS
from remote_site.kinematics.joints import JointMotion
from tests.remote_site.drivers.franka.driven_arm import DrivenArm
from tests.remote_site.drivers.franka.fake_robot import SETUP, FakeGripper

CLOSES = f"close {SETUP.grip_force_n:g}"
HELD_M = 0.03
LATE_MS = ORDER_NS // NS_PER_MS + 50


def holding() -> DrivenArm:
    """An active arm whose gripper holds something, and is measured."""
    arm = DrivenArm(gripper=FakeGripper(opening_m=HELD_M, object_m=HELD_M)).activate()
    arm.side.pass_ms(30)
    return arm


def order(arm: DrivenArm, gripper: GripperCommand, ms: int = 30) -> None:
    """The gripper's command with every motion for this long."""
    for _ in range(max(ms // 10, 1)):
        arm.write(JointMotion.at_rest(arm.read().q), gripper)
        arm.side.pass_ms(10)


def opening_m(arm: DrivenArm) -> float | None:
    grip = arm.read().gripper
    return None if grip is None else grip.opening_m


def nothing(_: DrivenArm) -> None:
    """The link alone has gone and come."""


def stop(arm: DrivenArm) -> None:
    arm.driver.stop()
    arm.side.pass_ms(60)


def stop_and_activate(arm: DrivenArm) -> None:
    stop(arm)
    arm.activate()
    order(arm, GripperCommand.KEEP)


@pytest.mark.parametrize("meanwhile", [nothing, stop, stop_and_activate])
def test_what_is_ordered_while_the_link_is_down_is_never_done(meanwhile: Callable[[DrivenArm], None]) -> None:
    arm = holding()
    arm.gripper.lost = True
    arm.side.pass_ms(20)
    order(arm, GripperCommand.OPEN)
    meanwhile(arm)
    assert opening_m(arm) is None
    arm.gripper.lost = False
    arm.side.pass_ms(100)
    if meanwhile is not stop:
        order(arm, GripperCommand.KEEP if meanwhile is stop_and_activate else GripperCommand.OPEN)
    assert arm.gripper.calls == []
    assert opening_m(arm) == HELD_M


def test_the_next_order_after_the_link_is_back_is_done() -> None:
    arm = holding()
    arm.gripper.lost = True
    order(arm, GripperCommand.OPEN)
    arm.gripper.lost = False
    arm.side.pass_ms(30)
    for gripper in (GripperCommand.CLOSED, GripperCommand.OPEN):
        order(arm, gripper)
    assert arm.gripper.calls == [CLOSES, "open 0.08"]


@pytest.mark.parametrize("withdraw", [stop, stop_and_activate])
def test_a_stop_and_an_activation_withdraw_what_waits_behind_a_call_that_has_not_returned(
    withdraw: Callable[[DrivenArm], None],
) -> None:
    arm = holding()
    arm.side.gripper_waits = True
    order(arm, GripperCommand.OPEN)
    withdraw(arm)
    arm.side.gripper_waits = False
    arm.side.pass_ms(30)
    assert arm.gripper.calls == []
    assert opening_m(arm) == HELD_M


@pytest.mark.parametrize(("waits_ms", "calls"), [(LATE_MS - 200, ["open 0.08"]), (LATE_MS, [])])
def test_an_order_that_waits_for_longer_than_a_second_is_never_done(waits_ms: int, calls: list[str]) -> None:
    arm = holding()
    arm.side.gripper_waits = True
    order(arm, GripperCommand.OPEN, waits_ms)
    arm.side.gripper_waits = False
    order(arm, GripperCommand.OPEN)
    assert arm.gripper.calls == calls


def test_of_what_waits_the_newest_is_done() -> None:
    arm = holding()
    arm.side.gripper_waits = True
    for gripper in (GripperCommand.OPEN, GripperCommand.CLOSED):
        order(arm, gripper)
    arm.side.gripper_waits = False
    order(arm, GripperCommand.CLOSED)
    assert arm.gripper.calls == [CLOSES]


def test_after_an_activation_the_same_command_is_a_new_order() -> None:
    arm = holding()
    order(arm, GripperCommand.CLOSED)
    stop_and_activate(arm)
    order(arm, GripperCommand.CLOSED)
    assert arm.gripper.calls == [CLOSES, CLOSES]


def test_what_is_withdrawn_leaves_the_opening_measured() -> None:
    arm = holding()
    arm.side.gripper_waits = True
    order(arm, GripperCommand.OPEN)
    order(arm, GripperCommand.KEEP)
    arm.side.gripper_waits = False
    arm.side.pass_ms(30)
    assert arm.gripper.calls == []
    assert opening_m(arm) == HELD_M
