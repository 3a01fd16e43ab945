"""What the driver of a position arm does by itself: stamps, activation, time-out, stops, and the gripper."""

import math

import numpy as np
import pytest

from common.clock import NS_PER_MS, NS_PER_S
from common.errors import DriverError
from common.messages.robot import GripperCommand
from remote_site.drivers.driver import RESTING_RAD_S
from remote_site.drivers.faults import NOT_ACTIVATED, STOPPED, FaultCode
from remote_site.drivers.position_arm.arm import MeasuredPositions
from remote_site.drivers.position_arm.calls import ArmCallError
from remote_site.drivers.position_arm.driver import PositionArmDriver
from remote_site.kinematics.joints import JointMotion
from remote_site.safety.stopping import stop_time, stops
from tests.contracts.driver_stands import SETUP
from tests.contracts.position_arms import BrakingArm, Gliding, GripperArm, ServoArm, Sparing, Stamped
from tests.present import present
from tests.remote_site.drivers.position_arm.driven_arm import START, DrivenArm

OPEN, CLOSED = GripperCommand.OPEN, GripperCommand.CLOSED


def test_a_reading_has_the_time_before_it_was_asked_for():
    class Slow(ServoArm):
        def read(self):
            self.asked_ns = driven.clock.now_ns()
            driven.clock.advance_ms(7)
            return super().read()

    driven = DrivenArm(Slow)
    assert present(driven.turns(200)).t_ns == driven.arm.asked_ns


@pytest.mark.parametrize("rate_hz", [50.0, 70.0])
def test_it_is_read_at_its_rate_and_not_in_every_turn(rate_hz):
    driven = DrivenArm(rate_hz=rate_hz)
    driven.turns(1000)
    assert driven.arm.calls.count("read") == pytest.approx(rate_hz, abs=1)


@pytest.mark.parametrize("kind", [Stamped, Sparing])
def test_what_is_not_new_keeps_its_stamp(kind):
    driven = DrivenArm(kind, rate_hz=500.0)
    driven.turns(200)
    stamps = {driven.reading().t_ns for _ in range(100)}
    assert len(stamps) in (10, 11)  # one for each 20 ms, in which it is asked ten times


def test_an_arm_that_has_nothing_new_grows_old():
    driven = DrivenArm()
    t_ns = present(driven.turns(200)).t_ns
    driven.arm.read = lambda: None
    assert present(driven.turns(300)).t_ns == t_ns


def test_a_time_before_the_last_one_is_refused():
    driven = DrivenArm()
    last = present(driven.turns(200))
    driven.arm.read = lambda: MeasuredPositions(START, last.t_ns - 5 * NS_PER_MS)
    driven.clock.advance_ms(20)
    with pytest.raises(DriverError, match="5 ms before the last ones"):
        driven.driver.read()


def test_a_time_that_lies_ahead_is_refused_alone_and_bars_no_later_one():
    driven = DrivenArm()
    driven.turns(200)
    read, driven.arm.read = driven.arm.read, lambda: MeasuredPositions(START, driven.clock.now_ns() + 10 * NS_PER_S)
    driven.clock.advance_ms(20)
    with pytest.raises(DriverError, match="10000 ms in the future; stamp them by the clock of the DriverHost"):
        driven.driver.read()
    driven.arm.read = read
    driven.clock.advance_ms(20)
    assert driven.driver.read().t_ns == driven.clock.now_ns()


def test_the_arm_may_go_on_writing_to_what_it_has_returned():
    driven = DrivenArm()
    buffer = START.copy()
    driven.arm.read = lambda: buffer
    reading = present(driven.turns(200))
    buffer[:] = 9.0
    assert (reading.q == START).all()


def test_a_failure_is_raised_until_the_arm_is_read_again():
    driven = DrivenArm()
    good, driven.arm.read = driven.arm.read, lambda: [0.0] * 5
    driven.clock.advance_ms(10)
    for _ in range(3):  # also in the turns in which the arm is not asked
        with pytest.raises(ArmCallError, match=r"ServoArm\.read returned positions of the shape \(5,\), 6 positions"):
            driven.reading()
    driven.arm.read = good
    assert present(driven.turns(200)).q == pytest.approx(START)


