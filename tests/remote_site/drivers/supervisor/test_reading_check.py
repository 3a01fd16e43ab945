"""What a reading must not be, at the supervisor: each becomes a fault, and never what the supervisor goes by."""

from dataclasses import replace
from types import SimpleNamespace

import numpy as np
import pytest

from common.clock import NS_PER_MS
from remote_site.drivers.driver import Capabilities, DriverSetup, GripperReading, RobotReading
from remote_site.drivers.faults import STOPPED, FaultCode, RobotFault
from remote_site.drivers.supervisor.reading_check import BEYOND_RAD, ReadingCheck
from remote_site.drivers.supervisor.state import SupervisorState
from remote_site.kinematics.limits import JointRange
from tests.remote_site.driven_loop import Spoil
from tests.remote_site.drivers.supervisor.supervised import LIMITS, SETUP, START, Supervised
from tests.remote_site.spoiled_readings import SPOILED, field, gripper, joint, later

NOW_NS = 5_000 * NS_PER_MS
ZERO = np.zeros(6)
LOWER, UPPER = LIMITS.lower - BEYOND_RAD, LIMITS.upper + BEYOND_RAD
WIDER = JointRange(LIMITS.lower - 1.0, LIMITS.upper + 1.0, LIMITS.velocity)


def capabilities(rate_hz: float) -> Capabilities:
    return Capabilities(rate_hz, None, gripper=True, force=True, watchdog_ms=None)


def check_of(rate_hz: float = 1000.0, setup: DriverSetup = SETUP) -> ReadingCheck:
    return ReadingCheck(capabilities(rate_hz), setup)


def at(t_ns: int = NOW_NS, q: np.ndarray = START, fault: RobotFault | None = None) -> RobotReading:
    return RobotReading(t_ns, q, ZERO, GripperReading(0.05, None), fault, None)


def code_of(judged: RobotReading | RobotFault) -> FaultCode | None:
    return judged.code if isinstance(judged, RobotFault) else None


@pytest.mark.parametrize(("spoil", "code"), SPOILED.values(), ids=SPOILED)
@pytest.mark.parametrize("driven", [True, False])
def test_a_bad_reading_is_a_fault_and_never_the_supervisors(spoil: Spoil, code: FaultCode, *, driven: bool) -> None:
    rig = Supervised()
    rig.robot.opening_m = 0.05
    rig = rig.moving() if driven else rig.activate()
    if not driven:
        rig.supervisor.stop(STOPPED, rig.clock.now_ns())
        rig.turns(10)
    before, written = rig.supervisor.reading, len(rig.robot.written)
    rig.robot.spoil = spoil  # type: ignore[assignment]  # as an untyped driver may
    rig.turn()
    assert rig.fault().code is code
    assert rig.supervisor.reading is before
    assert rig.supervisor.state is (SupervisorState.IDLE if driven else SupervisorState.HELD)
    assert all(command.motion.finite for command in rig.robot.written[written:])


@pytest.mark.parametrize(
    ("spoil", "wrong"),
    [
        (gripper("open"), "str as gripper.opening_m, not a number"),
        (gripper(None), "NoneType as gripper.opening_m, not a number"),
        (gripper(0.05, "strong"), "str as gripper.force_n, not a number, or None"),
        (field("fault", RobotFault("robot", "no")), "str as fault.code, not a FaultCode"),  # type: ignore[arg-type]
        (field("fault", RobotFault(FaultCode.ROBOT, None)), "NoneType as fault.sentence, not a str"),  # type: ignore[arg-type]
        (field("fault", RobotFault(FaultCode.ROBOT, "no", 7)), "int as fault.native, not a str"),  # type: ignore[arg-type]
        (field("fault", "E42"), "str as fault, not a RobotFault, or None"),
        (field("q", START.astype(object)), "ndarray of shape (6,) and dtype object as q, not an array of 6 numbers"),
        (field("dq", ZERO * 1j), "ndarray of shape (6,) and dtype complex128 as dq, not an array of 6 numbers"),
    ],
)
def test_what_is_wrong_with_a_reading_is_named(spoil: Spoil, wrong: str) -> None:
    judged = check_of().judge(spoil(at()), NOW_NS)
    assert judged == RobotFault(FaultCode.DRIVER, f"the driver's read returned {wrong}; correct the driver")


