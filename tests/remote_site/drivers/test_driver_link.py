"""Control's side of the memory that it shares with the driver's process."""

import numpy as np

from common.clock import NS_PER_MS, MonotonicClock
from common.messages.robot import GripperCommand
from remote_site.drivers.driver import JointCommand
from remote_site.drivers.link import DriverLink
from remote_site.drivers.memory import DriverMemory
from remote_site.kinematics.joints import JointMotion
from remote_site.safety.stopping import stopping
from tests.remote_site.remote_loop import arm

_, LIMITS = arm()
CLOCK = MonotonicClock()


def test_the_first_command_after_a_stop_began_is_where_the_stop_is_at_its_time():
    memory = DriverMemory.create(6)
    link = DriverLink(memory, LIMITS, CLOCK)
    now_ns, moving = CLOCK.now_ns(), np.full((8, 6), 0.3)
    raw = memory.report.read()
    memory.report.write(raw._replace(at_ns=now_ns, stop_count=1, onset_ns=now_ns - 20 * NS_PER_MS, motions=moving))
    link.read()
    zero = np.zeros(6)
    command = JointCommand(1, now_ns, zero, zero, zero, GripperCommand.KEEP)
    stop = stopping(JointMotion(*moving[2:5]), LIMITS, 0.02)
    sent = link.write(command).motion
    assert (sent.q == stop.q).all()
    assert (sent.dq == stop.dq).all()
    assert link.write(command) is command
    first, second = memory.orders.take()
    assert (first.stop_count, second.stop_count) == (1, 1)
    assert (first.command.q == stop.q).all()


def test_until_an_activation_is_answered_control_goes_on_from_where_it_was_asked():
    """A robot that answers within a tick is never seen in between: what it was sent before is not where it is."""
    memory = DriverMemory.create(6)
    link = DriverLink(memory, LIMITS, CLOCK)
    memory.report.write(memory.report.read()._replace(at_ns=CLOCK.now_ns(), motions=np.full((8, 6), 0.3)))
    assert (link.read().sent.q == 0.3).all()
    link.activate(np.full(6, 0.2))
    report = link.read()
    assert not report.ready
    assert (report.sent.q == 0.2).all()
    assert report.sent.resting


def test_an_activation_and_a_stop_keep_the_gripper_whatever_was_commanded_before():
    memory = DriverMemory.create(6)
    link, zero = DriverLink(memory, LIMITS, CLOCK), np.zeros(6)
    for command in GripperCommand:
        link.write(JointCommand(1, 0, zero, zero, zero, command))
        link.stop()
        link.activate(zero)
        keep = GripperCommand.KEEP
        assert [order.command.gripper for order in memory.orders.take()] == [command, keep, keep]


def test_every_order_arrives_once_and_lost_ones_are_never_torn():
    memory = DriverMemory.create(6)
    link = DriverLink(memory, LIMITS, CLOCK)
    zero = np.zeros(6)
    for seq in range(1, 201):
        link.write(JointCommand(seq, 7 * NS_PER_MS, zero + seq, zero, zero, GripperCommand.CLOSED))
        if seq == 10:
            assert [order.command.seq for order in memory.orders.take()] == list(range(1, 11))
    late = memory.orders.take()
    assert [order.command.seq for order in late] == list(range(201 - len(late), 201))
    assert len(late) == 63
    assert all((order.command.q == order.command.seq).all() for order in late)
    assert memory.orders.take() == []