@pytest.mark.parametrize("given", ["home", ["home"] * 6, {"a": 1.0}, 3.0, [[0.0] * 6]])
def test_what_no_positions_are_is_named(given):
    driven = DrivenArm()
    driven.arm.read = lambda: given
    with pytest.raises(ArmCallError, match=r"ServoArm\.read returned .*6 positions in rad are expected"):
        driven.reading()


def test_an_angle_that_is_not_finite_is_handed_on_and_spoils_no_speed_after_it():
    driven = DrivenArm()
    driven.turns(200)
    good, driven.arm.read = driven.arm.read, lambda: np.where(np.arange(6) == 2, math.nan, START)
    assert np.isnan(present(driven.turns(20)).q[2])
    driven.arm.read = good
    assert not present(driven.turns(10)).moving


def test_nothing_is_written_by_an_activation_nor_before_one():
    driven = DrivenArm().active()
    driven.turns(100)
    assert set(driven.arm.calls) == {"read"}
    assert driven.reading().fault is None


def test_it_is_not_activated_while_it_moves():
    driven = DrivenArm()
    driven.turns(200)
    driven.arm.goal = START + 0.2
    driven.turns(20)
    with pytest.raises(DriverError, match="still moves"):
        driven.driver.activate(driven.reading().q)
    assert driven.reading().fault is NOT_ACTIVATED


@pytest.mark.parametrize("q0", [START + 0.03, START * math.nan])
def test_it_is_not_activated_elsewhere(q0):
    driven = DrivenArm()
    driven.turns(200)
    with pytest.raises(DriverError, match="not where it was activated"):
        driven.driver.activate(q0)
    with pytest.raises(DriverError, match="activate the arm"):
        driven.command(0.0)
    assert set(driven.arm.calls) == {"read"}


def test_it_is_not_activated_before_its_speeds_are_known():
    driven = DrivenArm()
    driven.turns(90)
    with pytest.raises(DriverError, match="not been measured for 100 ms yet"):
        driven.driver.activate(START)


def test_an_arm_that_is_no_longer_commanded_is_stopped():
    driven = DrivenArm(BrakingArm).active().at_speed()
    driven.turns(180)
    assert driven.reading().fault is None
    driven.turns(20)
    assert present(driven.reading().fault).code is FaultCode.COMMAND_TIMEOUT
    assert driven.arm.calls.count("stop") == 1
    with pytest.raises(DriverError, match="activate the arm"):
        driven.command(0.0)


def test_a_pause_of_the_process_itself_is_no_silence_of_control():
    driven = DrivenArm(BrakingArm).active().at_speed()
    driven.clock.advance_ms(1000)
    assert driven.reading().fault is None


@pytest.mark.parametrize("turn_ms", [101, 150, 300])
def test_a_process_that_is_always_late_notices_that_control_has_ceased_after_four_turns(turn_ms):
    driven = DrivenArm(BrakingArm).active().at_speed()
    for _ in range(5):
        driven.clock.advance_ms(turn_ms)
        fault = driven.driver.read().fault
    assert present(fault).code is FaultCode.COMMAND_TIMEOUT


def test_an_arm_that_brakes_by_itself_is_stopped_at_every_call_and_at_once():
    driven = DrivenArm(BrakingArm).active().at_speed()
    for _ in range(3):
        driven.driver.stop()
    assert driven.arm.calls[-3:] == ["stop"] * 3
    assert present(driven.turns(500)).fault is STOPPED


def test_a_stop_that_fails_is_repeated_until_it_succeeds():
    driven = DrivenArm(BrakingArm).active()
    driven.command(0.0)
    good, driven.arm.stop = driven.arm.stop, lambda: 1 / 0
    with pytest.raises(ArmCallError, match=r"BrakingArm\.stop raised ZeroDivisionError"):
        driven.driver.stop()
    with pytest.raises(DriverError, match="not been stopped yet"):
        driven.driver.activate(driven.arm.q)
    driven.clock.advance_ms(10)
    for _ in range(3):
        with pytest.raises(ArmCallError, match=r"BrakingArm\.stop raised"):
            driven.reading()
    driven.arm.stop = good
    assert not present(driven.turns(500)).moving
    assert driven.arm.calls.count("stop") == 1


