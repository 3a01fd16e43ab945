"""Every driver of the house passes every check of the conformance suite; a bad one fails the check made for it."""

from dataclasses import replace

import pytest

from common.clock import FakeClock
from common.errors import DriverError
from remote_site.drivers.conformance.checks import CHECKS
from remote_site.drivers.conformance.suite import run_checks
from remote_site.drivers.driver import Capabilities
from remote_site.drivers.kinematic import KinematicDriver
from tests.contracts.bad_drivers import (
    AnyRobot,
    Blocked,
    Broken,
    Ceased,
    Deaf,
    Drifter,
    Eager,
    Feeler,
    Freezer,
    Hasty,
    Laggard,
    Liar,
    Mirrored,
    Numb,
    Portless,
    Prophet,
    Quitter,
    Racer,
    Refuser,
    Restarter,
    Skipper,
    Sleepwalker,
    Slow,
    Stuck,
    Thief,
    Unwatched,
    refuse_to_be_made,
)
from tests.contracts.bad_grippers import (
    Clenched,
    Closer,
    Gripping,
    Opener,
    Patient,
    Postponing,
    Releasing,
    Unhurried,
    Welcoming,
)
from tests.contracts.driver_stands import c500c_stand, kinematic_stand, simulated_stand

NAMES = [check.__name__ for check in CHECKS]


@pytest.fixture(autouse=True, scope="module")
def _opened_in_the_end():
    yield
    Blocked.gate.set()


@pytest.mark.parametrize("check", CHECKS, ids=NAMES)
@pytest.mark.parametrize("stand", [kinematic_stand, simulated_stand, c500c_stand])
def test_the_drivers_of_the_house_pass(stand, check):
    lines: list[str] = []
    assert run_checks(stand(), lines.append, [check]) == [], lines


@pytest.mark.long
@pytest.mark.parametrize("stand", [simulated_stand, c500c_stand])
def test_one_robot_passes_all_checks_one_after_the_other(stand):
    lines, same = list[str](), stand()
    assert run_checks(same, lines.append, [*CHECKS, *CHECKS]) == [], lines


@pytest.mark.long
def test_the_a465_passes_with_lost_bytes():
    lines: list[str] = []
    assert run_checks(c500c_stand(loss=0.0005), lines.append) == [], lines


def test_calls_are_timed_by_a_clock_of_their_own_where_the_robots_is_a_simulators():
    calls, lines = FakeClock(), list[str]()

    class Waiting(KinematicDriver):
        """Waits for its robot, whose clock stands still meanwhile."""

        def read(self):
            calls.advance_ms(60)
            return super().read()

    stand = replace(kinematic_stand(Waiting), call_clock=calls)
    (check,) = (each for each in CHECKS if each.__name__ == "deadline")
    assert run_checks(stand, lines.append, [check]) == ["deadline"]
    assert "read took 60 ms (limit 50 ms)" in lines[0]


@pytest.mark.slow
@pytest.mark.parametrize(
    ("bad", "check"),
    [
        (Hasty, "life_cycle"),
        (Broken, "life_cycle"),
        (Deaf, "life_cycle"),
        (AnyRobot, "other_robot"),
        (Prophet, "read_never_invents"),
        (Liar, "read_never_invents"),
        (Feeler, "read_never_invents"),
        (Stuck, "stamps"),
        (Laggard, "lag"),
        (Eager, "follows"),
        (Refuser, "follows"),
        (Racer, "limits"),
        (Drifter, "stop"),
        (Restarter, "idempotent_stop"),
        (Clenched, "gripper"),
        (Sleepwalker, "command_timeout"),
        (Unwatched, "watchdog"),
        (Slow, "deadline"),
        (Blocked, "deadline"),
    ],
)
def test_a_bad_driver_fails_the_check_made_for_it(bad, check):
    lines: list[str] = []
    checks = [c for c in CHECKS if c.__name__ == check]
    assert run_checks(kinematic_stand(bad), lines.append, checks, call_s=1.0) == [check]
    assert lines[0].startswith("FAILED")


@pytest.mark.slow
@pytest.mark.parametrize(
    ("bad", "checks"),
    [
        (Numb, ["read_never_invents"]),
        (Mirrored, ["read_never_invents", "follows", "lag"]),  # all that move the joints that it mirrors
        (Freezer, ["stop"]),
        (Skipper, ["rate"]),
        # what does not keep the gripper
        (Opener, ["keeps_gripper"]),
        (Closer, ["keeps_gripper"]),
        (Releasing, ["keeps_gripper"]),
        (Welcoming, ["keeps_gripper"]),
        # what has its gripper do later what was ordered before
        (Postponing, ["withdraws_gripper"]),
        (Patient, ["withdraws_gripper"]),
    ],
)
def test_a_driver_that_is_bad_in_one_thing_fails_in_nothing_else(bad, checks):
    lines: list[str] = []
    assert run_checks(kinematic_stand(bad), lines.append) == checks, lines
    failed = [line for line in lines if line.startswith("FAILED")]
    assert [line.split()[1] for line in failed] == [check.split("_")[0] for check in checks]


def test_every_check_has_its_bad_driver():
    alone = test_a_bad_driver_fails_the_check_made_for_it.pytestmark[0]
    in_nothing_else = test_a_driver_that_is_bad_in_one_thing_fails_in_nothing_else.pytestmark[0]
    found = {check for _, check in alone.args[1]} | {check for _, checks in in_nothing_else.args[1] for check in checks}
    assert found == set(NAMES)


@pytest.mark.slow
@pytest.mark.parametrize("good", [Gripping, Unhurried])
def test_a_robot_with_a_gripper_passes(good):
    lines: list[str] = []
    assert run_checks(kinematic_stand(good), lines.append) == [], lines


@pytest.mark.slow
@pytest.mark.parametrize(
    ("bad", "sentence"),
    [
        (refuse_to_be_made, "its construction raised TypeError: an argument is missing"),
        (Ceased, "its construction is refused: rate_hz is 0.0"),
        (Portless, "configure is refused: the port is not there; plug it in"),
        (Broken, "configure raised KeyError"),
        (Quitter, "configure raised SystemExit: 3"),
        (Deaf, "not ready after its activation: robot (E7): no"),
        (Blocked, "deadline: write did not return"),
    ],
)
def test_what_no_check_can_do_without_is_said_once(bad, sentence):
    lines: list[str] = []
    assert run_checks(kinematic_stand(bad), lines.append, call_s=1.0) == ["life_cycle"]
    assert len(lines) == 2
    assert sentence in lines[0]


def test_a_call_that_returns_the_wrong_thing_is_named():
    lines: list[str] = []
    run_checks(kinematic_stand(Thief), lines.append, CHECKS[:1])
    assert "the driver's read raised TypeError: it returned None, not a RobotReading" in lines[0]


@pytest.mark.slow
def test_a_watchdog_that_a_driver_has_not_is_skipped():
    lines: list[str] = []
    run_checks(kinematic_stand(), lines.append)
    assert [line.split()[1] for line in lines if line.startswith("skipped")] == [
        "other",
        "gripper",
        "keeps",
        "withdraws",
        "watchdog",
    ]


@pytest.mark.parametrize("rate_hz", [0.0, -1.0, float("nan"), float("inf")])
def test_a_rate_that_no_robot_has_is_refused(rate_hz):
    with pytest.raises(DriverError, match="rate_hz"):
        Capabilities(rate_hz, None, gripper=False, force=False, watchdog_ms=None)
