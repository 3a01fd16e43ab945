"""Control and the driver's process on stepped time: whichever stumbles, the arm stays inside its limits."""

from collections.abc import Callable

import numpy as np
import pytest

from common.clock import NS_PER_MS, FakeClock
from lab.stage.stepped.driver_process import SteppedDriverProcess
from remote_site.config import RemoteConfig
from remote_site.drivers.driver import Capabilities
from remote_site.drivers.kinematic import KinematicDriver
from remote_site.drivers.supervisor.write_scheduler import LEAST_FRACTION
from remote_site.runtime.rate import Rate
from tests.remote_site.drivers.leading_control import RATE_HZ, LeadingControl
from tests.remote_site.remote_loop import arm

_, LIMITS = arm()
START = RemoteConfig().robot.start
GOAL = START + np.array([2.0, -0.5, 0.4, 0.0, 0.0, 0.0])


class Kept(KinematicDriver):
    """Keeps what it was sent."""

    def __init__(self, clock):
        super().__init__(clock)
        self.written = []

    def write(self, command):
        self.written.append(command)
        return super().write(command)


class Slow(Kept):
    """Takes 15 setpoints a second, and moves from each to the next along a straight line."""

    @property
    def capabilities(self):
        return Capabilities(15.0, None, gripper=False, force=False, watchdog_ms=None, queued_periods=2, holds=True)


class Rig:
    """A tick of control every 4 ms towards the goal, a turn of the driver's process every 2 ms and at every order."""

    def __init__(self, phase_ms, make=Kept):
        self.clock = FakeClock(1000 * NS_PER_MS)
        self.robot, self.phase_ms = make(self.clock), phase_ms
        self.process = SteppedDriverProcess(RemoteConfig(), self.robot, self.clock)
        self.supervisor = self.process.supervisor
        self.control = LeadingControl(self.process.link, LIMITS, self.clock, START)
        self.process.link.activate(START)
        self.process.turn()
        self.rate = Rate(RATE_HZ, self.clock, least_fraction=LEAST_FRACTION)

    def tick(self, late_ms=0.0):
        wake_ns = self.rate.next_ns + round(late_ms * NS_PER_MS)
        turn_ns = self.clock.now_ns() + round(self.phase_ms * NS_PER_MS)
        while turn_ns < wake_ns:
            self.clock.sleep_until_ns(turn_ns)
            self.process.turn()
            turn_ns += 2 * NS_PER_MS
        self.clock.sleep_until_ns(wake_ns)
        self.rate.wait()
        assert self.control.order(GOAL).ready
        self.process.turn()

    def written(self):
        t = np.array([c.t_ns for c in self.robot.written]) / 1e9
        return (t, *(np.array([getattr(c, key) for c in self.robot.written]) for key in ("q", "dq", "ddq")))


@pytest.mark.slow
@pytest.mark.parametrize("phase_ms", [0.3, 1.0, 1.9])
@pytest.mark.parametrize("late_ms", [3.9, 9.0, 15.5, 26.2, 55.0, 90.0])
def test_a_stumble_slows_the_arm_and_costs_no_full_stop(late_ms, phase_ms):
    rig = Rig(phase_ms)
    for _ in range(60):
        rig.tick()
    rig.tick(late_ms)
    at_waking, woke_ns = rig.control.sent, rig.clock.now_ns()
    for _ in range(400):
        rig.tick()
    assert rig.supervisor.commanded.stop_count == (1 if late_ms > 8 else 0)  # 4 ms more since the last command
    assert rig.supervisor.fault is None
    assert rig.supervisor.commanded.motion.q == pytest.approx(GOAL, abs=1e-6)
    t, q, dq, ddq = rig.written()
    speeds = dq[t >= woke_ns / 1e9, 0]
    fastest = int(speeds.argmax())
    assert speeds[fastest] > at_waking.dq[0] > 1.0
    assert speeds[: fastest + 1].min() > at_waking.dq[0] - 0.1  # what it takes to take a braking of 10 rad/s² back
    steps = np.diff(t)[:, None]
    assert (np.abs(dq) <= LIMITS.velocity * 1.0001).all()
    assert (np.abs(ddq) <= LIMITS.acceleration * 1.0001).all()
    assert (np.abs(np.diff(ddq, axis=0)) <= LIMITS.jerk * steps * 1.001 / LEAST_FRACTION + 1e-9).all()
    assert (np.abs(np.diff(q, axis=0)) <= LIMITS.velocity * steps * 1.0001 / LEAST_FRACTION).all()
    assert np.diff(q[:, 0]).min() >= -1e-8  # rounding at the goal