def written_during(driven, ms):
    """Positions of the first joint that were written meanwhile, with their times in s."""
    found, good = [], driven.arm.write
    driven.arm.write = lambda q: (found.append((driven.clock.now_ns() / 1e9, q[0])), good(q))
    driven.turns(ms)
    return np.array(found).T


def test_a_stop_is_written_within_the_limits_then_the_arm_holds():
    driven = DrivenArm().active().at_speed()
    at, sent = driven.arm.goal[0], JointMotion(driven.arm.goal, 0.8 * np.eye(6)[0], np.zeros(6))
    driven.driver.stop()
    assert "stop" not in driven.arm.calls
    driven.driver.stop()  # changes nothing
    t_s, q = written_during(driven, 1000)
    (expected, *_) = stops(sent, SETUP.limits)
    assert q[-1] == pytest.approx(expected.end, abs=1e-9)
    assert np.diff(q, prepend=at).max() <= 0.8 * 0.012
    assert np.diff(q).min() >= 0
    assert t_s[-1] - t_s[0] > stop_time(sent, SETUP.limits)
    assert driven.arm.calls.count("stop") == 1
    assert driven.arm.calls[-1] == "read"
    assert driven.reading().fault is STOPPED


def test_it_is_not_activated_while_its_stop_is_written():
    driven = DrivenArm().active().at_speed()
    driven.driver.stop()
    driven.turns(40)
    with pytest.raises(DriverError, match="still moves"):
        driven.driver.activate(driven.reading().q)
    driven.turns(1000)
    driven.driver.activate(driven.reading().q)
    assert driven.reading().fault is None


def test_it_is_not_activated_while_its_stop_is_written_although_it_is_too_slow_to_be_read_moving():
    driven = DrivenArm().active().at_speed(0.015)
    driven.driver.stop()
    reading = driven.reading()
    assert not reading.moving
    with pytest.raises(DriverError, match="still moves"):
        driven.driver.activate(reading.q)


def test_a_stop_begins_where_the_arm_was_sent_however_long_ago():
    driven = DrivenArm().active().at_speed()
    at = driven.arm.goal[0]
    driven.turns(50)
    driven.driver.stop()
    _, q = np.array(written_during(driven, 500)).reshape(2, -1)
    steps = np.diff([at, *q])
    assert steps[0] == pytest.approx(0.8 * 0.01, rel=0.1)
    assert (np.diff(steps) <= 1e-9).all()
    assert q[-1] - at == pytest.approx(stops(MOTION, SETUP.limits)[0].end - MOTION.q[0], rel=0.01)


def test_an_arm_that_has_long_stood_where_it_was_sent_is_stopped_there():
    driven = DrivenArm().active().at_speed()
    at = driven.arm.goal[0]
    driven.turns(90)
    driven.driver.stop()
    assert written_during(driven, 500).size == 0
    assert driven.arm.goal[0] == pytest.approx(at, abs=0.02)
    assert driven.arm.calls.count("stop") == 1


def test_a_written_stop_that_pauses_does_not_jump_to_its_end():
    driven = DrivenArm().active().at_speed(2.0)
    at = driven.arm.goal[0]
    driven.driver.stop()
    driven.clock.advance_ms(400)
    _, q = np.array(written_during(driven, 500)).reshape(2, -1)
    assert len(q) == 0
    assert driven.arm.goal[0] == pytest.approx(at, abs=1e-6)
    assert driven.arm.calls.count("stop") == 1


def test_an_arm_that_cannot_be_written_its_stop_is_stopped_at_once():
    driven = DrivenArm().active().at_speed()
    driven.arm.write = lambda _: 1 / 0
    driven.driver.stop()
    driven.clock.advance_ms(10)
    with pytest.raises(ArmCallError, match=r"ServoArm\.write raised ZeroDivisionError"):
        driven.driver.read()
    assert driven.arm.calls[-1] == "stop"


