"""The command watchdog and the verified stop: after three missed ticks, after the time-out, and on order."""

from dataclasses import replace

import numpy as np
import pytest

from common.clock import NS_PER_MS
from remote_site.drivers.faults import STOPPED, FaultCode, RobotFault
from remote_site.drivers.supervisor.state import SupervisorState
from remote_site.drivers.supervisor.stop_plan import StopPlan
from remote_site.kinematics.joints import JointMotion
from remote_site.safety.stopping import stopping
from tests.remote_site.drivers.supervisor.supervised import LIMITS, SETUP, START, Supervised, assert_smooth


def test_silence_begins_the_verified_stop_after_three_ticks_and_latches_at_the_time_out(rig: Supervised) -> None:
    rig.moving()
    sent = rig.motion
    rig.turn(ms=12)
    assert rig.robot.written[-1].q is sent.q
    rig.turn(ms=1)
    assert rig.stop_count == 1
    assert rig.robot.written[-1].q == pytest.approx(stopping(sent, LIMITS, 0.013).q, abs=1e-12)
    assert rig.supervisor.fault is None
    rig.turns(200)
    assert rig.fault().code is FaultCode.COMMAND_TIMEOUT
    assert rig.supervisor.settled
    assert rig.motion.q == pytest.approx(stopping(sent, LIMITS, 9.9).q, abs=1e-9)
    assert_smooth(rig.robot)


def test_an_order_to_stop_stops_and_later_commands_are_ignored(rig: Supervised) -> None:
    rig.moving()
    rig.turn(rig.order(rig.sent, run=False))
    for _ in range(200):
        rig.command(rig.motion)
    assert rig.supervisor.fault is STOPPED
    assert rig.supervisor.settled
    assert rig.robot.stops == 1
    assert_smooth(rig.robot)


def test_a_pause_of_the_drivers_process_itself_is_no_silence_of_control(rig: Supervised) -> None:
    rig.moving()
    rig.stumble(13.0)
    rig.turn(ms=60)
    assert rig.supervisor.fault is None
    rig.sent = rig.stop_at()
    rig.turn(rig.order(rig.sent), ms=0)
    rig.commands(50)
    assert rig.supervisor.state is SupervisorState.FOLLOWING
    assert rig.stop_count == 1


def test_a_late_command_begins_no_stop_of_an_arm_at_rest(rig: Supervised) -> None:
    rig.activate()
    rig.command(rig.sent)
    rig.turn(ms=30)
    assert rig.stop_count == 0
    assert rig.supervisor.state is SupervisorState.FOLLOWING


def test_a_robot_at_rest_gets_its_motion_again_while_control_is_silent(rig: Supervised) -> None:
    rig.activate()
    rig.command(JointMotion.at_rest(START))
    written = len(rig.robot.written)
    rig.stumble(48.0)
    assert rig.supervisor.fault is None
    assert len(rig.robot.written) > written + 10
    assert all((command.q == START).all() for command in rig.robot.written)


def test_a_slow_robot_is_led_to_rest_before_it_is_held() -> None:
    rig = Supervised(15.0)
    rig.moving()
    sent = rig.motion
    rig.turns(400)
    assert rig.supervisor.settled
    assert rig.robot.written[-1].q == pytest.approx(stopping(sent, LIMITS, 9.9).q, abs=1e-9)


def test_an_arm_that_has_hardly_begun_is_led_to_rest_before_it_is_held(rig: Supervised) -> None:
    rig.activate().command(JointMotion.at_rest(START))
    rig.sent = rig.plan()
    rig.turn(rig.order(rig.sent), rig.order(rig.sent, run=False), ms=1.0)
    rig.turns(50)
    assert rig.supervisor.settled
    assert rig.robot.written[-1].q == pytest.approx(stopping(rig.sent, LIMITS, 9.9).q, abs=1e-12)
    assert rig.robot.written[-1].q[0] > START[0]


def test_control_may_be_silent_for_exactly_as_long_as_the_time_out(rig: Supervised) -> None:
    rig.activate()
    rig.command(rig.sent)
    rig.stumble(SETUP.command_timeout_ns / NS_PER_MS)
    assert rig.supervisor.fault is None
    rig.turn(ms=0.001)
    assert rig.fault().code is FaultCode.COMMAND_TIMEOUT
    assert rig.fault().sentence.startswith("no command for 50 ms (limit 50 ms)")


def test_a_pause_of_the_drivers_process_of_less_than_half_the_time_out_is_silence_of_control(rig: Supervised) -> None:
    rig.activate()
    rig.command(rig.sent)
    rig.turn(ms=24)
    rig.stumble(26.0)
    assert rig.supervisor.fault is None
    rig.turn(ms=0.001)
    assert rig.fault().code is FaultCode.COMMAND_TIMEOUT


def test_a_robot_that_is_active_or_moves_has_not_settled(rig: Supervised) -> None:
    rig.turn()
    assert rig.supervisor.settled
    rig.activate().command(rig.sent)
    assert not rig.supervisor.settled
    rig.robot.trouble = RobotFault(FaultCode.ROBOT, "it brakes by itself")
    rig.robot.spoil = lambda reading: replace(reading, dq=reading.dq + 0.1)
    rig.turn()
    assert rig.supervisor.state is SupervisorState.IDLE
    assert not rig.supervisor.settled
    rig.robot.spoil = lambda reading: reading
    rig.turn()
    assert rig.supervisor.settled


def test_before_its_onset_a_stop_is_the_motion_that_it_begins_from() -> None:
    motion = JointMotion(START, np.full(6, 1.0), np.full(6, 2.0))
    stop = StopPlan(1_000 * NS_PER_MS, 0, motion, LIMITS)
    for ms in (990, 1_000):
        assert stop.at(ms * NS_PER_MS).q == pytest.approx(motion.q, abs=1e-12)
    assert stop.at(1_004 * NS_PER_MS).q == pytest.approx(stopping(motion, LIMITS, 0.004).q, abs=1e-12)
