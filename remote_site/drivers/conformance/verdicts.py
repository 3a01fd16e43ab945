"""Verdicts of the outcome of a check on the driver, when calls were slow or the machine paused meanwhile; pure."""

from collections.abc import Mapping
from dataclasses import dataclass, replace
from enum import Enum

from common.clock import NS_PER_MS
from remote_site.drivers.conformance.call_watch import SlowCall

PAUSE_NS = 12 * NS_PER_MS  # three ticks: a command that comes later finds that the supervisor has begun to brake
ATTEMPTS = 3


class Verdict(Enum):
    """The outcome of a check; REPEAT (the machine paused) and SUFFERS (of a call reported before) judge nothing."""

    PASSED = "passed"
    SKIPPED = "skipped"
    FAILED = "FAILED"
    REPEAT = "repeat"
    SUFFERS = "suffers"


@dataclass(frozen=True, slots=True)
class CheckResult:
    """A check's verdict on a driver, and why; after the `last` no other check can run."""

    verdict: Verdict
    sentence: str
    last: bool = False


@dataclass(frozen=True, slots=True)
class Attempt:
    """One run of a check: how it ended, the calls that were slow meanwhile, and the machine's longest pause, ns.

    `excusable` is a failure that a slow call or a pause may have caused, `by_deadline` one whose sentence only repeats
    that a call was slow.
    """

    result: CheckResult
    excusable: bool = False
    by_deadline: bool = False
    slow: tuple[SlowCall, ...] = ()
    pause_ns: int = 0


def judge(attempt: Attempt, reported: Mapping[str, str]) -> CheckResult:
    """The verdict of an attempt; `reported` has the check in which each slow call was reported, by the call's name.

    A slow call is the driver's whatever the machine did: its pauses are not counted in it.
    """
    if not attempt.excusable:
        return attempt.result
    found = "" if attempt.by_deadline else f"; found: {attempt.result.sentence}"
    new = [call for call in attempt.slow if call.name not in reported]
    if new:
        cure = "do what is slow in a thread of the driver's own"
        return replace(attempt.result, sentence=f"{', '.join(map(str, new))}; {cure}{found}")
    if attempt.slow:
        seen = ", ".join(f"{call}, see {reported[call.name].replace('_', ' ')}" for call in attempt.slow)
        return replace(attempt.result, verdict=Verdict.SUFFERS, sentence=f"{seen}{found}")
    # without a slow call of the driver's, the supervisor's deadline was exceeded by the machine alone
    if attempt.pause_ns > (0 if attempt.by_deadline else PAUSE_NS):
        return CheckResult(Verdict.REPEAT, f"{_stood_still(attempt.pause_ns)}{found}")
    return attempt.result


def _stood_still(pause_ns: int) -> str:
    still = f"this machine stood still for {pause_ns / NS_PER_MS:.0f} ms"
    return f"{still} in the last of {ATTEMPTS} attempts; repeat when it does less"
