"""Readings and setpoints: in order, none left out, none queued twice, and a path without detours."""

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from common.clock import NS_PER_MS
from common.errors import DriverError
from common.messages.robot import GripperCommand
from remote_site.drivers.c500c.emulator import Emulated
from remote_site.drivers.c500c.playing import Player
from remote_site.drivers.faults import FaultCode
from tests.present import present
from tests.remote_site.drivers.c500c.emulated_a465 import ROBOT, SETUP, EmulatedA465


def test_the_controller_is_read_before_it_is_activated_and_not_invented(bench):
    bench.driver.configure(SETUP)
    with pytest.raises(DriverError, match="does not answer"):
        bench.driver.read()
    with pytest.raises(DriverError, match="does not answer"):
        bench.driver.activate(ROBOT.start)
    reading = bench.run(100)
    assert reading.q == pytest.approx(ROBOT.start, abs=1e-6)
    assert reading.fault.code is FaultCode.NOT_ACTIVATED
    assert reading.gripper.force_n is None
    age_ms = (bench.clock.now_ns() - reading.t_ns) / NS_PER_MS
    assert 5 < age_ms < 60


def test_state_comes_some_thirty_times_a_second(bench):
    bench.ready()
    times = set()
    for _ in range(500):
        times.add(bench.run(2).t_ns)
    assert 20 <= len(times) <= 45


def test_setpoints_are_reached_in_order_and_named(bench):
    bench.ready()
    goal = ROBOT.start + 0.02
    reading = bench.send(goal, periods=6)
    assert reading.q == pytest.approx(goal, abs=2e-6)
    assert bench.seq - 4 <= reading.obeyed_seq <= bench.seq


@pytest.mark.parametrize("loss", [0.0, 0.0005, 0.001])
def test_lost_bytes_are_made_good_and_no_setpoint_is_queued_twice(loss):
    bench = EmulatedA465(loss=loss).ready()
    for k in range(90):
        reading = bench.send(ROBOT.start + 0.004 * k)
        assert reading.fault is None, k
    bench.send(ROBOT.start + 0.004 * 89, periods=5)
    assert bench.run(100).q == pytest.approx(ROBOT.start + 0.004 * 89, abs=2e-6)
    assert bench.longest <= 2
    assert (bench.driver._exchange.repeats > 3) is (loss > 0)


@pytest.mark.parametrize("drift", [0.99, 1.01])
def test_clocks_that_differ_lose_no_setpoint(drift):
    bench = EmulatedA465().ready()
    bench.controller.player.period = 0.067 * drift
    begun = []
    for k in range(200):
        reading = bench.send(ROBOT.start + 0.002 * k)
        assert reading.fault is None
        begun.append(bench.controller.player.begun)
    assert set(np.diff(begun[5:])) <= {0, 1, 2}
    assert len({*begun}) > 180


def test_keep_sends_nothing_to_the_gripper_and_the_controller_itself_ends_too_strong_a_grip():
    bench = EmulatedA465(emulated=Emulated(object_m=0.03), grip_percent=90, hold_percent=60, strong_grip_s=15.0).ready()
    bench.send(ROBOT.start, periods=15, gripper=GripperCommand.CLOSED)
    gripper = bench.controller.gripper
    reading = bench.send(ROBOT.start, periods=100, gripper=GripperCommand.KEEP)
    assert (gripper.aim_open, gripper.percent) == (False, 90)
    bench.driver.stop()
    bench.run(100)
    bench.driver.activate(ROBOT.start)
    bench.run(60)
    reading = bench.send(ROBOT.start, periods=150, gripper=GripperCommand.KEEP)
    assert (gripper.aim_open, gripper.percent) == (False, 75)
    assert present(reading.gripper).opening_m == pytest.approx(0.03, abs=1e-4)


def test_the_gripper_closes_on_the_object_at_its_percentage():
    bench = EmulatedA465(emulated=Emulated(object_m=0.03), grip_percent=90, hold_percent=60, strong_grip_s=0.3).ready()
    reading = bench.send(ROBOT.start, periods=3, gripper=GripperCommand.CLOSED)
    assert bench.controller.gripper.percent == 90
    reading = bench.send(ROBOT.start, periods=12, gripper=GripperCommand.CLOSED)
    assert present(reading.gripper).opening_m == pytest.approx(0.03, abs=1e-4)
    assert bench.controller.gripper.percent == 60
    reading = bench.send(ROBOT.start, periods=12)
    assert present(reading.gripper).opening_m == pytest.approx(0.0508, abs=1e-4)


@given(st.lists(st.floats(-0.2, 0.2), min_size=3, max_size=15))
def test_the_way_between_setpoints_turns_nowhere_else(steps):
    player, places = Player(np.zeros(1), 0.1), np.cumsum([0.0, *steps])
    waiting, seen = list(enumerate(places[1:], start=1)), []
    for _ in range(len(steps) * 20 + 60):
        while waiting and player.add(waiting[0][0], np.array([waiting[0][1]])):
            waiting.pop(0)
        if not waiting and len(player.queue) < 2:
            player.add(99, np.array([places[-1]]))
        assert player.tick(0.005)
        seen.append(player.q[0])
    assert max(seen) <= places.max() + 1e-9
    assert min(seen) >= places.min() - 1e-9
    assert seen[-1] == pytest.approx(places[-1])
