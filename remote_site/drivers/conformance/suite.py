"""Runs the checks one after the other, each to its end, whatever the driver does, and reports a line for each."""

import threading
from collections.abc import Callable, Sequence

from common.clock import NS_PER_S
from common.errors import DriverError, InterruptionError
from common.host_clock import MonotonicClock
from remote_site.drivers.conformance.call_watch import CallWatch
from remote_site.drivers.conformance.checks import CHECKS, Check
from remote_site.drivers.conformance.driver_under_test import CallMonitor
from remote_site.drivers.conformance.trial import (
    DriverStand,
    Failed,
    Hopeless,
    Interrupted,
    Skipped,
    TooSlow,
    Trial,
    as_sentence,
)
from remote_site.drivers.conformance.verdicts import ATTEMPTS, Attempt, CheckResult, Verdict, judge
from remote_site.drivers.faults import FaultCode

CALL_S = 5.0  # of a call that has 50 ms: it will not return
CHECK_S = 180.0
LOOK_S = 0.1


def run_checks(
    stand: DriverStand, report: Callable[[str], None], checks: Sequence[Check] = CHECKS, call_s: float = CALL_S
) -> list[str]:
    """Run every check and report a line for each; the names of those that failed or have to be repeated.

    A call is given up after `call_s`.
    """
    verdicts = verdicts_of(stand, report, checks, call_s)
    return [name for name, verdict in verdicts.items() if verdict in (Verdict.FAILED, Verdict.REPEAT)]


def verdicts_of(
    stand: DriverStand, report: Callable[[str], None], checks: Sequence[Check] = CHECKS, call_s: float = CALL_S
) -> dict[str, Verdict]:
    """Run every check and report a line for each; the verdicts by the checks' names.

    InterruptionError, once the robot rests, when a person wants the end.
    """
    verdicts: dict[str, Verdict] = {}
    reported: dict[str, str] = {}  # the check in which a slow call was reported, by the call's name
    for check in checks:
        result = _repeated(check, stand, call_s, reported)
        if stand.should_stop():
            raise InterruptionError(f"interrupted; {_left(result)}")
        report(f"{result.verdict.value:<8}{check.__name__.replace('_', ' '):<20} {result.sentence}")
        verdicts[check.__name__] = result.verdict
        if result.last:
            report("No other check can run before this is fixed.")
            break
    return verdicts


def _left(result: CheckResult) -> str:
    """Say how an interrupted check has left the robot."""
    if result.last:
        return f"{result.sentence}: if the robot moves, use the emergency stop"
    return "the robot was stopped and let go of"


def _repeated(check: Check, stand: DriverStand, call_s: float, reported: dict[str, str]) -> CheckResult:
    """The verdict on a check, repeated while the machine's pauses leave it open."""
    for _ in range(ATTEMPTS):
        attempt = _watched(check, stand, call_s)
        result = judge(attempt, reported)
        if result.verdict is not Verdict.REPEAT or stand.should_stop():
            break
    if result.verdict is Verdict.FAILED:
        reported |= {call.name: check.__name__ for call in attempt.slow}
    return result


def _watched(check: Check, stand: DriverStand, call_s: float) -> Attempt:
    """The attempt of a thread, which is abandoned when a call of the driver does not return."""
    monitor, clock = CallMonitor(), MonotonicClock()
    attempts: list[Attempt] = []
    worker = threading.Thread(target=lambda: attempts.append(_tried(check, stand, monitor)), name="check", daemon=True)
    end_ns = clock.now_ns() + round(CHECK_S * NS_PER_S)
    worker.start()
    while worker.is_alive():
        worker.join(LOOK_S)
        call, late = monitor.stuck(call_s), clock.now_ns() > end_ns
        if call or late:
            monitor.give_up()
            why = f"deadline: {call} did not return" if call else f"it did not end within {CHECK_S:g} s"
            return Attempt(CheckResult(Verdict.FAILED, why, last=True))
    return attempts[0]


def _tried(check: Check, stand: DriverStand, monitor: CallMonitor) -> Attempt:
    with stand.measure_pauses() as meter:
        watch = CallWatch(stand.call_clock or stand.clock, meter)
        try:
            trial = Trial(stand, monitor, watch)
        except (Exception, SystemExit) as error:  # an installed driver may raise anything
            sentence = as_sentence(monitor.raised or "its construction", error)
            return Attempt(CheckResult(Verdict.FAILED, sentence, last=True))
        attempt = _attempt(check, trial, monitor)
        wrong = _end(trial, monitor)
        if wrong and stand.should_stop():
            return Attempt(CheckResult(Verdict.FAILED, wrong, last=True))
        return attempt


def _attempt(check: Check, trial: Trial, monitor: CallMonitor) -> Attempt:
    try:
        check(trial)
    except Interrupted:
        return Attempt(CheckResult(Verdict.SKIPPED, "interrupted"))
    except Skipped as skipped:
        return Attempt(CheckResult(Verdict.SKIPPED, str(skipped)))
    except (Failed, DriverError) as error:
        trial.watch.note_pause()
        fault = trial.supervisor.fault
        late = isinstance(error, TooSlow) or (fault is not None and fault.code is FaultCode.DEADLINE)
        return Attempt(
            CheckResult(Verdict.FAILED, str(error), last=isinstance(error, Hopeless)),
            excusable=True,
            by_deadline=late,
            slow=tuple(trial.watch.slow.values()),
            pause_ns=trial.watch.longest_pause_ns,
        )
    except (Exception, SystemExit) as error:
        sentence = as_sentence(monitor.raised or "a check that used what it returned", error)
        return Attempt(CheckResult(Verdict.FAILED, sentence))
    return Attempt(CheckResult(Verdict.PASSED, (check.__doc__ or "").strip()))


def _end(trial: Trial, monitor: CallMonitor) -> str:
    """Leave the robot at rest for the next check; why that failed, which an uninterrupted check has reported itself."""
    try:
        trial.end()
    except (Exception, SystemExit) as error:
        return as_sentence(monitor.raised or "the robot's end", error)
    return ""
