"""What is written to the robot: every command as it is, numbered, at the robot's rate, within its jerk."""

from dataclasses import replace

import numpy as np
import pytest

from common.clock import NS_PER_MS, NS_PER_S
from remote_site.drivers.supervisor.state import SupervisorState
from remote_site.drivers.supervisor.write_scheduler import LEAST_FRACTION, WriteScheduler
from remote_site.drivers.supervisor.writer import ObeyedCommands
from remote_site.kinematics.joints import JointMotion
from remote_site.motion.jerk_limited import JerkLimitedTracker
from tests.remote_site.drivers.supervisor.supervised import DT, LIMITS, START, Supervised, assert_smooth


def test_commands_reach_the_robot_as_they_are(rig: Supervised) -> None:
    rig.moving()
    assert rig.robot.written[-1].q is rig.sent.q
    assert rig.supervisor.state is SupervisorState.FOLLOWING
    assert rig.supervisor.obeyed.seq == rig.seq
    assert_smooth(rig.robot)


def test_every_command_to_the_robot_has_a_number_of_its_own_also_in_the_stop(rig: Supervised) -> None:
    rig.moving()
    rig.turns(100)
    assert (np.diff([c.seq for c in rig.robot.written]) == 1).all()
    assert rig.supervisor.obeyed.seq == rig.seq


@pytest.mark.parametrize("late_ms", [0.02, 0.5, 1.9])
def test_an_arm_kept_at_rest_starts_no_sooner_than_its_jerk_allows(rig: Supervised, late_ms: float) -> None:
    rig.activate()
    for _ in range(10):
        rig.command(JointMotion.at_rest(START))
    rig.stumble(30.0)
    rig.sent = rig.plan()
    rig.turn(rig.order(rig.sent), ms=late_ms)
    for _ in range(20):
        rig.command()
        while (due_ns := rig.supervisor.due_ns) is not None and due_ns - rig.clock.now_ns() < 4 * NS_PER_MS:
            rig.turn(ms=(due_ns - rig.clock.now_ns()) / NS_PER_MS)
    t_ns, ddq = (np.array([getattr(c, key) for c in rig.robot.written]) for key in ("t_ns", "ddq"))
    jerk = np.abs(np.diff(ddq, axis=0)) / np.diff(t_ns)[:, None] * NS_PER_S
    assert len(t_ns) > 25
    assert (jerk <= LIMITS.jerk * 1.001 / LEAST_FRACTION).all()


@pytest.mark.parametrize("rate_hz", [10.0, 15.0, 20.0])
def test_a_slow_robot_gets_setpoints_along_the_path_at_its_rate_and_none_beyond_the_goal(rate_hz: float) -> None:
    rig = Supervised(rate_hz)
    rig.activate()
    rig.commands(500)
    written = rig.robot.written
    assert np.diff([c.t_ns for c in written]) == pytest.approx(1e9 / rate_hz, abs=4e6)
    places = np.array([c.q[0] for c in written])
    assert (np.diff(places) >= 0).all()
    assert places[-1] == pytest.approx(START[0] + 0.8, abs=1e-6)
    assert places.max() <= START[0] + 0.8 + 1e-6


@pytest.mark.parametrize("rate_hz", [30.0, 40.0, 50.0, 60.0, 80.0, 100.0, 125.0, 200.0])
def test_a_robot_whose_period_is_no_whole_number_of_ticks_does_not_fall_behind(rate_hz: float) -> None:
    rig, behind = Supervised(rate_hz).activate(), []
    for _ in range(200):
        rig.turn()  # its process turns more often than control orders
        rig.sent = rig.plan()
        rig.turn(rig.order(rig.sent))
        behind.append(rig.motion.q[0] - rig.supervisor.written.q[0])
    assert rig.supervisor.written.q[0] == pytest.approx(START[0] + 0.8, abs=1e-6)
    assert max(behind) <= LIMITS.velocity[0] * (1 / rate_hz + DT)
    t_ns, q = (np.array([getattr(c, key) for c in rig.robot.written]) for key in ("t_ns", "q"))
    steps_s = np.diff(t_ns)[:, None] / NS_PER_S
    assert (np.abs(np.diff(q, axis=0)) <= LIMITS.velocity * steps_s / LEAST_FRACTION * 1.001).all()


def test_before_the_first_command_the_robot_obeys_none_of_controls() -> None:
    rig = Supervised(15.0).activate()
    rig.stumble(200)
    assert rig.robot.written
    assert not rig.supervisor.obeyed.seq


def test_a_plan_that_begins_anew_forgets_what_waits() -> None:
    scheduler = WriteScheduler[str]()
    scheduler.restart(0, 0)
    scheduler.add(4 * NS_PER_MS, "of the former plan")
    scheduler.restart(NS_PER_MS, NS_PER_MS)
    assert scheduler.due_ns is None
    assert scheduler.take(NS_PER_S) is None


@pytest.mark.parametrize("extra_ms", [0, 5])
def test_what_follows_a_part_of_the_stop_takes_the_time_that_is_left_to_it(extra_ms: int) -> None:
    """The stop goes as far as 3 ms allow, and waits where it is already further than it may be."""
    scheduler = WriteScheduler[str]()
    scheduler.restart(0, 0)
    scheduler.delay(extra_ms * NS_PER_MS)
    reached_ns = scheduler.reach(8 * NS_PER_MS, 3 * NS_PER_MS)
    scheduler.add(16 * NS_PER_MS, "next")
    may_reach_ns = 3 * NS_PER_MS / LEAST_FRACTION - extra_ms * NS_PER_MS
    assert reached_ns == pytest.approx(max(may_reach_ns, 0), abs=2)
    assert scheduler.due_ns == pytest.approx(3e6 + LEAST_FRACTION * (16e6 - may_reach_ns), abs=2)


@pytest.mark.parametrize("rate_hz", [30.0, 100.0])
def test_a_robot_that_holds_goes_no_faster_after_a_pause_than_before(rate_hz: float) -> None:
    """Control orders on while the driver's process pauses: the robot would have waited where it was sent."""
    rig = Supervised(rate_hz, holds=True)
    rig.tracker = JerkLimitedTracker(LIMITS.scaled_speed(0.25), DT)
    rig.activate().commands(100)
    orders = []
    for _ in range(11):
        rig.sent = rig.plan()
        rig.clock.advance_ms(DT * 1e3)
        orders.append(rig.order(rig.sent))
    paused = len(rig.robot.written)
    rig.turn(*orders, ms=0)
    rig.command(rig.stop_at(4))
    rig.commands(400)
    q = np.array([c.q[0] for c in rig.robot.written])
    steps = np.diff(q)
    assert rig.supervisor.fault is None
    assert steps[paused - 1 :].max() <= steps[: paused - 1].max() / LEAST_FRACTION * 1.01
    assert q[-1] == pytest.approx(START[0] + 0.8, abs=1e-6)


def test_what_the_robot_obeys_never_goes_back() -> None:
    obeyed = ObeyedCommands()
    first, second = obeyed.number(11), obeyed.number(12)
    obeyed.confirm(second)
    obeyed.confirm(first)  # as of a reading that was overtaken
    assert obeyed.seq == 12


def test_an_arm_that_takes_no_commands_is_commanded_to_where_it_is_read(rig: Supervised) -> None:
    """So its next plan begins there, however it was moved meanwhile."""
    rig.robot.spoil = lambda reading: replace(reading, q=reading.q + 0.001)
    rig.turn()
    assert rig.motion.q == pytest.approx(START + 0.001)
    assert rig.motion.resting
