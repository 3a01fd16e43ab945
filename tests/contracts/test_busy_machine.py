"""The conformance suite on a machine that stands still: nothing is held against a driver that is not slow itself."""

import pytest

from remote_site.drivers.conformance.checks import CHECKS
from remote_site.drivers.conformance.suite import run_checks, verdicts_of
from remote_site.drivers.conformance.verdicts import ATTEMPTS, Verdict
from remote_site.drivers.kinematic import KinematicDriver
from tests.contracts.bad_drivers import Mirrored
from tests.contracts.busy_machine import BusyMachine, Interrupted, busy_stand

EVER = 10**6


def only(name):
    return [check for check in CHECKS if check.__name__ == name]


class Slow(Interrupted):
    """Takes 60 ms for that call itself."""

    own_ms = 60.0


class Brisk(Interrupted):
    """Takes 45 ms for that call itself, which is allowed."""

    own_ms = 45.0


class Raising(KinematicDriver):
    """Fails in a way that has nothing to do with time."""

    def stop(self):
        raise KeyError("stop")


@pytest.mark.slow
@pytest.mark.parametrize("check", ["stamps", "follows", "stop", "deadline"])
def test_a_check_that_the_machine_has_spoilt_is_repeated(check):
    machine, lines = BusyMachine(pauses=1), list[str]()
    assert run_checks(busy_stand(machine), lines.append, only(check)) == [], lines
    assert machine.trials == 2
    assert lines[0].startswith("passed")


def test_a_machine_that_stands_still_each_time_decides_nothing_and_is_named():
    machine, lines = BusyMachine(pauses=EVER), list[str]()
    assert verdicts_of(busy_stand(machine), lines.append, only("follows")) == {"follows": Verdict.REPEAT}
    assert machine.trials == ATTEMPTS
    assert lines[0].split(maxsplit=2)[:2] == ["repeat", "follows"]
    assert "this machine stood still for 60 ms in the last of 3 attempts; repeat when it does less" in lines[0]
    assert "took" not in lines[0]  # nothing against the driver


def test_what_has_to_be_repeated_has_not_passed():
    assert run_checks(busy_stand(BusyMachine(pauses=EVER)), print, only("stamps")) == ["stamps"]


def test_a_call_that_is_late_by_the_machine_alone_is_not_the_drivers_however_short_the_pause():
    machine, lines = BusyMachine(pauses=EVER, pause_ms=8.0), list[str]()
    assert verdicts_of(busy_stand(machine, Brisk), lines.append, only("deadline")) == {"deadline": Verdict.REPEAT}
    assert "stood still for 8 ms" in lines[0]


def test_a_machine_that_stands_still_between_two_calls_is_not_the_driver_either():
    machine, lines = BusyMachine(pauses=20, pause_ms=55.0, sleeps=20), list[str]()
    stand = busy_stand(machine, KinematicDriver)
    assert run_checks(stand, lines.append, only("stamps")) == [], lines
    assert machine.trials == 2


def test_a_slow_driver_is_blamed_whatever_the_machine_does():
    machine, lines = BusyMachine(pauses=EVER, pause_ms=30.0), list[str]()
    assert run_checks(busy_stand(machine, Slow), lines.append, only("deadline")) == ["deadline"]
    assert machine.trials == 1
    assert "read took 60 ms, without 30 ms for which this machine stood still (limit 50 ms)" in lines[0]


@pytest.mark.parametrize(("pause_ms", "verdict"), [(5.0, Verdict.FAILED), (60.0, Verdict.REPEAT)])
def test_what_is_wrong_beside_a_pause_is_said_in_any_case(pause_ms, verdict):
    machine, lines = BusyMachine(pauses=EVER, pause_ms=pause_ms, sleeps=50), list[str]()
    assert verdicts_of(busy_stand(machine, Mirrored), lines.append, only("lag")) == {"lag": verdict}
    assert "as with a wrong sign" in lines[0]


def test_no_pause_excuses_what_a_driver_raises():
    machine, lines = BusyMachine(pauses=EVER, pause_ms=20.0, sleeps=50), list[str]()
    assert run_checks(busy_stand(machine, Raising), lines.append, only("idempotent_stop")) == ["idempotent_stop"]
    assert "stop raised KeyError" in lines[0]