def test_in_the_end_it_is_stopped_and_closed_once_and_called_no_more():
    driven = DrivenArm().active()
    driven.driver.deactivate()
    driven.driver.deactivate()
    driven.driver.stop()
    driven.turns(100)
    assert driven.arm.calls[-2:] == ["stop", "close"]


def test_an_arm_whose_stop_fails_is_closed_all_the_same():
    driven = DrivenArm().active()
    driven.arm.stop = lambda: 1 / 0
    with pytest.raises(ArmCallError, match="stop"):
        driven.driver.deactivate()
    assert driven.arm.calls[-1] == "close"


def test_an_arm_that_was_never_configured_is_not_called():
    driven = DrivenArm()
    driver = PositionArmDriver(driven.arm, driven.clock)
    driver.stop()
    for call in (driver.read, lambda: driver.activate(START)):
        with pytest.raises(DriverError, match="configure"):
            call()
    assert driven.arm.calls == []


MOTION = JointMotion(START, 0.8 * np.eye(6)[0], np.zeros(6))


def grips(driven):
    return [call for call in driven.arm.calls if call in ("open", "close_gripper")]


def test_the_gripper_moves_when_the_command_changes_and_never_else():
    driven = DrivenArm(GripperArm).active()
    for _ in range(5):
        driven.command(0.0)
    assert grips(driven) == []
    for command in (OPEN, OPEN, CLOSED, CLOSED, OPEN):
        driven.command(0.0, gripper=command)
    assert grips(driven) == ["open", "close_gripper", "open"]
    driven.driver.stop()
    driven.turns(1000)
    driven.active()
    driven.command(0.0)
    assert len(grips(driven)) == 3
    driven.command(0.0, gripper=OPEN)  # somebody may have closed it meanwhile
    assert grips(driven)[3:] == ["open"]
    assert driven.arm.most_n == SETUP.grip_force_n


def test_the_stop_that_is_written_leaves_the_gripper_alone():
    driven = DrivenArm(GripperArm).active().at_speed()
    driven.command(0.24, 0.8, OPEN)
    driven.driver.stop()
    driven.turns(1000)
    assert grips(driven) == ["open"]


@pytest.mark.parametrize(("write_ms", "expected"), [(900.0, ["open"]), (1100.0, [])])
def test_an_order_that_a_write_keeps_for_longer_than_a_second_is_never_done(write_ms, expected):
    driven = DrivenArm(GripperArm).active()
    at_once = driven.arm.write
    driven.arm.write = lambda positions: (driven.clock.advance_ms(write_ms), at_once(positions))
    driven.command(0.0, gripper=OPEN)
    driven.arm.write = at_once
    driven.command(0.0, gripper=OPEN)
    assert grips(driven) == expected


def test_the_opening_is_read_and_none_where_it_cannot_be():
    driven = DrivenArm(GripperArm)
    assert present(present(driven.turns(200)).gripper).opening_m == pytest.approx(0.04)
    driven.arm.gripper_opening_m = lambda: None
    assert present(driven.turns(20)).gripper is None


@pytest.mark.parametrize(
    ("attributes", "sentence"),
    [
        ({"joints": 0}, "ServoArm.joints is 0"),
        ({"joints": 6.0}, "ServoArm.joints is 6.0"),
        ({"rate_hz": 0.0}, "rate_hz is 0.0"),
        ({"lag_ms": -1.0}, "lag_ms is -1.0"),
        ({"speed_over_ms": 0.0}, "speed_over_ms is 0.0"),
        ({"speed_over_ms": math.nan}, "speed_over_ms is nan"),
        ({"speed_over_ms": 600.0}, "speed_over_ms is 600.0"),
    ],
)
def test_attributes_that_no_arm_has_are_refused(attributes, sentence):
    with pytest.raises(DriverError, match=sentence):
        DrivenArm(**attributes)


def test_a_gliding_arm_reads_as_moving():
    driven = DrivenArm(Gliding).active().at_speed(0.1)
    assert np.abs(present(driven.turns(400)).dq[0]) > RESTING_RAD_S


def test_a_driver_claims_no_more_than_an_arm_of_positions_has() -> None:
    declared = DrivenArm().driver.capabilities
    assert (declared.force, declared.gripper, declared.watchdog_ms, declared.holds) == (False, False, None, True)
