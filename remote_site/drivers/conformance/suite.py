"""Runs the checks one after the other, each to an end, whatever the driver does; tells a line of each."""

import threading
from collections.abc import Callable, Sequence
from dataclasses import dataclass
from enum import Enum

from common.clock import NS_PER_S, MonotonicClock
from common.errors import DriverError
from remote_site.drivers.conformance.checks import CHECKS, Check
from remote_site.drivers.conformance.trial import DriverStand, Failed, Hopeless, Skipped, Trial, told
from remote_site.drivers.conformance.watched import Watch

CALL_S = 5.0  # of a call that has 50 ms: it will not come back
CHECK_S = 180.0
LOOK_S = 0.1


class Word(Enum):
    """What a check says of a driver."""

    PASSED = "passed"
    SKIPPED = "skipped"
    FAILED = "FAILED"


@dataclass(frozen=True, slots=True)
class CheckResult:
    """A check's word on a driver and why; after the `last` no other check can be tried."""

    word: Word
    sentence: str
    last: bool = False


def run_checks(
    stand: DriverStand, tell: Callable[[str], None], checks: Sequence[Check] = CHECKS, call_s: float = CALL_S
) -> list[str]:
    """Run every check, tell a line of each; the names of those that failed. No call may take longer than `call_s`."""
    failed: list[str] = []
    for check in checks:
        verdict = _verdict(check, stand, call_s)
        tell(f"{verdict.word.value:<8}{check.__name__.replace('_', ' '):<20} {verdict.sentence}")
        if verdict.word is Word.FAILED:
            failed.append(check.__name__)
        if verdict.last:
            tell("No other check can be tried before this is mended.")
            break
    return failed


def _verdict(check: Check, stand: DriverStand, call_s: float) -> CheckResult:
    """The verdict of a thread of its own, which is left behind when a call of the driver does not come back."""
    watch, clock = Watch(), MonotonicClock()
    verdicts: list[CheckResult] = []
    worker = threading.Thread(target=lambda: verdicts.append(_tried(check, stand, watch)), name="check", daemon=True)
    end_ns = clock.now_ns() + round(CHECK_S * NS_PER_S)
    worker.start()
    while worker.is_alive():
        worker.join(LOOK_S)
        call, late = watch.stuck(call_s), clock.now_ns() > end_ns
        if call or late:
            watch.give_up()
            why = f"deadline: {call} did not come back" if call else f"it did not end within {CHECK_S:g} s"
            return CheckResult(Word.FAILED, why, last=True)
    return verdicts[0]


def _tried(check: Check, stand: DriverStand, watch: Watch) -> CheckResult:
    try:
        trial = Trial(stand, watch)
    except (Exception, SystemExit) as error:  # a stranger's code may raise whatever it likes
        return CheckResult(Word.FAILED, told(watch.raised or "its making", error), last=True)
    try:
        check(trial)
    except Skipped as skipped:
        return CheckResult(Word.SKIPPED, str(skipped))
    except (Failed, DriverError) as error:
        return CheckResult(Word.FAILED, str(error), last=isinstance(error, Hopeless))
    except (Exception, SystemExit) as error:
        return CheckResult(Word.FAILED, told(watch.raised or "a check that used what it says", error))
    finally:
        _end(trial)
    return CheckResult(Word.PASSED, (check.__doc__ or "").strip())


def _end(trial: Trial) -> None:
    """Leave the robot at rest for the next check."""
    try:
        trial.driver.stop()
        trial.run(700)
        trial.driver.deactivate()
        trial.run(100)
    except (Exception, SystemExit):  # noqa: S110  # the check has told already what is wrong with it
        pass
