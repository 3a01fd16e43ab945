"""The pipeline as a whole: what the driver receives stays within every limit, whatever the hand and the wire do."""

from typing import Any

import numpy as np
import pytest
from hypothesis import HealthCheck, given, settings
from hypothesis import strategies as st

from common.clock import NS_PER_MS
from common.messages.hand import TrackingStatus
from common.messages.requests import EngagementAction
from common.messages.robot import SessionState
from remote_site.drivers.faults import FaultCode, RobotFault
from remote_site.safety.stopping import stop_time
from remote_site.session.requests import SessionRequest
from remote_site.teleop.cycle import CycleInput, RobotObservation
from tests.remote_site.remote_loop import (
    TICK_NS,
    RemoteLoop,
    assert_within_limits,
    hand,
    workspace,
)

SAMPLE_TICKS = 8


def still(_t_ns):
    return (0.0, 0.0, 0.3)


def swaying(t_ns):
    t = t_ns / 1e9
    return (0.1 * np.sin(2.5 * t), 0.05 * np.sin(4 * t), 0.3 + 0.08 * np.sin(3 * t))


def engaged_loop(motion=still):
    loop = RemoteLoop()
    loop.run(SAMPLE_TICKS * 31, motion)
    assert loop.states[-1] is SessionState.ENGAGED
    return loop


def test_a_still_hand_engages_after_thirty_frames_and_moves_nothing():
    loop = engaged_loop()
    assert loop.states.index(SessionState.ENGAGED) == 29 * SAMPLE_TICKS
    loop.run(200, still)
    q, _, _ = loop.arrays()
    assert np.abs(q - loop.config.robot.start).max() < 1e-9


def test_the_tool_follows_the_hand_within_limits():
    loop = engaged_loop(swaying)
    origin_ns = loop.clock.now_ns() - 2 * SAMPLE_TICKS * TICK_NS
    loop.run(1000, swaying)
    assert_within_limits(loop)
    moved = loop.model.forward(loop.sent.q)[:3, 3] - loop.model.forward(loop.config.robot.start)[:3, 3]
    hand_moved = np.subtract(swaying(loop.clock.now_ns()), swaying(origin_ns))
    in_base = np.array(loop.config.mapping.base_R_operator) @ hand_moved
    assert np.linalg.norm(moved - in_base) < 0.03
    assert loop.refusals == 0


@pytest.mark.parametrize("phase_ticks", [0, 37, 90])
def test_silence_stops_the_arm_by_the_soft_limit_and_the_stop_time_then_latches(phase_ticks):
    loop = engaged_loop(swaying)
    loop.run(100 + phase_ticks, swaying)
    born_ns = loop.newest.born_ns
    onset = None
    for _ in range(200):
        loop.tick()
        age_ns = loop.clock.now_ns() - born_ns
        if onset is None and age_ns > 100 * NS_PER_MS:
            onset = stop_time(loop.log[-2], loop.limits)
            deadline_ns = born_ns + 100 * NS_PER_MS + 2 * TICK_NS + round(onset * 1e9)
        if onset is not None and loop.clock.now_ns() >= deadline_ns:
            assert not loop.sent.dq.any()
        expected = SessionState.HOLDING if age_ns <= 500 * NS_PER_MS else SessionState.DISENGAGED
        assert loop.states[-1] is (SessionState.ENGAGED if onset is None else expected)
    assert_within_limits(loop)


def test_a_link_that_comes_back_after_the_latch_never_moves_the_arm():
    loop = engaged_loop(swaying)
    loop.run(100, swaying)
    loop.run(200)
    at_rest = loop.sent.q.copy()
    loop.run(1000, swaying)
    assert loop.states[-1] is SessionState.DISENGAGED
    assert np.array_equal(loop.sent.q, at_rest)
    assert loop.ask(EngagementAction.ENGAGE).done
    loop.run(100, swaying)
    assert loop.states[-1] is SessionState.ENGAGED
    assert not np.array_equal(loop.sent.q, at_rest)


