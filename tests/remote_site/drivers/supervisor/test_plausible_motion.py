"""A joint that is read elsewhere than it can have got to is a fault at once, and none that moves as it may."""

import numpy as np
import pytest

from common.clock import NS_PER_MS, NS_PER_S
from remote_site.drivers.driver import Capabilities, RobotReading
from remote_site.drivers.faults import FaultCode, RobotFault
from remote_site.drivers.supervisor.reading_check import ReadingCheck
from tests.remote_site.drivers.supervisor.supervised import LIMITS, SETUP, START

BEGIN_NS = 5_000 * NS_PER_MS
FASTEST = float(LIMITS.velocity[0])  # rad/s
LONG_MS = 400  # as long the joint can go at full speed within its range


class Judged:
    """A check, and what it made of the readings of the first joints of an arm otherwise at rest."""

    def __init__(self, rate_hz: float = 1000.0) -> None:
        self._check = ReadingCheck(
            Capabilities(rate_hz, None, gripper=False, force=False, watchdog_ms=None), setup=SETUP
        )
        self.faults: list[RobotFault] = []

    def read(self, off_rad: float, read_ms: float, stamp_ms: float | None = None, joint: int = 0) -> bool:
        """Whether a joint that is read this far off is believed, read and stamped so many ms after the begin."""
        t_ns = BEGIN_NS + round((read_ms if stamp_ms is None else stamp_ms) * NS_PER_MS)
        q = START + off_rad * np.eye(6)[joint]
        judged = self._check.judge(
            RobotReading(t_ns, q, np.zeros(6), None, None, None), BEGIN_NS + round(read_ms * NS_PER_MS)
        )
        self.faults += [judged] if isinstance(judged, RobotFault) else []
        return isinstance(judged, RobotReading)


@pytest.mark.parametrize("joint", range(6))
@pytest.mark.parametrize("off_rad", [1.0, -0.5, 0.2])
def test_a_joint_that_jumps_for_8_ms_is_never_believed(joint: int, off_rad: float) -> None:
    judged = Judged()
    believed = [judged.read(off_rad if 100 <= ms < 108 else 0.0, ms, joint=joint) for ms in range(0, 200, 2)]
    assert believed == [not 100 <= ms < 108 for ms in range(0, 200, 2)]
    assert {fault.code for fault in judged.faults} == {FaultCode.IMPLAUSIBLE}
    assert f"the reading of joint_{joint + 1} jumped to" in judged.faults[0].sentence


def test_a_posture_that_stays_is_believed_when_the_joint_had_the_time_to_get_there_and_not_before() -> None:
    judged = Judged()
    judged.read(0.0, 0)
    believed = [ms for ms in range(2, 1000, 2) if judged.read(1.0, ms)]
    assert believed == list(range(believed[0], 1000, 2))
    assert 0.5 / FASTEST < believed[0] / 1000 < 1.0 / FASTEST


def test_what_drifts_faster_than_a_joint_moves_is_found_however_small_its_steps_are() -> None:
    judged = Judged()
    believed = [judged.read(0.001 * FASTEST * 3.0 * ms, ms) for ms in range(40)]
    assert believed[:5] == [True] * 5
    assert not believed[-1]


def moving(ms: float) -> float:
    """Where a joint is that goes to and fro at full speed, rad."""
    return FASTEST * (LONG_MS / 2 - abs(ms % LONG_MS - LONG_MS / 2)) / 1000


def test_a_joint_at_full_speed_is_believed_with_a_little_overshoot_and_noise() -> None:
    judged, rng = Judged(), np.random.default_rng(4)
    assert all(judged.read(1.05 * moving(ms) + rng.uniform(-0.01, 0.01), ms) for ms in range(0, 4000, 2))


@pytest.mark.parametrize(("rate_hz", "step_ms"), [(1000.0, 10), (100.0, 20), (30.0, 30), (15.0, 66)])
def test_a_joint_is_believed_although_its_stamps_are_coarse(rate_hz: float, step_ms: int) -> None:
    judged = Judged(rate_hz)
    assert all(judged.read(moving(ms), ms, ms // step_ms * step_ms) for ms in range(0, 2000, 2)), judged.faults


@pytest.mark.parametrize(("rate_hz", "period_ms"), [(50.0, 20), (15.0, 66)])
def test_a_joint_is_believed_although_a_slow_robot_repeats_readings_under_new_stamps(
    rate_hz: float, period_ms: int
) -> None:
    judged = Judged(rate_hz)
    assert all(judged.read(moving(ms // period_ms * period_ms), ms) for ms in range(0, 2000, 2)), judged.faults


@pytest.mark.parametrize("pause_ms", [20, 48, 90, 300, 1000])
@pytest.mark.parametrize("stamped_late", [False, True])
def test_a_pause_of_this_process_makes_no_jump_of_a_motion(pause_ms: int, *, stamped_late: bool) -> None:
    """A pause within a reading stamps what was measured before it with the time after it."""
    judged = Judged()
    before = [judged.read(moving(ms), ms) for ms in range(0, 150, 2)]
    late = [judged.read(moving(150 if stamped_late else 150 + pause_ms), 150 + pause_ms)]
    after = [judged.read(moving(ms + pause_ms), ms + pause_ms) for ms in range(152, 300, 2)]
    assert all([*before, *late, *after]), judged.faults


def test_after_a_pause_a_jump_is_found_again_as_soon_as_before() -> None:
    judged = Judged()
    assert all(judged.read(0.0, ms) for ms in (0, 300, 302, 304))
    assert not judged.read(0.2, 306)


def test_readings_that_are_not_believed_do_not_move_the_bounds() -> None:
    judged = Judged()
    believed = [judged.read(1.0 if ms % 4 else 0.0, ms) for ms in range(0, 2 * NS_PER_S // NS_PER_MS, 2)]
    assert believed == [ms % 4 == 0 for ms in range(0, 2000, 2)]
