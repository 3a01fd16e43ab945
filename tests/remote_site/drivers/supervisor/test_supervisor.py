"""The keeper judges every command, stops when they cease, and keeps every fault until the next activation."""

from dataclasses import replace

import numpy as np
import pytest

from common.clock import NS_PER_MS, NS_PER_S, FakeClock
from common.errors import DriverError
from common.messages.robot import GripperStatus
from remote_site.drivers.driver import Capabilities, DriverSetup, GripperReading, JointCommand
from remote_site.drivers.faults import STOPPED, FaultCode, RobotFault
from remote_site.drivers.kinematic import KinematicDriver
from remote_site.drivers.supervisor.grip import GripSettings, GripWatch
from remote_site.drivers.supervisor.supervisor import DriverOrder, DriverSupervisor, Phase
from remote_site.drivers.supervisor.write_scheduler import LEAST_SHARE
from remote_site.kinematics.joints import JointMotion
from remote_site.motion.jerk_limited import JerkLimitedTracker
from remote_site.safety.stopping import stop_time, stopping
from tests.remote_site.remote_loop import arm

MODEL, LIMITS = arm()
DT = 0.004
START = np.radians([0.0, 0.0, -45.0, 0.0, -45.0, 0.0])
SETUP = DriverSetup(MODEL.joint_names, LIMITS, DT, 50 * NS_PER_MS)


class Robot(KinematicDriver):
    """A kinematic robot that can be given faults, and that keeps what was written."""

    def __init__(self, clock):
        super().__init__(clock)
        self.written, self.trouble, self.opening_m, self.rate_hz, self.stops = [], None, None, 1000.0, 0
        self.raises, self.slow_ms = None, 0

    @property
    def capabilities(self):
        return Capabilities(self.rate_hz, None, gripper=True, force=False, watchdog_ms=None, queued_periods=0)

    def read(self):
        self._clock.advance_ms(self.slow_ms)
        reading = super().read()
        gripper = GripperReading(self.opening_m, None) if self.opening_m is not None else None
        return replace(reading, gripper=gripper, fault=self.trouble or reading.fault)

    def write(self, command):
        if self.raises:
            raise self.raises
        self.written.append(command)
        return super().write(command)

    def stop(self):
        self.stops += 1
        super().stop()


class Mark:
    def __init__(self):
        self.seen = []

    def set(self, since_ns):
        self.seen.append(since_ns)


class Bench:
    """A keeper around the robot, and control that plans towards a goal."""

    def __init__(self, rate_hz=1000.0):
        self.clock = FakeClock(1_000 * NS_PER_MS)
        self.robot = Robot(self.clock)
        self.robot.rate_hz = rate_hz
        self.mark = Mark()
        self.robot.configure(SETUP)
        self.keeper = DriverSupervisor(self.robot, SETUP, self.clock, self.mark, GripWatch(GripSettings()))
        self.follower = JerkLimitedTracker(LIMITS, DT)
        self.activation = self.seq = 0
        self.sent = JointMotion.at_rest(START)

    def turn(self, *orders, ms=2.0):
        self.clock.advance_ms(ms)
        self.keeper.take(orders, self.clock.now_ns())
        self.keeper.step(self.clock.now_ns())

    def activate(self, q=START):
        self.activation += 1
        self.sent = JointMotion.at_rest(q)
        self.turn(self.order(self.sent))
        return self

    def order(self, motion, *, run=True, gripper_open=True):
        self.seq += 1
        now_ns = self.clock.now_ns()
        command = JointCommand(self.seq, now_ns, motion.q, motion.dq, motion.ddq, gripper_open)
        return DriverOrder(self.activation, run, self.keeper.diversions, command)

    def plan(self, ahead=0.8):
        self.follower.reset(self.sent)
        goal = START.copy()
        goal[0] += ahead
        return self.follower.track(goal, np.zeros(6))

    def command(self, motion=None, **changes):
        self.sent = motion or self.plan()
        self.clock.advance_ms(4)
        self.turn(self.order(self.sent, **changes), ms=0)

    def stop_at(self, ms=0.0):
        """Where the stop under way is so many ms from now, as control computes it from the report."""
        onset_ns, motion = self.keeper.course
        return stopping(motion, LIMITS, (self.clock.now_ns() - onset_ns) / 1e9 + ms / 1e3)

    def stumble(self, ms):
        """Control is silent for so long, the driver's process goes on."""
        while ms > 0:
            self.turn(ms=min(ms, 2.0))
            ms -= 2.0

    def moving(self, ticks=60):
        self.activate()
        for _ in range(ticks):
            self.command()
        assert self.keeper.motion.dq[0] > 1.0
        return self


