"""However the driver's process pauses, a position arm is never sent further at once than it goes in a period."""

from dataclasses import dataclass, field

import numpy as np
import pytest

from common.clock import NS_PER_MS, NS_PER_S, FakeClock
from common.geometry import Array
from common.messages.robot import GripperCommand
from lab.stage.stepped.driver_process import SteppedDriverProcess
from remote_site.drivers.driver import JointCommand
from remote_site.drivers.position_arm.arm import PositionArm
from remote_site.drivers.position_arm.driver import PositionArmDriver
from remote_site.drivers.supervisor.write_scheduler import LEAST_FRACTION
from remote_site.runtime.rate import Rate
from tests.contracts.driver_stands import CONFIG, SETUP
from tests.remote_site.drivers.leading_control import RATE_HZ, LeadingControl

START = np.array(CONFIG.robot.start)
GOAL = START + np.array([2.0, -0.5, 0.4, 1.5, 0.3, -1.0])
TURN_NS = 2 * NS_PER_MS
MS = [20.0, 40.0, 60.0, 90.0]


class PerfectArm(PositionArm):
    """Is where it was sent, and keeps where that was."""

    joints = 6
    lag_ms = 20.0
    writes_stop = True

    def __init__(self, clock: FakeClock, rate_hz: float) -> None:
        self.clock, self.rate_hz, self.q = clock, rate_hz, START
        self.sent, self.sent_ns = list[Array](), list[int]()
        self.stops = 0

    def read(self) -> Array:
        return self.q

    def write(self, positions: Array) -> None:
        self.q = positions
        self.sent.append(positions)
        self.sent_ns.append(self.clock.now_ns())

    def stop(self) -> None:
        self.stops += 1


@dataclass
class Rig:
    """Control, which never pauses, leads the arm to `goal`; the driver's process turns every 2 ms, and pauses."""

    rate_hz: float = 100.0
    goal: Array = field(default_factory=lambda: GOAL)
    speed: float = 1.0  # of the joints' own

    def __post_init__(self) -> None:
        self.clock = FakeClock(NS_PER_S)
        self.arm = PerfectArm(self.clock, self.rate_hz)
        self.driver = PositionArmDriver(self.arm, self.clock)
        self.process = SteppedDriverProcess(CONFIG, self.driver, self.clock)
        self.supervisor, link = self.process.supervisor, self.process.link
        self.control = LeadingControl(link, SETUP.limits.scaled_speed(self.speed), self.clock, START)
        self.turn_ns, self.ended = self.clock.now_ns(), False
        self._turns(400)
        link.activate(START)
        self._turns(10)

    def run(self, ms: float, pause_ms: float = 0.0) -> "Rig":
        """The driver's process pauses, and then turns for so long."""
        self.turn_ns += round(pause_ms * NS_PER_MS)
        end_ns = self.turn_ns + round(ms * NS_PER_MS)
        while self.turn_ns < end_ns:
            if self.rate.next_ns <= self.turn_ns and not self.ended:
                self.rate.wait()
                self.control.order(self.goal)
            else:
                self._turn()
        return self

    def _turns(self, ms: float) -> None:
        for _ in range(round(ms * NS_PER_MS / TURN_NS)):
            self._turn()
        self.rate = Rate(RATE_HZ, self.clock, least_fraction=LEAST_FRACTION)

    def _turn(self) -> None:
        self.clock.sleep_until_ns(max(self.turn_ns, self.clock.now_ns()))
        self.process.turn()
        self.turn_ns = self.clock.now_ns() + TURN_NS

    def most(self) -> float:
        """The longest step of any joint, as a fraction of a period's at full speed."""
        period_s = max(1 / self.rate_hz, SETUP.dt)
        steps = np.abs(np.diff([START, *self.arm.sent], axis=0))
        return float((steps / (SETUP.limits.velocity * period_s)).max())


@pytest.mark.slow
@pytest.mark.parametrize("rate_hz", [30.0, 100.0, 500.0])
@pytest.mark.parametrize("pause_ms", MS)
def test_after_a_pause_no_step_is_longer_and_the_arm_ends_where_the_plan_does(pause_ms: float, rate_hz: float) -> None:
    rig = Rig(rate_hz).run(300).run(3000, pause_ms)
    assert rig.supervisor.fault is None
    assert rig.most() <= 1.0001
    assert rig.most() > 0.5  # it was fast
    assert np.diff([q[0] for q in rig.arm.sent]).min() >= -1e-8  # and never goes back


