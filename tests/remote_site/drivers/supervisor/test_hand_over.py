"""Control continues from within a stop that its silence began."""

from dataclasses import replace

import numpy as np
import pytest

from common.clock import NS_PER_MS, NS_PER_S
from remote_site.drivers.supervisor.state import SupervisorState
from remote_site.drivers.supervisor.write_scheduler import LEAST_FRACTION
from tests.remote_site.drivers.supervisor.supervised import LIMITS, START, Supervised, assert_smooth


@pytest.mark.parametrize("silent_ms", [13.0, 20.3, 33.9, 47.0])
def test_control_continues_from_within_the_stop_at_once(rig: Supervised, silent_ms: float) -> None:
    rig.moving()
    rig.stumble(silent_ms)
    slowed = rig.stop_at().dq[0]
    rig.sent = rig.stop_at()
    rig.turn(rig.order(rig.sent), ms=0)
    rig.commands(200)
    assert rig.supervisor.state is SupervisorState.FOLLOWING
    assert rig.stop_count == 1
    speeds = np.array([c.dq[0] for c in rig.robot.written])
    since = next(k for k in range(len(speeds)) if speeds[k] == slowed)
    assert slowed > 0.5
    assert speeds[since:].max() > slowed  # it brakes no more
    assert rig.motion.q[0] == pytest.approx(START[0] + 0.8, abs=1e-6)
    assert np.diff([c.q[0] for c in rig.robot.written]).min() >= -1e-8  # rounding at the goal
    assert_smooth(rig.robot)


@pytest.mark.parametrize("ahead_ms", [0.2, 0.9])
def test_a_stop_written_a_little_past_the_command_that_ends_it_is_not_taken_back(
    rig: Supervised, ahead_ms: float
) -> None:
    rig.moving()
    rig.stumble(20)
    rig.sent = rig.stop_at(-ahead_ms)
    written = len(rig.robot.written)
    order = rig.order(rig.sent)
    early_ns = round(ahead_ms * NS_PER_MS)
    rig.turn(replace(order, command=replace(order.command, t_ns=order.command.t_ns - early_ns)), ms=0)
    assert (rig.stop_count, len(rig.robot.written)) == (1, written)
    assert rig.motion.q is rig.sent.q
    rig.clock.advance_ms(-ahead_ms)  # control's next tick comes a period after its last
    for _ in range(20):
        rig.sent = rig.plan()
        for ms in (2.0, 1.0, 0.5):
            rig.turn(ms=ms)
        rig.clock.advance_ms(0.5)
        rig.turn(rig.order(rig.sent), ms=0)
    assert np.diff([c.q[0] for c in rig.robot.written]).min() >= 0
    assert rig.supervisor.state is SupervisorState.FOLLOWING
    t, ddq = (np.array([getattr(c, key) for c in rig.robot.written]) for key in ("t_ns", "ddq"))
    jerk = np.diff(ddq, axis=0) / np.diff(t)[:, None] * NS_PER_S
    assert (np.abs(jerk) <= LIMITS.jerk / LEAST_FRACTION * 1.001).all()


@pytest.mark.parametrize("behind_ms", [1.1, 4.0])
def test_a_stop_written_far_past_the_command_goes_on(rig: Supervised, behind_ms: float) -> None:
    rig.moving()
    rig.stumble(20)
    order = rig.order(rig.stop_at(-behind_ms))
    late_ns = round(behind_ms * NS_PER_MS)
    rig.turn(replace(order, command=replace(order.command, t_ns=order.command.t_ns - late_ns)), ms=0)
    assert rig.stop_count == 2
    assert rig.supervisor.commanded.stop is not None
    assert rig.supervisor.fault is None


def test_a_command_planned_before_the_stop_began_is_ignored(rig: Supervised) -> None:
    rig.moving()
    old = rig.order(rig.plan())
    rig.turn(ms=14)
    begun = rig.motion
    rig.turn(old)
    assert rig.supervisor.fault is None
    assert rig.stop_count == 1
    assert rig.motion.dq[0] < begun.dq[0]


def test_a_command_that_misses_a_stop_that_went_on_has_to_be_planned_again(rig: Supervised) -> None:
    rig.moving()
    rig.turn(ms=14)
    rig.sent = rig.motion
    planned = rig.plan()
    rig.turn()
    rig.turn(rig.order(planned))
    assert rig.supervisor.fault is None
    assert rig.stop_count == 2


def test_control_that_is_always_behind_the_stop_continues_at_rest(rig: Supervised) -> None:
    rig.moving()
    rig.stumble(14)
    slowest, began = np.inf, rig.motion.q[0]
    for _ in range(400):
        rig.sent = rig.stop_at(-2.0) if rig.supervisor.commanded.stop is not None else rig.plan()
        rig.turn(ms=2)
        rig.turn(rig.order(rig.sent))
        slowest = min(slowest, abs(rig.motion.dq[0]))
    assert rig.supervisor.fault is None
    assert slowest < 0.01
    assert began < START[0] + 0.7
    assert rig.motion.q[0] == pytest.approx(START[0] + 0.8, abs=1e-6)
    assert_smooth(rig.robot)


def test_a_backlog_of_commands_is_discarded(rig: Supervised) -> None:
    rig.moving()
    backlog = []
    for _ in range(15):
        rig.sent = rig.plan()
        backlog.append(rig.order(rig.sent))
    written = len(rig.robot.written)
    rig.turn(*backlog, ms=60)
    assert rig.robot.written[written].dq[0] < backlog[0].command.dq[0]
    rig.turns(200)
    assert rig.supervisor.settled
    assert_smooth(rig.robot)