def test_a_short_silence_is_not_caught_up():
    loop = engaged_loop()
    far_away = (0.25, 0.0, 0.3)
    loop.run(75)
    held = loop.sent.q.copy()
    loop.run(400, lambda _t_ns: far_away)
    assert loop.states[-1] is SessionState.ENGAGED
    assert np.abs(loop.sent.q - held).max() < 1e-9


def test_a_lost_hand_stops_at_once_and_a_returning_one_takes_new_origins():
    loop = engaged_loop(swaying)
    loop.run(SAMPLE_TICKS, swaying, status=TrackingStatus.LOST, reason="arm left the view")
    assert loop.states[-1] is SessionState.HOLDING
    loop.run(60, swaying, status=TrackingStatus.LOST)
    rest = loop.sent
    assert rest.resting
    loop.run(SAMPLE_TICKS * 3, lambda _t_ns: (0.05, 0.05, 0.35))
    assert loop.states[-1] is SessionState.ENGAGED
    loop.run(200, lambda _t_ns: (0.05, 0.05, 0.35))
    assert np.abs(loop.sent.q - rest.q).max() < 1e-9


def test_a_new_local_session_stops_the_arm_until_engaged_anew():
    loop = engaged_loop(swaying)
    loop.grant(8)
    loop.run(1000, swaying, session=8)
    assert loop.states[-1] is SessionState.DISENGAGED
    assert loop.sent.resting
    assert loop.ask(EngagementAction.ENGAGE).done


def test_a_jump_of_the_wrist_moves_nothing_and_three_latch():
    loop = engaged_loop()
    start = loop.sent.q.copy()
    loop.run(SAMPLE_TICKS * 2, lambda _t_ns: (1.0, 0.0, 0.3))
    assert loop.states[-1] is SessionState.ENGAGED
    loop.run(SAMPLE_TICKS, lambda _t_ns: (1.0, 0.0, 0.3))
    assert loop.states[-1] is SessionState.DISENGAGED
    moved = loop.model.forward(loop.sent.q)[:3, 3] - loop.model.forward(start)[:3, 3]
    assert np.linalg.norm(moved) < 1e-3


def test_a_target_out_of_reach_saturates_without_thrash_and_the_way_back_is_open():
    loop = engaged_loop()

    def out_and_back(t_ns):
        t = (t_ns - begin_ns) / 1e9
        return (0.0, -1.5 * min(t, 2.0) + 1.5 * max(0.0, min(t - 4.0, 2.0)), 0.3)

    begin_ns = loop.clock.now_ns()
    loop.run(1000, out_and_back)
    _, dq, _ = loop.arrays()
    assert np.abs(dq[-100:]).max() < 0.05
    loop.run(700, out_and_back)
    start = loop.model.forward(loop.config.robot.start)[:3, 3]
    assert np.linalg.norm(loop.model.forward(loop.sent.q)[:3, 3] - start) < 0.005
    assert_within_limits(loop)


@pytest.mark.slow
def test_the_tool_never_rests_outside_the_workspace():
    loop = engaged_loop()

    def sweep(t_ns):
        t = (t_ns - begin_ns) / 1e9
        return (0.6 * np.sin(1.5 * t), 0.4 * np.sin(1.1 * t), 0.3 + 0.5 * np.sin(1.9 * t))

    begin_ns = loop.clock.now_ns()
    loop.run(4000, sweep)
    assert_within_limits(loop)
    tools = [loop.model.forward(motion.q)[:3, 3] for motion in loop.log]
    assert max(workspace(loop.config).excess(tool) for tool in tools) < 0.002
    assert np.ptp(tools, axis=0).min() > 0.2


def test_a_sweep_through_the_straight_wrist_stays_within_limits_and_can_back_out():
    loop = engaged_loop()
    down = np.radians(100.0)

    def points(t_ns):
        t = (t_ns - begin_ns) / 1e9
        a = down * 0.5 * (1 - np.cos(0.9 * t))
        y, z = -np.cos(a), np.sin(a)
        index = (0.02, 0.17 * y, 0.3 + 0.17 * z)
        thumb = (-0.05, 0.1 * y, 0.3 + 0.1 * z + 0.01)
        return index, thumb

    begin_ns = loop.clock.now_ns()
    for k in range(1750):
        index, thumb = points(loop.clock.now_ns())
        fresh = hand(1000 + k, loop.clock.now_ns(), index=index, thumb=thumb)
        loop.tick(*([fresh] if k % SAMPLE_TICKS == 0 else []))
    q, _, _ = loop.arrays()
    assert q[:, 4].max() > 0.1
    assert np.abs(q[-1] - loop.config.robot.start).max() < 0.05
    assert_within_limits(loop)


