"""Runs the checks one after the other, each to its end, whatever the driver does, and reports a line for each."""

import threading
from collections.abc import Callable, Sequence
from dataclasses import dataclass
from enum import Enum

from common.clock import NS_PER_S, MonotonicClock
from common.errors import DriverError
from remote_site.drivers.conformance.checks import CHECKS, Check
from remote_site.drivers.conformance.driver_under_test import CallMonitor
from remote_site.drivers.conformance.trial import DriverStand, Failed, Hopeless, Skipped, Trial, as_sentence

CALL_S = 5.0  # of a call that has 50 ms: it will not return
CHECK_S = 180.0
LOOK_S = 0.1


class Verdict(Enum):
    """The outcome of a check."""

    PASSED = "passed"
    SKIPPED = "skipped"
    FAILED = "FAILED"


@dataclass(frozen=True, slots=True)
class CheckResult:
    """A check's verdict on a driver, and why; after the `last` no other check can run."""

    verdict: Verdict
    sentence: str
    last: bool = False


def run_checks(
    stand: DriverStand, report: Callable[[str], None], checks: Sequence[Check] = CHECKS, call_s: float = CALL_S
) -> list[str]:
    """Run every check and report a line for each; the names of those that failed. A call is given up after `call_s`."""
    failed: list[str] = []
    for check in checks:
        result = _result(check, stand, call_s)
        report(f"{result.verdict.value:<8}{check.__name__.replace('_', ' '):<20} {result.sentence}")
        if result.verdict is Verdict.FAILED:
            failed.append(check.__name__)
        if result.last:
            report("No other check can run before this is fixed.")
            break
    return failed


def _result(check: Check, stand: DriverStand, call_s: float) -> CheckResult:
    """The result of a thread, which is abandoned when a call of the driver does not return."""
    monitor, clock = CallMonitor(), MonotonicClock()
    results: list[CheckResult] = []
    worker = threading.Thread(target=lambda: results.append(_tried(check, stand, monitor)), name="check", daemon=True)
    end_ns = clock.now_ns() + round(CHECK_S * NS_PER_S)
    worker.start()
    while worker.is_alive():
        worker.join(LOOK_S)
        call, late = monitor.stuck(call_s), clock.now_ns() > end_ns
        if call or late:
            monitor.give_up()
            why = f"deadline: {call} did not return" if call else f"it did not end within {CHECK_S:g} s"
            return CheckResult(Verdict.FAILED, why, last=True)
    return results[0]


def _tried(check: Check, stand: DriverStand, monitor: CallMonitor) -> CheckResult:
    try:
        trial = Trial(stand, monitor)
    except (Exception, SystemExit) as error:  # an installed driver may raise anything
        return CheckResult(Verdict.FAILED, as_sentence(monitor.raised or "its construction", error), last=True)
    try:
        check(trial)
    except Skipped as skipped:
        return CheckResult(Verdict.SKIPPED, str(skipped))
    except (Failed, DriverError) as error:
        return CheckResult(Verdict.FAILED, str(error), last=isinstance(error, Hopeless))
    except (Exception, SystemExit) as error:
        return CheckResult(Verdict.FAILED, as_sentence(monitor.raised or "a check that used what it returned", error))
    finally:
        _end(trial)
    return CheckResult(Verdict.PASSED, (check.__doc__ or "").strip())


def _end(trial: Trial) -> None:
    """Leave the robot at rest for the next check."""
    try:
        trial.driver.stop()
        trial.run(700)
        trial.driver.deactivate()
        trial.run(100)
    except (Exception, SystemExit):  # noqa: S110  # the check has reported what is wrong
        pass