@pytest.fixture
def bench():
    return Bench()


def assert_smooth(robot):
    """What was written is within the limits, by the times of the commands."""
    t = np.array([c.t_ns for c in robot.written]) / 1e9
    q, dq, ddq = (np.array([getattr(c, key) for c in robot.written]) for key in ("q", "dq", "ddq"))
    steps = np.diff(t)[:, None]
    assert (np.abs(dq) <= LIMITS.velocity * 1.0001).all()
    assert (np.abs(ddq) <= LIMITS.acceleration * 1.0001).all()
    assert (np.abs(np.diff(ddq, axis=0)) <= LIMITS.jerk * steps * 1.001 + 1e-9).all()
    assert (np.abs(np.diff(q, axis=0)) <= LIMITS.velocity * steps * 1.0001).all()


def test_commands_reach_the_robot_as_they_are(bench):
    bench.moving()
    assert bench.robot.written[-1].q is bench.sent.q
    assert bench.keeper.phase is Phase.ACTIVE
    assert bench.keeper.obeyed_seq == bench.seq
    assert_smooth(bench.robot)


@pytest.mark.parametrize("change", [0.01, 0.5, np.nan, np.inf])
def test_a_command_beyond_the_limits_never_reaches_the_robot_and_ends_in_the_stop(bench, change):
    bench.moving()
    at, sent = bench.keeper.motion.q[0], bench.keeper.motion
    bench.command(JointMotion(sent.q + change, sent.dq, sent.ddq))
    assert bench.keeper.fault.code is FaultCode.LIMITS
    for _ in range(200):
        bench.command(bench.keeper.motion)
    assert bench.keeper.settled
    assert_smooth(bench.robot)
    expected = stopping(sent, LIMITS, stop_time(sent, LIMITS)).q[0]
    assert bench.robot.read().q[0] == pytest.approx(expected, abs=1e-6)
    assert expected > at


def test_silence_begins_the_verified_stop_after_three_ticks_and_latches_at_the_time_out(bench):
    bench.moving()
    sent = bench.keeper.motion
    bench.turn(ms=12)
    assert bench.robot.written[-1].q is sent.q
    bench.turn(ms=1)
    assert bench.keeper.diversions == 1
    assert bench.robot.written[-1].q == pytest.approx(stopping(sent, LIMITS, 0.013).q, abs=1e-12)
    assert bench.keeper.fault is None
    for _ in range(200):
        bench.turn()
    assert bench.keeper.fault.code is FaultCode.COMMAND_TIMEOUT
    assert bench.keeper.settled
    assert bench.keeper.motion.q == pytest.approx(stopping(sent, LIMITS, 9.9).q, abs=1e-9)
    assert_smooth(bench.robot)


def test_every_command_to_the_robot_has_a_number_of_its_own_also_in_the_stop(bench):
    bench.moving()
    for _ in range(100):
        bench.turn()
    assert (np.diff([c.seq for c in bench.robot.written]) == 1).all()
    assert bench.keeper.obeyed_seq == bench.seq


@pytest.mark.parametrize("silent_ms", [13.0, 20.3, 33.9, 47.0])
def test_control_goes_on_from_within_the_stop_at_once(bench, silent_ms):
    bench.moving()
    bench.stumble(silent_ms)
    slowed = bench.stop_at().dq[0]
    bench.sent = bench.stop_at()
    bench.turn(bench.order(bench.sent), ms=0)
    for _ in range(200):
        bench.command()
    assert bench.keeper.phase is Phase.ACTIVE
    assert bench.keeper.diversions == 1
    speeds = np.array([c.dq[0] for c in bench.robot.written])
    since = next(k for k in range(len(speeds)) if speeds[k] == slowed)
    assert slowed > 0.5
    assert speeds[since:].max() > slowed  # it brakes no more
    assert bench.keeper.motion.q[0] == pytest.approx(START[0] + 0.8, abs=1e-6)
    assert np.diff([c.q[0] for c in bench.robot.written]).min() >= -1e-8  # rounding at the goal
    assert_smooth(bench.robot)


