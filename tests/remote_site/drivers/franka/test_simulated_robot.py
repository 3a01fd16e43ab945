"""The driver against a simulator that speaks the FR3's protocol, in processes of their own, by the robot's clock."""

import subprocess
import sys
from collections.abc import Iterator
from importlib.metadata import entry_points
from importlib.util import find_spec

import numpy as np
import pytest

from common.clock import NS_PER_MS, Clock
from common.messages.robot import GripperCommand
from common.process.children import READY_TIMEOUT_S, Children
from common.process.service import StopFlag
from remote_site.config import RemoteConfig
from remote_site.drivers.driver import Driver, JointCommand, RobotReading
from remote_site.drivers.factories import franka
from remote_site.drivers.registry import GROUP, DriverHost
from remote_site.kinematics.joints import JointMotion
from remote_site.motion.jerk_limited import JerkLimitedTracker
from remote_site.runtime.emulated_robot import start_robot
from tests.remote_site.drivers.franka.fake_robot import CONFIG, SETUP

MISSING = [name for name in ("pylibfranka", "franky_sim") if find_spec(name) is None]
pytestmark = pytest.mark.skipif(bool(MISSING), reason=f"{' and '.join(MISSING)} missing: make franka")
AHEAD_RAD = 0.2
CONFORMS_S = 900.0
UNDECIDED = 3
TICK_MS = 4
TRIES = 5
PAUSE_MS = 16  # between two setpoints; from 20 ms on the way back to them can exceed the robot's acceleration


@pytest.fixture
def simulated() -> Iterator[tuple[RemoteConfig, Clock]]:
    children = Children("simulated")
    try:
        config, clock = start_robot(CONFIG, children)
        children.wait_ready(READY_TIMEOUT_S, StopFlag())
        yield config, clock
    finally:
        children.end()


@pytest.fixture
def driver(simulated: tuple[RemoteConfig, Clock]) -> Iterator[Driver]:
    config, clock = simulated
    made = franka(DriverHost(clock, config.driver.options))
    try:
        yield made
    finally:
        made.deactivate()


def until(driver: Driver, clock: Clock, code: str) -> RobotReading:
    """The reading once its fault is this, "" for none, within two seconds of the robot."""
    for _ in range(500):
        clock.sleep_until_ns(clock.now_ns() + TICK_MS * NS_PER_MS)
        reading = driver.read()
        if (reading.fault.code.value if reading.fault is not None else "") == code:
            return reading
    raise AssertionError(f"it says {reading.fault}, not {code!r}")


@pytest.mark.slow
def test_it_connects_moves_stops_and_can_be_activated_again(
    driver: Driver, simulated: tuple[RemoteConfig, Clock]
) -> None:
    clock = simulated[1]
    driver.configure(SETUP)
    first = driver.read()
    assert np.abs(first.q - CONFIG.robot.start).max() < 0.01
    moved = _moved(driver, clock, first.q + AHEAD_RAD * np.eye(7)[0])
    assert moved.fault is None
    assert moved.obeyed_seq is not None
    assert moved.q[0] - first.q[0] == pytest.approx(AHEAD_RAD, abs=0.01)
    assert np.abs(moved.q - first.q)[1:].max() < 0.01
    assert 0 <= clock.now_ns() - moved.t_ns < 100 * NS_PER_MS
    driver.stop()
    rested = until(driver, clock, "stopped")
    clock.sleep_until_ns(clock.now_ns() + 300 * NS_PER_MS)
    driver.activate(driver.read().q)
    again = until(driver, clock, "")
    assert np.abs(again.q - rested.q).max() < 0.01
    assert again.gripper is not None
    assert 0.0 <= again.gripper.opening_m <= 0.09


def _moved(driver: Driver, clock: Clock, target: np.ndarray) -> RobotReading:
    """The reading after a motion to `target`; again where the machine paused this process: the arm brakes then."""
    for _ in range(TRIES):
        driver.activate(driver.read().q)
        until(driver, clock, "")
        paused_ns = _lead(driver, clock, target)
        reading = driver.read()
        if reading.fault is None or paused_ns <= PAUSE_MS * NS_PER_MS:
            break
        clock.sleep_until_ns(clock.now_ns() + 300 * NS_PER_MS)
    return reading


def _lead(driver: Driver, clock: Clock, target: np.ndarray) -> int:
    """A setpoint each tick, for as long as such a motion takes, and its lag; the longest time between two, ns."""
    follower, motion = JerkLimitedTracker(SETUP.limits, SETUP.dt), JointMotion.at_rest(driver.read().q)
    written, paused_ns = clock.now_ns(), 0
    for seq in range(1, 301):
        follower.reset(motion)
        followed = follower.track(JointMotion.at_rest(target))
        assert isinstance(followed, JointMotion)
        motion = followed
        now = clock.now_ns()
        driver.write(JointCommand(seq, now, motion.q, motion.dq, motion.ddq, GripperCommand.KEEP))
        paused_ns, written = max(paused_ns, now - written), now
        clock.sleep_until_ns(now + TICK_MS * NS_PER_MS)
    return paused_ns


@pytest.mark.long
@pytest.mark.skipif(
    "franka" not in entry_points(group=GROUP).names, reason="installed before there was this driver: make franka"
)
def test_it_passes_the_conformance_suite() -> None:
    command = [sys.executable, "-m", "farhand", "driver", "test", "franka", "--emulate"]
    ended = subprocess.run(command, capture_output=True, text=True, timeout=CONFORMS_S, check=False)
    if ended.returncode == UNDECIDED:
        pytest.skip(f"this machine was too busy to judge it: {ended.stdout[-400:]}")
    assert ended.returncode == 0, ended.stdout + ended.stderr
    assert "franka: all passed" in ended.stdout
