"""Three methods make a driver that passes every check; an arm that is bad in one thing is found out, by its name."""

import pytest

from common.host_clock import MonotonicClock
from remote_site.drivers.conformance.checks import CHECKS
from remote_site.drivers.conformance.machine_pauses import machine_pauses
from remote_site.drivers.conformance.suite import run_checks, verdicts_of
from remote_site.drivers.conformance.trial import DriverStand
from remote_site.drivers.conformance.verdicts import Verdict
from remote_site.drivers.position_arm.driver import PositionArmDriver
from tests.contracts import position_arms as arms
from tests.contracts.driver_stands import CONFIG, SETUP
from tests.contracts.position_arms import position_stand


@pytest.mark.slow
@pytest.mark.parametrize("arm", [arms.ServoArm, arms.BrakingArm, arms.GripperArm, arms.Stamped, arms.Sparing])
def test_three_methods_pass_every_check(arm):
    lines: list[str] = []
    assert run_checks(position_stand(arm), lines.append) == [], lines


@pytest.mark.slow
@pytest.mark.parametrize("rate_hz", [10.0, 25.0, 50.0, 200.0, 500.0, 1000.0])
def test_they_do_at_any_rate(rate_hz):
    paced, lines = type("Paced", (arms.ServoArm,), {"rate_hz": rate_hz}), list[str]()
    assert run_checks(position_stand(paced), lines.append) == [], lines


@pytest.mark.slow
@pytest.mark.parametrize(
    ("bad", "check", "sentence"),
    [
        (arms.Frozen, "follows", "not_following: joint_6 is 0.18 rad from all that was commanded"),
        (arms.Silent, "life_cycle", "silent: the robot was last measured"),
        (arms.NotANumber, "life_cycle", "not_finite: by its reading joint_3 is not finite"),
        (arms.OneShort, "life_cycle", "OneShort.read returned positions of the shape (5,), 6 positions in rad are"),
        (arms.InDegrees, "life_cycle", "implausible: by its reading joint_3 is -45"),
        (arms.Speechless, "life_cycle", "Speechless.read raised ConnectionError: no answer from 10.0.0.7"),
        (arms.Waiting, "follows", "joint_1 was commanded to"),
        (arms.Unwritable, "follows", "Unwritable.write raised OSError: [Errno 5] lost 6 values"),
        (arms.StampedEarly, "stop", "or stamp its readings with the time of the measurement"),
        (arms.CannotStop, "stop", "CannotStop.stop raised NotImplementedError"),
        (arms.Jumpy, "life_cycle", "the arm still moves; activate it when it rests"),
    ],
)
def test_a_bad_arm_fails_and_the_line_says_why(bad, check, sentence):
    lines: list[str] = []
    made_for_it = [each for each in CHECKS if each.__name__ == check]
    assert run_checks(position_stand(bad), lines.append, made_for_it) == [check]
    assert_said(lines, check, sentence)


@pytest.mark.slow
@pytest.mark.parametrize(
    ("bad", "checks", "sentence"),
    [
        (arms.Late, ["lag"], "declare in lag_ms by how much later it follows"),
        (arms.Gliding, ["stop", "idempotent_stop"], "joint_1 still moves at"),  # neither one stop nor several stop it
        (arms.StopsHard, ["stop"], "let it stop within the acceleration"),
        (arms.StopsNothing, ["stop"], "let it stop within the acceleration"),
    ],
)
def test_an_arm_that_is_bad_in_one_thing_fails_in_nothing_else_and_the_line_says_why(bad, checks, sentence):
    lines: list[str] = []
    assert run_checks(position_stand(bad), lines.append) == checks, lines
    assert_said(lines, checks[0], sentence)


def assert_said(lines, check, sentence):
    (line,) = [line for line in lines if line.startswith(f"FAILED  {check.replace('_', ' ')} ")]
    assert sentence in line


@pytest.mark.long
@pytest.mark.parametrize("check", ["life_cycle", "follows", "lag", "stop", "command_timeout"])
def test_an_arm_that_waits_passes_with_a_thread(check):
    class Threaded(arms.Waiting):
        rate_hz, lag_ms, threaded = 40.0, 100.0, True

    clock, lines = MonotonicClock(), list[str]()
    arm = Threaded(clock)
    make = lambda: PositionArmDriver(arm, clock)  # noqa: E731  # one robot for all attempts
    stand = DriverStand(clock, SETUP, make, CONFIG.robot.start, machine_pauses)
    verdicts = verdicts_of(stand, lines.append, [each for each in CHECKS if each.__name__ == check])
    assert verdicts[check] in (Verdict.PASSED, Verdict.REPEAT), lines  # a busy machine judges nothing