@pytest.mark.parametrize("ahead_ms", [0.2, 0.9])
def test_a_stop_sent_a_little_further_than_the_command_that_ends_it_is_not_taken_back(bench, ahead_ms):
    bench.moving()
    bench.stumble(20)
    bench.sent = bench.stop_at(-ahead_ms)
    written = len(bench.robot.written)
    order = bench.order(bench.sent)
    early_ns = round(ahead_ms * NS_PER_MS)
    bench.turn(replace(order, command=replace(order.command, t_ns=order.command.t_ns - early_ns)), ms=0)
    assert (bench.keeper.diversions, len(bench.robot.written)) == (1, written)
    assert bench.keeper.motion.q is bench.sent.q
    bench.clock.advance_ms(-ahead_ms)  # control's next tick comes a period after its last
    for _ in range(20):
        bench.sent = bench.plan()
        for ms in (2.0, 1.0, 0.5):
            bench.turn(ms=ms)
        bench.clock.advance_ms(0.5)
        bench.turn(bench.order(bench.sent), ms=0)
    assert np.diff([c.q[0] for c in bench.robot.written]).min() >= 0
    assert bench.keeper.phase is Phase.ACTIVE
    t, ddq = (np.array([getattr(c, key) for c in bench.robot.written]) for key in ("t_ns", "ddq"))
    jerk = np.diff(ddq, axis=0) / np.diff(t)[:, None] * NS_PER_S
    assert (np.abs(jerk) <= LIMITS.jerk / LEAST_SHARE * 1.001).all()


@pytest.mark.parametrize("behind_ms", [1.1, 4.0])
def test_a_stop_sent_much_further_goes_on(bench, behind_ms):
    bench.moving()
    bench.stumble(20)
    order = bench.order(bench.stop_at(-behind_ms))
    late_ns = round(behind_ms * NS_PER_MS)
    bench.turn(replace(order, command=replace(order.command, t_ns=order.command.t_ns - late_ns)), ms=0)
    assert bench.keeper.diversions == 2
    assert bench.keeper.course[0] > 0
    assert bench.keeper.fault is None


def test_a_command_planned_before_the_stop_began_does_not_count(bench):
    bench.moving()
    old = bench.order(bench.plan())
    bench.turn(ms=14)
    begun = bench.keeper.motion
    bench.turn(old)
    assert bench.keeper.fault is None
    assert bench.keeper.diversions == 1
    assert bench.keeper.motion.dq[0] < begun.dq[0]


def test_a_command_that_meets_a_stop_gone_on_is_planned_anew(bench):
    bench.moving()
    bench.turn(ms=14)
    bench.sent = bench.keeper.motion
    planned = bench.plan()
    bench.turn()
    bench.turn(bench.order(planned))
    assert bench.keeper.fault is None
    assert bench.keeper.diversions == 2


def test_control_that_is_always_behind_the_stop_is_taken_again_at_rest(bench):
    bench.moving()
    bench.stumble(14)
    slowest, began = np.inf, bench.keeper.motion.q[0]
    for _ in range(400):
        onset_ns, _ = bench.keeper.course
        bench.sent = bench.stop_at(-2.0) if onset_ns else bench.plan()
        bench.turn(ms=2)
        bench.turn(bench.order(bench.sent))
        slowest = min(slowest, abs(bench.keeper.motion.dq[0]))
    assert bench.keeper.fault is None
    assert slowest < 0.01
    assert began < START[0] + 0.7
    assert bench.keeper.motion.q[0] == pytest.approx(START[0] + 0.8, abs=1e-6)
    assert_smooth(bench.robot)