@pytest.mark.parametrize("rate_hz", [15.0, 1000.0])
def test_a_reading_ages_from_its_own_stamp_and_a_slow_robots_later(rate_hz: float) -> None:
    check = check_of(rate_hz)
    assert check.oldest_ns == pytest.approx(max(4e9 / rate_hz, 1e8), abs=1)
    ages = [ms for ms in range(0, 400, 2) if code_of(check.judge(at(), NOW_NS + ms * NS_PER_MS)) is FaultCode.SILENT]
    assert ages[:1] == [int(check.oldest_ns / NS_PER_MS) // 2 * 2 + 2]
    assert code_of(check.judge(at(NOW_NS + 500 * NS_PER_MS), NOW_NS + 501 * NS_PER_MS)) is None


def test_a_pause_of_this_process_ages_no_reading() -> None:
    check = check_of()
    assert code_of(check.judge(at(), NOW_NS)) is None
    assert code_of(check.judge(at(), NOW_NS + 900 * NS_PER_MS)) is None
    assert code_of(check.judge(at(), NOW_NS + 940 * NS_PER_MS)) is None
    assert code_of(check.judge(at(), NOW_NS + 980 * NS_PER_MS)) is None
    assert code_of(check.judge(at(), NOW_NS + 1004 * NS_PER_MS)) is FaultCode.SILENT


@pytest.mark.parametrize("turn_ms", [51, 60, 90, 200])
def test_turns_that_are_always_late_notice_a_frozen_stamp_after_four(turn_ms: int) -> None:
    check, frozen_ns = check_of(), NOW_NS + 50 * turn_ms * NS_PER_MS
    for turn in range(51):
        now_ns = NOW_NS + turn * turn_ms * NS_PER_MS
        assert code_of(check.judge(at(now_ns), now_ns)) is None
    turns = [code_of(check.judge(at(frozen_ns), frozen_ns + k * turn_ms * NS_PER_MS)) for k in range(1, 5)]
    assert turns[-1] is FaultCode.SILENT


def test_a_stamp_of_the_future_is_not_remembered() -> None:
    check = check_of()
    assert code_of(check.judge(at(NOW_NS + 10**18), NOW_NS)) is FaultCode.IMPLAUSIBLE
    assert code_of(check.judge(at(NOW_NS), NOW_NS)) is None


def test_an_arm_may_stand_a_little_outside_its_own_range_however_narrow_the_configured_one_is() -> None:
    q = START.copy()
    q[0] = LIMITS.upper[0] + 1.0 + BEYOND_RAD
    assert code_of(check_of().judge(at(q=q), NOW_NS)) is FaultCode.IMPLAUSIBLE
    check = check_of(setup=replace(SETUP, own_range=WIDER))
    assert code_of(check.judge(at(q=q), NOW_NS)) is None
    q[0] += 0.001
    assert code_of(check.judge(at(q=q), NOW_NS)) is FaultCode.IMPLAUSIBLE


def test_a_robots_own_fault_is_kept_with_a_bad_reading() -> None:
    pressed = RobotFault(FaultCode.EMERGENCY_STOP, "pressed")
    assert check_of().judge(at(q=START * np.nan, fault=pressed), NOW_NS) is pressed
    assert code_of(check_of().judge(at(q=START * np.nan, fault=STOPPED), NOW_NS)) is FaultCode.NOT_FINITE


def test_what_the_driver_does_to_its_arrays_later_changes_nothing() -> None:
    q = START.copy()
    judged = check_of().judge(at(q=q), NOW_NS)
    q[:] = np.nan
    assert isinstance(judged, RobotReading)
    assert np.array_equal(judged.q, START)


def test_numbers_of_numpy_are_numbers() -> None:
    reading = RobotReading(
        np.int64(NOW_NS),  # type: ignore[arg-type]  # as an untyped driver may
        START.astype(np.float32),
        np.zeros(6, dtype=int),
        GripperReading(np.float32(0.04), np.int32(3)),  # type: ignore[arg-type]  # as an untyped driver may
        None,
        np.uint8(3),  # type: ignore[arg-type]  # as an untyped driver may
    )
    judged = check_of().judge(reading, NOW_NS)
    assert isinstance(judged, RobotReading)
    assert (type(judged.t_ns), judged.q.dtype, judged.dq.dtype) == (int, np.dtype(float), np.dtype(float))


@pytest.mark.parametrize("t_ns", [10**400, -(10**400), True, 1.0, None, "x"])
@pytest.mark.parametrize("opening", [10**400, -(10**400), False, None, "x", float("-inf")])
@pytest.mark.parametrize("q", [np.full(6, np.inf), np.array(["a"] * 6), np.zeros((6, 1)), START.tolist(), None])
def test_nothing_that_is_returned_raises(t_ns: object, opening: object, q: object) -> None:
    fields = {"q": q, "t_ns": t_ns, "gripper": GripperReading(opening, None)}  # type: ignore[arg-type]  # as above
    for name, value in fields.items():
        judged = check_of().judge(replace(at(), **{name: value}), NOW_NS)  # type: ignore[arg-type]  # as above
        assert isinstance(judged, RobotFault)
        assert len(judged.sentence) < 200
    assert code_of(check_of().judge(SimpleNamespace(**fields), NOW_NS)) is FaultCode.DRIVER


@pytest.mark.parametrize(
    ("spoil", "sentence"),
    [
        (gripper(50.8), "by its reading the gripper's opening is 50.8, outside -0.01 to 1 m; check the robot's"),
        (gripper(0.05, -1e4), "by its reading the grip force is -1e+04, outside -2000 to 2000 N; check the robot's"),
        (joint(7.0), f"by its reading joint_3 is 7, outside {LOWER[2]:.4g} to {UPPER[2]:.4g} rad; check the robot's"),
        (later(30.0), "the time of the reading is 30 ms in the future; correct the driver's clock"),
        (later(-30.0), "the time of the reading is 30 ms before the last one's; correct the driver's clock"),
        (field("t_ns", 1), "the time of the reading is 5000 ms before the last one's; correct the driver's clock"),
        (field("t_ns", 0), "the time of the reading is not set; correct the driver's clock"),
        (field("t_ns", 10**400), "the time of the reading is years in the future; correct the driver's clock"),
    ],
)
def test_an_implausible_reading_is_named_with_its_figures(spoil: Spoil, sentence: str) -> None:
    check = check_of()
    check.judge(at(), NOW_NS)
    judged = check.judge(spoil(at()), NOW_NS)
    assert isinstance(judged, RobotFault)
    assert judged.sentence.startswith(sentence)


def test_a_reading_that_is_too_old_is_named_with_its_age_and_the_limit() -> None:
    check = check_of()
    for ms in (0, 40, 80, 104):
        judged = check.judge(at(), NOW_NS + ms * NS_PER_MS)
    assert isinstance(judged, RobotFault)
    assert judged.sentence == "the robot was last measured 104 ms ago (limit 100 ms); check the link to it"
