"""What the gripper is ordered reaches the driver within a second, in no stop, and never from before an activation."""

from common.clock import NS_PER_MS
from common.messages.robot import GripperCommand, GripperStatus
from remote_site.drivers.faults import FaultCode, RobotFault
from remote_site.drivers.gripper_orders import ORDER_NS, GripperOrders
from tests.remote_site.drivers.supervisor.supervised import Supervised

OPEN, CLOSED, KEEP = GripperCommand.OPEN, GripperCommand.CLOSED, GripperCommand.KEEP
LATE_MS = ORDER_NS / NS_PER_MS + 1


def given(supervised: Supervised) -> list[GripperCommand]:
    """What the driver was given for the gripper since the last call."""
    written = [command.gripper for command in supervised.robot.written]
    supervised.robot.written.clear()
    return written


def test_an_order_that_a_stop_finds_unwritten_is_never_written() -> None:
    supervised = Supervised(rate_hz=15.0).moving()
    given(supervised)
    orders = [supervised.order(supervised.plan(), gripper=OPEN), supervised.order(supervised.plan(), run=False)]
    supervised.turn(*orders)
    supervised.turns(600)
    assert set(given(supervised)) == {KEEP}
    assert supervised.fault().code.value == "stopped"
    supervised.activate(supervised.motion.q)
    supervised.commands(60)
    assert set(given(supervised)) == {KEEP}


def test_what_was_ordered_before_a_fault_is_not_repeated_by_the_first_writes_of_an_activation() -> None:
    supervised = Supervised(rate_hz=15.0).activate()
    for _ in range(40):
        supervised.command(supervised.motion, gripper=OPEN)
    assert OPEN in given(supervised)
    supervised.robot.trouble = RobotFault(FaultCode.ROBOT, "as commanded")
    supervised.turns(2)
    supervised.robot.trouble = None
    supervised.activate(supervised.motion.q)
    supervised.turns(100)
    assert set(given(supervised)) == {KEEP}


def test_an_order_that_late_commands_find_unwritten_waits_for_the_command_that_takes_over() -> None:
    supervised = Supervised(rate_hz=15.0).moving()
    given(supervised)
    while not given(supervised):
        supervised.command()
    supervised.commands(10)
    supervised.command(gripper=OPEN)
    supervised.stumble(34)
    assert given(supervised) == [KEEP]
    supervised.command(supervised.stop_at(4), gripper=OPEN)
    for _ in range(20):
        supervised.command(gripper=OPEN)
    assert set(given(supervised)) == {OPEN}


def test_an_order_that_a_pause_of_the_drivers_process_has_made_old_is_not_written() -> None:
    supervised = Supervised().activate()
    supervised.command(supervised.motion)
    given(supervised)
    old = supervised.order(supervised.motion, gripper=OPEN)
    supervised.turn(old, ms=LATE_MS)
    supervised.command(supervised.motion, gripper=OPEN)
    assert given(supervised) == [KEEP, KEEP]
    for gripper in (CLOSED, OPEN):
        supervised.command(supervised.motion, gripper=gripper)
    assert given(supervised) == [CLOSED, OPEN]


def test_an_order_of_a_slow_robot_that_a_pause_has_made_old_before_it_was_written_is_not_written() -> None:
    supervised = Supervised(rate_hz=15.0).activate()
    while not given(supervised):
        supervised.command(supervised.motion)
    supervised.command(supervised.motion, gripper=OPEN)
    assert given(supervised) == []
    supervised.clock.advance_ms(LATE_MS)
    for _ in range(60):
        supervised.command(supervised.motion, gripper=OPEN)
    assert set(given(supervised)) == {KEEP}


def test_an_order_that_waits_for_less_than_a_second_is_written_with_every_command() -> None:
    supervised = Supervised().activate()
    supervised.command(supervised.motion)
    given(supervised)
    supervised.turn(supervised.order(supervised.motion, gripper=OPEN), ms=LATE_MS - 2)
    for _ in range(400):
        supervised.command(supervised.motion, gripper=OPEN)
    assert set(given(supervised)) == {OPEN}


def test_an_order_is_taken_once_and_the_newest_counts() -> None:
    orders = GripperOrders()
    assert orders.note(KEEP, 0) is None
    assert orders.note(OPEN, 0) is not None
    assert orders.note(OPEN, 1) is None
    assert orders.note(CLOSED, 2) is not None
    assert [orders.take(3), orders.take(4)] == [CLOSED, KEEP]


def test_an_order_is_too_old_after_a_second_and_withdrawn_at_once() -> None:
    orders = GripperOrders()
    orders.note(OPEN, 0)
    assert orders.take(ORDER_NS + 1) is KEEP
    assert orders.note(OPEN, ORDER_NS) is None
    orders.note(CLOSED, ORDER_NS)
    orders.withdraw()
    assert orders.take(ORDER_NS) is KEEP
    assert orders.note(CLOSED, ORDER_NS) is not None
    assert orders.take(2 * ORDER_NS) is CLOSED


def test_an_order_stands_from_when_it_is_begun_in_time_until_it_is_withdrawn() -> None:
    orders = GripperOrders()
    orders.note(OPEN, 0)
    assert orders.standing is KEEP
    orders.take(ORDER_NS)
    assert orders.standing is OPEN
    orders.note(CLOSED, 0)
    assert orders.standing is KEEP
    orders.take(ORDER_NS + 1)
    assert orders.standing is KEEP
    orders.note(OPEN, ORDER_NS)
    orders.take(ORDER_NS)
    orders.note(KEEP, ORDER_NS)
    assert orders.standing is KEEP


def test_what_has_begun_goes_on_while_late_commands_have_the_arm_braked() -> None:
    supervised = Supervised().moving()
    supervised.command(gripper=OPEN)
    given(supervised)
    supervised.stumble(34)
    assert set(given(supervised)) == {OPEN}
    supervised.turn(supervised.order(supervised.motion, run=False))
    supervised.turns(20)
    assert given(supervised)[1:] == [KEEP] * 20


def test_a_gripper_whose_order_a_stop_has_withdrawn_is_ordered_nothing_and_cannot_be_late() -> None:
    supervised = Supervised()
    supervised.robot.opening_m = 0.02  # it does not answer
    supervised.activate()
    supervised.command(supervised.motion, gripper=CLOSED)
    supervised.turn(supervised.order(supervised.motion, run=False))
    supervised.turns(1200)
    state = supervised.supervisor.grip.state
    assert state is not None
    assert (state.commanded, state.status) == (KEEP, GripperStatus.UNKNOWN)
