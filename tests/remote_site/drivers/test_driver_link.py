"""Control's side of the memory that it shares with the driver's process."""

import numpy as np
import pytest

from common.clock import NS_PER_MS, FakeClock
from common.host_clock import MonotonicClock
from common.messages.robot import GripperCommand
from remote_site.drivers.driver import JointCommand
from remote_site.drivers.faults import FaultCode
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


class Listening:
    """Control that reads the reports of a driver's process, which may cease or stand still."""

    def __init__(self):
        self._memory, self.clock = DriverMemory.create(6), FakeClock(10_000 * NS_PER_MS)
        self.link = DriverLink(self._memory, LIMITS, self.clock)
        self._reported_ns = 0

    def read(self, after_ms, *, reports=True, measures=True):
        """The fault's code, or None, after so many ms in which the driver's process reported, or did not."""
        self.clock.advance_ms(after_ms)
        now_ns, raw = self.clock.now_ns(), self._memory.report.read()
        if reports:
            t_ns = now_ns - NS_PER_MS if measures else raw.t_ns
            report = raw._replace(at_ns=now_ns, t_ns=t_ns, oldest_ns=100 * NS_PER_MS, code=b"")
            self._memory.report.write(report)
        fault = self.link.read().fault
        return None if fault is None else fault.code


@pytest.mark.parametrize("tick_ms", [51, 60, 90, 200])
def test_control_that_is_always_late_notices_a_dead_process_of_the_driver(tick_ms):
    control = Listening()
    assert [control.read(tick_ms) for _ in range(50)] == [None] * 50
    codes = [control.read(tick_ms, reports=False) for _ in range(4)]
    assert codes[-1] is FaultCode.PROCESS


@pytest.mark.parametrize("tick_ms", [51, 60, 90, 200])
def test_control_that_is_always_late_notices_a_reading_that_stands_still(tick_ms):
    control = Listening()
    assert [control.read(tick_ms) for _ in range(50)] == [None] * 50
    codes = [control.read(tick_ms, measures=False) for _ in range(5)]
    assert codes[-1] is FaultCode.SILENT


def test_a_pause_of_control_blames_nobody():
    control = Listening()
    assert [control.read(4) for _ in range(200)] == [None] * 200
    assert control.read(1000, reports=False) is None
    assert [control.read(4, reports=False) for _ in range(20)] == [None] * 20
    assert control.read(4) is None
