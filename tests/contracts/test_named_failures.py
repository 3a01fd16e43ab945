"""A failing check names the call or the joint, what was expected and what came, and a slow call only once."""

import pytest

from remote_site.drivers.conformance.checks import CHECKS
from remote_site.drivers.conformance.suite import run_checks
from tests.contracts.bad_drivers import (
    AnyRobot,
    Displaced,
    Drifter,
    Eager,
    Feeler,
    Freezer,
    Hiccup,
    Laggard,
    Liar,
    Mirrored,
    Numb,
    Racer,
    Refuser,
    Skipper,
    Slow,
    SlowFreezer,
    SlowToStop,
    SlowTwice,
    UnlikeInSign,
)
from tests.contracts.driver_stands import kinematic_stand


def lines_of(bad, checks=CHECKS):
    lines: list[str] = []
    failed = run_checks(kinematic_stand(bad), lines.append, checks)
    return failed, lines


def only(*names):
    return [check for check in CHECKS if check.__name__ in names]


@pytest.mark.slow
@pytest.mark.parametrize(
    ("bad", "where", "sentence"),
    [
        (Slow, "life_cycle", "read took 60 ms (limit 50 ms)"),
        (SlowToStop, "limits", "stop took 80 ms (limit 50 ms)"),
        (Hiccup, "read_never_invents", "write took 70 ms (limit 50 ms)"),
    ],
)
def test_a_slow_call_is_reported_once(bad, where, sentence):
    failed, lines = lines_of(bad)
    assert failed == [where]
    suffering = [line for line in lines if line.startswith("suffers")]
    assert len(suffering) >= 2
    assert all(line.endswith(f"{sentence}, see {where.replace('_', ' ')}") for line in suffering), suffering
    assert next(line for line in lines if line.startswith("FAILED")).count(sentence) == 1


def test_two_slow_calls_are_both_reported():
    failed, lines = lines_of(SlowTwice)
    assert failed == ["life_cycle"]
    assert "write took 55 ms (limit 50 ms), read took 60 ms (limit 50 ms)" in lines[0]


@pytest.mark.slow
def test_what_else_is_wrong_is_said_beside_a_slow_call():
    _, lines = lines_of(SlowFreezer)
    stop = next(line for line in lines if line.split()[1:3] == ["stop", "stop"])
    assert stop.startswith("suffers stop")
    assert "see limits; found: joint_1 stopped within 0.000 rad where its limits need" in stop


@pytest.mark.slow
@pytest.mark.parametrize(
    ("bad", "check", "sentence"),
    [
        (Mirrored, "follows", "joint_2 went from 0.000 to -0.1"),
        (Mirrored, "follows", "rad where it was commanded to 0.100 rad, as with a wrong sign; so did joint_4, joint_6"),
        (Mirrored, "lag", "as with a wrong sign; so did joint_4, joint_6"),
        (UnlikeInSign, "life_cycle", "activate and read differ in the sign of joint_3; not ready after its activation"),
        (UnlikeInSign, "life_cycle", "joint_3 is at 0.785 rad, not -0.785 rad"),
        (
            Displaced,
            "life_cycle",
            "it was activated where it was read, at joint_1 0.000, joint_2 0.000, joint_3",
        ),
        (Displaced, "life_cycle", "does activate send each joint with the sign, zero and unit of read?"),
        (
            Laggard,
            "lag",
            "joint_1 is 0.04 rad from all that was commanded in the last 52 ms, its longest lag: it is",
        ),
        (
            Eager,
            "follows",
            "joint_5 was commanded to -0.610 rad and went as far as -0.553 rad, at most 0.01 rad",
        ),
        (Liar, "read_never_invents", "joint_3 is read at 0.000 rad, it is expected within 0.5 rad of -0.785 rad"),
        (Feeler, "read_never_invents", "it reads an opening of 50.0 mm as its gripper, but declares gripper=False"),
        (Numb, "read_never_invents", "joint_1 went 0.350 rad, but its speeds add up to 0.000 rad"),
        (Drifter, "stop", "joint_1 still moves at 0.800 rad/s after a stop, at most 0.01 rad/s is expected"),
        (Freezer, "stop", "joint_1 stopped within 0.000 rad where its limits need 0.0"),
        (Skipper, "rate", "in motion joint_1 pauses for 40 ms at a time, at most 12 ms is expected"),
        (AnyRobot, "other_robot", "a model with 7 joints, where it declares 6, raised nothing, where a DriverError is"),
        (Racer, "limits", "joint_1 is 0.14 rad from all that was commanded"),
    ],
)
def test_a_failure_names_the_joint_and_what_was_expected_and_came(bad, check, sentence):
    failed, lines = lines_of(bad, only(check))
    assert failed == [check]
    assert sentence in lines[0]


@pytest.mark.slow
@pytest.mark.parametrize("bad", [Laggard, Eager, Racer, Refuser, Drifter])
def test_a_joint_that_goes_the_right_way_is_not_suspected_of_a_wrong_sign(bad):
    failed, lines = lines_of(bad, only("follows", "lag", "stop"))
    assert failed
    assert not [line for line in lines if "sign" in line]