@pytest.mark.slow
@pytest.mark.parametrize("ticks", [60, 73, 90, 101])
@pytest.mark.parametrize("late_ms", [26.2, 55.0, 90.0, 200.0, 333.0])
def test_a_slow_robot_goes_through_a_stumble_at_its_speeds_too(late_ms, ticks):
    rig = Rig(1.0, Slow)
    for _ in range(ticks):
        rig.tick()
    rig.tick(late_ms)
    for _ in range(400):
        rig.tick()
    assert rig.supervisor.fault is None
    assert rig.supervisor.commanded.motion.q == pytest.approx(GOAL, abs=1e-6)
    t, q, _, _ = rig.written()
    steps = np.diff(t)[:, None]
    speed = np.diff(q, axis=0) / steps
    acceleration = np.diff(speed, axis=0) / steps[1:]
    in_ticks = 1 + 4 / 67  # a setpoint is a whole tick's
    assert (np.abs(speed) <= LIMITS.velocity * in_ticks).all()
    assert (np.abs(np.diff(q, axis=0)) <= LIMITS.velocity / 15.0 * 1.0001).all()
    assert (np.abs(acceleration) <= LIMITS.acceleration * 1.5).all()  # what a tick more or less makes of full speed
    assert np.diff(q[:, 0]).min() >= -1e-8


def test_stumbles_one_after_the_other_never_end_in_a_fault():
    rig, rng = Rig(1.2), np.random.default_rng(3)
    for late_ms in rng.uniform(0, 60, 40):
        rig.tick(late_ms)
        rig.tick()
    for _ in range(400):
        rig.tick()
    assert rig.supervisor.fault is None
    assert rig.supervisor.commanded.stop_count > 10
    assert rig.supervisor.commanded.motion.q == pytest.approx(GOAL, abs=1e-6)


class LateRobot(Kept):
    """Keeps one call waiting, while time passes for the others; notes when each write came."""

    def __init__(self, clock):
        super().__init__(clock)
        self.came_ns, self.late_ms = list[int](), dict[str, float]()
        self.pass_time: Callable[[int], object] = clock.sleep_until_ns

    def read(self):
        self._be_late("read")
        return super().read()

    def write(self, command):
        self.came_ns.append(self._clock.now_ns())
        self._be_late("write")
        return super().write(command)

    def _be_late(self, call):
        late_ms = self.late_ms.pop(call, 0.0)
        if late_ms:
            self.pass_time(self._clock.now_ns() + round(late_ms * NS_PER_MS))


class LateRig(Rig):
    """Control on its own time, whatever the driver's process does; that turns when it wakes."""

    def __init__(self):
        super().__init__(0.0, LateRobot)
        self.robot.pass_time, self.rang = self.control_until, False

    def control_until(self, until_ns):
        while self.rate.next_ns <= until_ns:
            self.rate.wait()
            assert self.control.order(GOAL).ready
            self.rang = True
        self.clock.sleep_until_ns(until_ns)

    def run(self, ms):
        end_ns = self.clock.now_ns() + round(ms * NS_PER_MS)
        while self.clock.now_ns() < end_ns:
            wake_ns = min(self.clock.now_ns() + 2 * NS_PER_MS, self.supervisor.due_ns or end_ns, self.rate.next_ns)
            if not self.rang:
                self.control_until(max(wake_ns, self.clock.now_ns()))
            self.rang = False
            self.process.turn()

    def by_the_clock(self):
        """Speed, acceleration and jerk of what was written, by when it came, as fractions of the limits."""
        q, dq, ddq = (np.array([getattr(c, key) for c in self.robot.written]) for key in ("q", "dq", "ddq"))
        steps = np.diff(self.robot.came_ns)[:, None] / 1e9
        speed, acceleration, jerk = (np.abs(np.diff(x, axis=0) / steps).max(axis=0) for x in (q, dq, ddq))
        return max(speed / LIMITS.velocity), max(acceleration / LIMITS.acceleration), max(jerk / LIMITS.jerk)


@pytest.mark.slow
@pytest.mark.parametrize("late_ms", [3.7, 5.0, 7.9, 11.9, 16.1, 27.5, 48.0])
@pytest.mark.parametrize(("call", "begin_ms"), [("read", 60.0), ("read", 240.6), ("write", 60.0), ("write", 151.3)])
def test_after_a_late_driver_the_robot_sees_no_more_than_the_limits_by_the_clock(late_ms, call, begin_ms):
    rig = LateRig()
    rig.run(begin_ms)
    rig.robot.late_ms[call] = late_ms
    rig.run(1500.0)
    assert not rig.robot.late_ms
    assert rig.supervisor.fault is None
    assert rig.supervisor.commanded.motion.q == pytest.approx(GOAL, abs=1e-6)
    assert max(rig.by_the_clock()) <= 1.12


def test_without_late_calls_nothing_waits_and_a_delay_is_made_up():
    rig = LateRig()
    rig.run(100.0)
    orders, came = rig.control.seq, len(rig.robot.came_ns)
    rig.run(100.0)
    assert len(rig.robot.came_ns) - came == rig.control.seq - orders
    assert rig.robot.came_ns[-1] == rig.rate.next_ns - 4 * NS_PER_MS  # immediately
    rig.robot.late_ms["read"] = 7.9
    rig.run(20.0)
    assert rig.supervisor.due_ns is not None or np.diff(rig.robot.came_ns).min() >= LEAST_FRACTION * 4 * NS_PER_MS
    rig.run(100.0)
    assert rig.supervisor.due_ns is None
    assert rig.robot.came_ns[-1] == rig.rate.next_ns - 4 * NS_PER_MS
