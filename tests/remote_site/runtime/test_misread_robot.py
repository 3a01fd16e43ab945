"""The whole remote loop with a robot that is misread: it stops and latches, and only a reset brings it back."""

from dataclasses import replace
from typing import Any

import numpy as np
import pytest

from common.messages.requests import EngagementAction
from common.messages.robot import SessionState
from remote_site.drivers.driver import RobotReading
from remote_site.drivers.faults import FaultCode
from tests.remote_site.driven_loop import CONFIG, DrivenLoop, Spoil
from tests.remote_site.spoiled_readings import SPOILED, joint

FAST_M_S = 0.15


def moving() -> DrivenLoop:
    loop = DrivenLoop()
    loop.start()
    loop.run(100, FAST_M_S)
    assert np.abs(loop.supervisor.commanded.motion.dq).max() > 0.1
    return loop


def frozen(loop: DrivenLoop, *, stamp: bool) -> Spoil:
    """The reading as it is now; with `stamp` its time stands still too."""
    now = loop.supervisor.reading
    assert now is not None
    return lambda reading: now if stamp else replace(now, t_ns=reading.t_ns)


def faulty(loop: DrivenLoop, code: FaultCode) -> None:
    """The session is in FAULT by this code, nothing moves, and nothing that is not finite was sent or reported."""
    assert loop.state is SessionState.FAULT
    assert code.value in loop.snapshot.reason.sentence
    assert loop.supervisor.fault is not None
    assert loop.supervisor.fault.code is code
    assert loop.robot.finite
    report = loop.link.read()
    assert np.isfinite(report.q).all()
    assert report.sent.finite


def recovers(loop: DrivenLoop) -> None:
    """With good readings again a reset and an engagement, and nothing less, have the arm follow."""
    loop.robot.spoil = None
    written = len(loop.robot.written)
    loop.run(200)
    assert loop.state is SessionState.FAULT
    assert len(loop.robot.written) == written
    loop.ask(EngagementAction.RESET)
    loop.run(100)
    assert loop.state is SessionState.DISENGAGED
    assert loop.ask(EngagementAction.ENGAGE).done
    loop.run(20)
    assert loop.state is SessionState.ENGAGED
    assert loop.robot.finite


@pytest.mark.parametrize(("spoil", "code"), SPOILED.values(), ids=SPOILED)
def test_one_bad_reading_in_motion_stops_the_arm_and_latches_a_fault(spoil: Spoil, code: FaultCode) -> None:
    loop = moving()
    loop.robot.spoil = spoil
    loop.run(1, FAST_M_S)
    loop.robot.spoil = None
    written = len(loop.robot.written)
    loop.run(200, FAST_M_S)
    faulty(loop, code)
    assert len(loop.robot.written) == written
    recovers(loop)


def test_a_reset_while_the_robot_reads_nan_activates_nothing() -> None:
    loop = moving()
    loop.robot.spoil = joint(float("nan"))
    loop.run(50)
    activated = len(loop.robot.activated)
    loop.ask(EngagementAction.RESET)
    loop.run(50)
    assert not loop.ask(EngagementAction.ENGAGE).done
    loop.run(50)
    assert len(loop.robot.activated) == activated
    assert not loop.link.read().ready
    faulty_code = loop.supervisor.fault
    assert faulty_code is not None
    assert faulty_code.code is FaultCode.NOT_FINITE


def test_a_frozen_reading_stops_the_arm_although_reports_keep_coming() -> None:
    loop = moving()
    loop.robot.spoil = frozen(loop, stamp=True)
    loop.run(40, FAST_M_S)  # 160 ms
    faulty(loop, FaultCode.SILENT)
    recovers(loop)


def test_an_arm_that_stands_still_while_it_is_commanded_elsewhere_is_a_fault() -> None:
    loop = moving()
    loop.robot.spoil = frozen(loop, stamp=False)
    stood = loop.robot.written[-1].q
    for _ in range(300):
        loop.tick(speed_m_s=FAST_M_S)
        if loop.state is SessionState.FAULT:
            break
    faulty(loop, FaultCode.NOT_FOLLOWING)
    assert np.abs(loop.robot.written[-1].q - stood).max() < 0.3
    assert any(name in loop.snapshot.reason.sentence for name in loop.supervisor.commanded._guard.limits.names)


def test_an_arm_that_reads_nan_from_the_start_is_never_activated() -> None:
    loop = DrivenLoop()
    loop.robot.spoil = joint(float("nan"))
    loop.run(10)
    loop.link.activate(CONFIG.robot.start)
    loop.run(10)
    assert not loop.robot.activated
    assert loop.link.read().t_ns == 0


def test_control_sees_the_age_of_a_reading_by_itself() -> None:
    loop = moving()
    raw = loop.link._raw
    loop.run(1)
    assert loop.link.read().age_ns < 3e6
    loop.clock.advance_ms(40)
    loop.link._memory.report.write(raw._replace(at_ns=loop.clock.now_ns()))
    assert loop.link.read().ready
    for _ in range(4):
        loop.clock.advance_ms(40)
        loop.link._memory.report.write(raw._replace(at_ns=loop.clock.now_ns()))
        report = loop.link.read()
    assert report.fault is not None
    assert report.fault.code is FaultCode.SILENT
    assert report.age_ns > 1.9e8


def test_chance_readings_never_raise_and_never_reach_the_robot() -> None:
    rng = np.random.default_rng(15)
    loop = moving()
    values: list[Any] = [
        float("nan"),
        float("inf"),
        -1,
        10**30,
        "x",
        None,
        [1],
        np.zeros(6),
        np.full(6, np.nan),
        b"",
        True,
        {},
    ]

    def garbage(reading: RobotReading) -> object:
        if rng.random() < 0.7:
            return reading
        name = rng.choice(["t_ns", "q", "dq", "gripper", "fault", "obeyed_seq"])
        return replace(reading, **{str(name): values[rng.integers(len(values))]})

    loop.robot.spoil = garbage
    for _ in range(1500):
        action = [EngagementAction.RESET, EngagementAction.ENGAGE][rng.integers(2)]
        loop.tick(*([action] if rng.random() < 0.1 else []), speed_m_s=0.05)
        report = loop.link.read()
        assert np.isfinite(report.q).all()
        assert report.sent.finite
    assert loop.robot.finite
    assert len(loop.robot.activated) > 5