def test_a_backlog_is_not_caught_up(bench):
    bench.moving()
    backlog = []
    for _ in range(15):
        bench.sent = bench.plan()
        backlog.append(bench.order(bench.sent))
    written = len(bench.robot.written)
    bench.turn(*backlog, ms=60)
    assert bench.robot.written[written].dq[0] < backlog[0].command.dq[0]
    for _ in range(200):
        bench.turn()
    assert bench.keeper.settled
    assert_smooth(bench.robot)


def test_a_pause_of_the_drivers_process_itself_is_no_silence_of_control(bench):
    bench.moving()
    bench.stumble(13.0)
    bench.turn(ms=60)
    assert bench.keeper.fault is None
    bench.sent = bench.stop_at()
    bench.turn(bench.order(bench.sent), ms=0)
    for _ in range(50):
        bench.command()
    assert bench.keeper.phase is Phase.ACTIVE
    assert bench.keeper.diversions == 1


def test_a_robot_at_rest_is_told_so_while_control_is_silent(bench):
    bench.activate()
    bench.command(JointMotion.at_rest(START))
    written = len(bench.robot.written)
    bench.stumble(48.0)
    assert bench.keeper.fault is None
    assert len(bench.robot.written) > written + 10
    assert all((command.q == START).all() for command in bench.robot.written)


@pytest.mark.parametrize("late_ms", [0.02, 0.5, 1.9])
def test_an_arm_told_to_rest_again_starts_no_sooner_than_its_jerk_allows(bench, late_ms):
    bench.activate()
    for _ in range(10):
        bench.command(JointMotion.at_rest(START))
    bench.stumble(30.0)
    bench.sent = bench.plan()
    bench.turn(bench.order(bench.sent), ms=late_ms)
    for _ in range(20):
        bench.command()
        while bench.keeper.due_ns is not None and bench.keeper.due_ns - bench.clock.now_ns() < 4 * NS_PER_MS:
            bench.turn(ms=(bench.keeper.due_ns - bench.clock.now_ns()) / NS_PER_MS)
    t_ns, ddq = (np.array([getattr(c, key) for c in bench.robot.written]) for key in ("t_ns", "ddq"))
    jerk = np.abs(np.diff(ddq, axis=0)) / np.diff(t_ns)[:, None] * NS_PER_S
    assert len(t_ns) > 25
    assert (jerk <= LIMITS.jerk * 1.001 / LEAST_SHARE).all()


def test_an_order_to_stop_stops_and_a_command_after_it_does_not_count(bench):
    bench.moving()
    bench.turn(bench.order(bench.sent, run=False))
    for _ in range(200):
        bench.command(bench.keeper.motion)
    assert bench.keeper.fault is STOPPED
    assert bench.keeper.settled
    assert bench.robot.stops == 1
    assert_smooth(bench.robot)


def test_a_resting_arm_is_not_diverted_by_a_late_command(bench):
    bench.activate()
    bench.command(bench.sent)
    bench.turn(ms=30)
    assert bench.keeper.diversions == 0
    assert bench.keeper.phase is Phase.ACTIVE


def test_a_robot_that_refuses_to_be_activated_is_stopped_and_can_be_asked_again(bench, monkeypatch):
    def refuse(_q0):
        raise DriverError("not now")

    with monkeypatch.context() as patched:
        patched.setattr(bench.robot, "activate", refuse)
        bench.activate()
    assert bench.keeper.fault.code is FaultCode.REFUSED
    assert bench.robot.stops == 1
    bench.activate()
    bench.turn()
    assert bench.keeper.phase is Phase.ACTIVE


def test_activation_waits_for_rest(bench):
    bench.moving()
    bench.activate(bench.keeper.motion.q)
    assert bench.keeper.fault.code is FaultCode.REFUSED
    assert bench.robot.stops == 0  # it is led to rest
    for _ in range(200):
        bench.turn()
    assert bench.keeper.settled
    bench.activate(bench.keeper.motion.q)
    bench.turn()
    assert bench.keeper.phase is Phase.ACTIVE
    assert bench.keeper.fault is None