@pytest.mark.slow
@pytest.mark.parametrize("rate_hz", [30.0, 100.0, 500.0])
@pytest.mark.parametrize("pause_ms", MS)
def test_after_a_pause_the_arm_goes_no_faster_than_it_would_have(pause_ms: float, rate_hz: float) -> None:
    """What it has missed is no reason to go at full speed."""
    rig = Rig(rate_hz, speed=0.25).run(500)
    before = rig.most()
    rig.run(2000, pause_ms)
    assert rig.supervisor.fault is None
    assert before > 0.2
    assert rig.most() <= before / LEAST_FRACTION * 1.01


def test_after_a_pause_the_arm_is_written_no_more_often_than_it_takes_positions() -> None:
    rig = Rig().run(300).run(1000, 60.0)
    assert np.diff(rig.arm.sent_ns).min() >= (10 - 2.1) * NS_PER_MS
    rig.ended = True
    rig.driver.stop()
    first = len(rig.arm.sent_ns)
    rig.run(20)
    rig.run(1000, 55.0)
    assert np.diff(rig.arm.sent_ns[first:]).min() >= (10 - 2.1) * NS_PER_MS
    assert rig.arm.sent[-1] == pytest.approx(GOAL, abs=1e-6)


@pytest.mark.slow
def test_pauses_by_chance_make_no_step_longer() -> None:
    rng = np.random.default_rng(8)
    for _ in range(12):
        rig = Rig(float(rng.choice([20.0, 50.0, 100.0, 250.0])), START + rng.uniform(-1.0, 1.0, 6) * (GOAL - START))
        for _ in range(int(rng.integers(1, 6))):
            rig.run(float(rng.uniform(5, 300)), float(rng.uniform(0, 95)))
        rig.run(4000)
        assert rig.supervisor.fault is None
        assert rig.most() <= 1.0001
        assert rig.arm.sent[-1] == pytest.approx(rig.goal, abs=1e-6)


@pytest.mark.parametrize("pause_ms", MS)
def test_the_drivers_own_stop_goes_on_from_where_the_arm_was_sent(pause_ms: float) -> None:
    """Control is gone: the supervisor leads the arm to rest, and pauses meanwhile."""
    rig = Rig().run(300)
    before = rig.supervisor.commanded.motion
    rig.ended = True
    rig.run(40)
    rig.run(2000, pause_ms)
    assert rig.supervisor.fault is not None
    assert rig.most() <= 1.0001
    assert rig.supervisor.commanded.motion.resting
    assert rig.arm.sent[-1] == pytest.approx(rig.supervisor.commanded.motion.q, abs=1e-6)
    assert rig.arm.sent[-1][0] > before.q[0]


@pytest.mark.parametrize("pause_ms", [0.0, 15.0, *MS])
def test_a_stop_that_is_written_goes_on_from_where_the_arm_was_sent(pause_ms: float) -> None:
    rig = Rig().run(300)
    rig.ended = True
    at, dq = rig.arm.q, rig.supervisor.written.dq
    rig.driver.stop()
    rig.run(20)
    rig.run(1000, pause_ms)
    assert rig.most() <= 1.0001
    assert (np.sign(dq) * (rig.arm.q - at) >= -1e-9).all()
    assert rig.arm.stops >= 1


def test_a_step_too_far_is_made_in_several_on_a_straight_line() -> None:
    rig = Rig()
    rig.driver.activate(rig.arm.q)
    far = START + np.array([0.1, -0.05, 0, 0, 0, 0])
    command = JointCommand(1, rig.clock.now_ns(), far, np.zeros(6), np.zeros(6), GripperCommand.KEEP)
    for _ in range(5):
        rig.driver.write(command)
    ways = np.array(rig.arm.sent) - START
    assert ways[:, 1] == pytest.approx(-ways[:, 0] / 2)
    assert np.diff(ways[:3, 0]) == pytest.approx(SETUP.limits.velocity[0] * 0.01, rel=1e-4)
    assert rig.arm.sent[-1] == pytest.approx(far)