events = st.lists(
    st.tuples(
        st.sampled_from(["good", "good", "good", "lost", "nothing", "duplicate", "old", "late", "session", "engage"]),
        st.tuples(*(st.floats(-0.15, 0.15) for _ in range(3))),
        st.integers(1, 40),
    ),
    min_size=5,
    max_size=25,
)


@pytest.mark.slow
@settings(max_examples=25, deadline=None, derandomize=True, suppress_health_check=[HealthCheck.too_slow])
@given(events)
def test_no_sequence_of_events_breaks_the_invariant(sequence):
    loop = RemoteLoop()
    loop.run(SAMPLE_TICKS * 30, still)
    seq, session, wrist = 1000, 7, np.array([0.0, 0.0, 0.3])
    for kind, step, ticks in sequence:
        now_ns = loop.clock.now_ns()
        wrist = wrist + np.array(step) * 0.3
        place = tuple(wrist.tolist())
        seq += kind in ("good", "lost", "session")
        if kind == "session":
            session += 1
            loop.grant(session)
        may_change: dict[str, dict[str, Any]] = {
            "lost": {"status": TrackingStatus.LOST, "wrist": None},
            "late": {"capture_ns": now_ns - 150 * NS_PER_MS},
            "old": {"seq": seq - 3},
        }
        given = {"seq": seq, "capture_ns": now_ns, "wrist": place, "session": session, "lease": loop.lease}
        if kind == "engage":
            loop.ask(EngagementAction.ENGAGE)
        fields: dict[str, Any] = given | may_change.get(kind, {})
        samples = [] if kind in ("nothing", "engage") else [hand(**fields)]
        state = loop.states[-1]
        for k in range(ticks):
            loop.tick(*(samples if k == 0 else []))
        if state is SessionState.DISENGAGED and kind != "engage" and SessionState.ENGAGED in loop.states[-ticks:]:
            assert loop.session.engagements == 1
    loop.run(100)
    assert loop.sent.resting
    assert_within_limits(loop)


def test_the_way_of_the_hands_samples_is_measured():
    link = engaged_loop().snapshot.hand_link
    assert link.age_ms == pytest.approx(4.0)


def test_over_a_slow_link_the_age_limit_grows_and_the_arm_follows():
    loop = RemoteLoop()
    for k in range(SAMPLE_TICKS * 40):
        loop.tick(*([] if k % SAMPLE_TICKS else [hand(k + 1, loop.clock.now_ns() - 120 * NS_PER_MS)]))
    assert loop.snapshot.age_limit_ms > 120
    assert loop.states[-1] is SessionState.ENGAGED


@pytest.mark.parametrize("fault", [FaultCode.COMMAND_TIMEOUT, FaultCode.ROBOT])
def test_a_robot_is_activated_again_where_it_is_read(fault):
    """It may have sunk since it was sent anywhere; of itself, or with the reset that it takes."""
    loop = RemoteLoop()
    robot = RobotObservation(loop.sent.q + 0.01, RobotFault(fault, "says the robot"), loop.sent, None)
    now_ns = loop.clock.now_ns() + TICK_NS
    command = loop.pipeline.cycle(CycleInput(now_ns, robot, loop.leases.status(now_ns)))
    if fault is FaultCode.ROBOT:
        assert command.activate_at is None
        reset = SessionRequest(EngagementAction.RESET, "service", maintenance=True, seen_ns=command.snapshot.halted_ns)
        given = CycleInput(now_ns + TICK_NS, robot, loop.leases.status(now_ns), requests=(reset,))
        command = loop.pipeline.cycle(given)
    assert command.activate_at == pytest.approx(robot.q)