@pytest.mark.parametrize("code", [FaultCode.EMERGENCY_STOP, FaultCode.ARM_POWER, FaultCode.ROBOT])
def test_a_fault_of_the_robot_is_mirrored_and_stays_when_the_robot_has_forgotten_it(bench, code):
    bench.moving()
    bench.robot.trouble = RobotFault(code, "what the robot says", native="E42")
    bench.command()
    written = len(bench.robot.written)
    bench.robot.trouble = None
    for _ in range(100):
        bench.command()
    assert bench.keeper.fault == RobotFault(code, "what the robot says", native="E42")
    assert bench.robot.stops == 1
    assert len(bench.robot.written) == written
    bench.activate(bench.robot.read().q)
    bench.turn()
    assert bench.keeper.fault is None


def test_an_activation_while_the_fault_lasts_is_in_vain(bench):
    bench.moving()
    bench.robot.trouble = RobotFault(FaultCode.EMERGENCY_STOP, "pressed")
    for _ in range(100):
        bench.command()
    bench.activate(bench.robot.read().q)
    bench.turn()
    assert bench.keeper.fault.code is FaultCode.EMERGENCY_STOP
    assert bench.keeper.phase is Phase.IDLE


@pytest.mark.parametrize("error", [DriverError("line cut"), KeyError("oops"), ValueError("no")])
def test_a_driver_that_raises_is_stopped_and_named(bench, error):
    bench.moving()
    bench.robot.raises = error
    bench.command()
    assert bench.keeper.fault.code is FaultCode.DRIVER
    assert str(error) in bench.keeper.fault.sentence
    assert bench.robot.stops == 1


def test_a_call_beyond_the_deadline_is_a_fault_and_visible_while_it_lasts(bench):
    bench.moving()
    assert bench.mark.seen[-1] == 0
    assert max(bench.mark.seen) > 0
    bench.robot.slow_ms = 60
    bench.turn()
    assert bench.keeper.fault.code is FaultCode.DEADLINE
    assert "60 ms (limit 50 ms)" in bench.keeper.fault.sentence


def test_an_arm_that_is_elsewhere_is_not_activated(bench):
    bench.activate()
    robot_at = bench.robot.activate
    bench.keeper.stop(STOPPED)
    for _ in range(10):
        bench.turn()
    bench.robot.activate = lambda q0: robot_at(q0 + 0.2)
    bench.activate(START)
    assert bench.keeper.fault.code is FaultCode.APART


@pytest.mark.parametrize("rate_hz", [10.0, 15.0, 20.0])
def test_a_slow_robot_gets_every_setpoint_of_the_way_at_its_rate_and_none_beyond_the_goal(rate_hz):
    bench = Bench(rate_hz)
    bench.activate()
    for _ in range(500):
        bench.command()
    written = bench.robot.written
    assert np.diff([c.t_ns for c in written]) == pytest.approx(1e9 / rate_hz, abs=4e6)
    places = np.array([c.q[0] for c in written])
    assert (np.diff(places) >= 0).all()
    assert places[-1] == pytest.approx(START[0] + 0.8, abs=1e-6)
    assert places.max() <= START[0] + 0.8 + 1e-6


def test_a_slow_robot_is_led_to_rest_before_it_is_held():
    bench = Bench(15.0)
    bench.moving()
    sent = bench.keeper.motion
    for _ in range(400):
        bench.turn()
    assert bench.keeper.settled
    assert bench.robot.written[-1].q == pytest.approx(stopping(sent, LIMITS, 9.9).q, abs=1e-9)


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
def test_the_gripper_is_watched_until_it_is_stable(openings_m, wanted_open, status):
    watch = GripWatch(GripSettings())
    watch.judge(0, openings_m[0], wanted_open=not wanted_open)
    for k, opening_m in enumerate(openings_m, start=1):
        seen = watch.judge(k * 10 * NS_PER_MS, opening_m, wanted_open=wanted_open)
    assert seen is status


def test_the_gripper_is_reported_with_what_it_was_told(bench):
    bench.robot.opening_m = 0.05
    bench.activate()
    for _ in range(3):
        bench.command(bench.sent, gripper_open=False)
    gripper = bench.keeper.gripper
    assert (gripper.opening, gripper.force, gripper.commanded_open) == (0.05, None, False)
