"""An arm follows as long as it is where it was commanded within its lag, and is a fault when it is not."""

from dataclasses import replace

import numpy as np
import pytest

from common.clock import NS_PER_MS
from remote_site.drivers.driver import Capabilities, RobotReading
from remote_site.drivers.faults import FaultCode, RobotFault
from remote_site.drivers.supervisor.following_check import MARGIN_NS, PATIENCE_NS, TOLERANCE_RAD, FollowingCheck
from remote_site.drivers.supervisor.state import SupervisorState
from tests.remote_site.drivers.supervisor.supervised import START, Supervised
from tests.remote_site.spoiled_readings import drifting


class Lagging:
    """Readings that show where the arm was some time ago."""

    def __init__(self, ms: float) -> None:
        self._lag_ns = round(ms * NS_PER_MS)
        self._before: list[RobotReading] = []

    def __call__(self, reading: RobotReading) -> RobotReading:
        self._before.append(reading)
        due_ns = reading.t_ns - self._lag_ns
        then = max(
            (each for each in self._before if each.t_ns <= due_ns), key=lambda r: r.t_ns, default=self._before[0]
        )
        return replace(reading, q=then.q, dq=then.dq)


def capabilities(rate_hz: float = 1000.0, queued: int = 0, lag_ms: float = 0.0) -> Capabilities:
    return Capabilities(
        rate_hz, None, gripper=False, force=False, watchdog_ms=None, queued_periods=queued, lag_ms=lag_ms
    )


def sweep(lag_ms: float, follows_ms: float) -> Supervised:
    """An arm that declares `lag_ms` and follows this late, on its way to the goal and at rest there."""
    rig = Supervised(lag_ms=lag_ms)
    rig.activate()
    rig.robot.spoil = Lagging(follows_ms)
    for _ in range(300):
        rig.command()
        if rig.supervisor.fault is not None:
            break
    return rig


@pytest.mark.parametrize(("lag_ms", "follows_ms"), [(0.0, 0), (0.0, 45), (200.0, 240), (0.0, 80)])
def test_an_arm_that_follows_within_its_lag_is_no_fault(lag_ms: float, follows_ms: float) -> None:
    rig = sweep(lag_ms, follows_ms)
    assert rig.supervisor.fault is None
    assert rig.sent.resting


@pytest.mark.parametrize(("lag_ms", "follows_ms"), [(0.0, 200), (100.0, 400)])
def test_an_arm_that_follows_later_than_it_declares_is_stopped_and_named(lag_ms: float, follows_ms: float) -> None:
    rig = sweep(lag_ms, follows_ms)
    fault = rig.fault()
    assert fault.code is FaultCode.NOT_FOLLOWING
    assert "joint_1" in fault.sentence
    assert f"{lag_ms + 52:.0f} ms" in fault.sentence
    assert rig.supervisor.state is SupervisorState.IDLE
    assert rig.robot.stops == 1


def test_a_robot_that_reports_what_blocks_it_keeps_its_own_fault() -> None:
    rig = Supervised().moving()
    rig.robot.spoil = drifting(-0.5)
    rig.commands(40)
    assert rig.supervisor.reading is not None
    assert rig.supervisor._following.excess(rig.supervisor.reading.q).max() > TOLERANCE_RAD
    assert rig.supervisor.fault is None
    rig.robot.trouble = blocked = RobotFault(FaultCode.BLOCKED, "a joint is blocked")
    rig.commands(20)
    assert rig.fault() is blocked


def test_the_lag_is_that_of_the_driver_with_a_margin() -> None:
    assert FollowingCheck(capabilities(), ("a",)).lag_ns == 2 * NS_PER_MS + MARGIN_NS
    assert FollowingCheck(capabilities(15.0, 2), ("a",)).lag_ns == pytest.approx(4e9 / 15 + MARGIN_NS, abs=1)
    assert FollowingCheck(capabilities(lag_ms=150.0), ("a",)).lag_ns == 152 * NS_PER_MS + MARGIN_NS


@pytest.mark.parametrize("off", [TOLERANCE_RAD * 0.99, TOLERANCE_RAD * 1.01])
def test_a_joint_may_be_off_by_the_tolerance_and_no_more_for_long(off: float) -> None:
    check = FollowingCheck(capabilities(), tuple("abcdef"))
    check.restart(START, 0)
    q = START - off * np.eye(6)[4]
    faults = [check.judge(q, k * NS_PER_MS) for k in range(120)]
    found = [k for k, fault in enumerate(faults) if fault is not None]
    assert (found[0] if found else None) == (PATIENCE_NS / NS_PER_MS if off > TOLERANCE_RAD else None)
    assert not found or str(faults[-1]).startswith("not_following: e is 0.10 rad")


def test_one_reading_that_is_right_again_ends_the_suspicion() -> None:
    check = FollowingCheck(capabilities(), tuple("abcdef"))
    check.restart(START, 0)
    for k in range(400):
        q = START if k % 90 == 0 else START + 0.5
        assert check.judge(q, k * NS_PER_MS) is None


def test_what_was_written_before_the_lag_no_longer_counts() -> None:
    check = FollowingCheck(capabilities(), tuple("abcdef"))
    check.restart(START, 0)
    goal = START + 1.0
    check.note(goal, 10 * NS_PER_MS)
    check.note(goal, 10 * NS_PER_MS + check.lag_ns - 1)
    assert check.excess(START).max() == 0.0  # where it was, and anything between
    assert check.excess(START + 0.5).max() < 0.0
    check.note(goal, 10 * NS_PER_MS + check.lag_ns)
    assert check.excess(START).max() == 1.0
    assert check.excess(goal).max() == 0.0


def test_after_an_activation_elsewhere_nothing_that_was_written_before_counts() -> None:
    check = FollowingCheck(capabilities(), tuple("abcdef"))
    check.restart(START, 0)
    check.restart(START + 1.0, NS_PER_MS)
    assert check.excess(START).max() == 1.0
