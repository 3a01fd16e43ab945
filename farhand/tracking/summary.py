"""Summary of a track: how many pairs of each status, which points, how long it took, and in words."""

import re
from collections.abc import Sequence
from dataclasses import dataclass, field
from pathlib import Path
from typing import Any

import numpy as np

from common.errors import InterruptionError, TrackingError
from common.messages.hand import TrackingStatus
from farhand.tracking.causes import Causes
from farhand.tracking.track_line import POINTS, TrackLine

LEARNED_SO_FAR = re.compile(r" \(\d+ of \d+ pairs\)")


@dataclass
class Summary:
    """A recording's result: pairs, how many of each status, how often each point was found, toggles, ms per pair.

    `stated` is how many pairs there should be, None where the sources do not say so; `usable` pairs are tracked, or
    degraded for another reason than that the arm is still being learned.
    `drift` is the sentence of the first drift alarm, if there was one, and `misfit` that of a rig which most pairs
    contradict; `left_out` names what was not tracked because a camera ended before another, `damages` files that ended
    before their own end.
    """

    pairs: int = 0
    stated: int | None = None
    usable: int = 0
    statuses: dict[TrackingStatus, int] = field(default_factory=lambda: dict.fromkeys(TrackingStatus, 0))
    found: dict[str, int] = field(default_factory=lambda: dict.fromkeys(POINTS, 0))
    gripper_toggles: int = 0
    ms: list[float] = field(default_factory=list)
    causes: Causes = field(default_factory=lambda: Causes(()))
    drift: str | None = None
    misfit: str = ""
    left_out: str = ""
    damages: tuple[str, ...] = ()

    def add(self, line: TrackLine) -> None:
        """Count one pair."""
        self.pairs += 1
        self.statuses[line.status] += 1
        self.usable += is_usable(line)
        self.causes.add(lasting_reason(line))
        for name in POINTS:
            self.found[name] += getattr(line, name) is not None
        self.gripper_toggles = line.gripper_toggles
        self.ms.append(line.ms)

    def warn_of_drift(self, sentence: str) -> None:
        """Keep the drift alarm's sentence."""
        self.drift = sentence


def lasting_reason(line: TrackLine) -> str:
    """A pair's reason without the count of what has been learned, so that equal reasons are equal."""
    return LEARNED_SO_FAR.sub("", line.reason)


def is_usable(line: TrackLine) -> bool:
    """Return whether a pair counts as tracked."""
    is_learned = LEARNED_SO_FAR.search(line.reason) is None
    return line.status is TrackingStatus.TRACKED or (line.status is TrackingStatus.DEGRADED and is_learned)


def describe(summary: Summary, written: Sequence[Path]) -> str:
    """Describe what was found in a recording, with a line for each warning; `written` is what was written."""
    if not summary.pairs:
        return "no pair was tracked"
    found = ", ".join(f"{name} {summary.found[name]}" for name in POINTS)
    statuses = ", ".join(f"{count} {status.value}" for status, count in summary.statuses.items() if count)
    median, p95 = np.percentile(summary.ms, [50, 95])
    lines = [
        f"{summary.pairs} pairs: {statuses}",
        f"points found: {found}; gripper toggles: {summary.gripper_toggles}",
        f"{median:.1f} ms per pair (p95 {p95:.1f}); written to {', '.join(map(str, written))}",
    ]
    return "\n".join([*lines, *(f"warning: {sentence}" for sentence in _warnings(summary))])


def _warnings(summary: Summary) -> list[str]:
    return [sentence for sentence in (*summary.damages, summary.left_out, summary.misfit or summary.drift) if sentence]


def as_builtins(summary: Summary, written: Sequence[Path]) -> dict[str, Any]:
    """The same for programs; the time a pair takes is None where there is none."""
    median, p95 = np.percentile(summary.ms, [50, 95]).tolist() if summary.ms else (None, None)
    return {
        "pairs": summary.pairs,
        "usable": summary.usable,
        "statuses": summary.statuses,
        "found": summary.found,
        "gripper_toggles": summary.gripper_toggles,
        "ms": {"p50": median, "p95": p95},
        "written": written,
        "warnings": _warnings(summary),
    }


def refuse_nothing(summary: Summary) -> None:
    """TrackingError if pairs were read, but none can be used; it says why most of them cannot."""
    if summary.pairs and not summary.usable:
        raise TrackingError(f"nothing was tracked; most often: {summary.causes.commonest}")


def refuse_interrupted(summary: Summary, written: Sequence[Path]) -> None:
    """InterruptionError that says how far a track came that was asked to stop, and where its results are."""
    if not summary.pairs:
        raise InterruptionError("stopped by Ctrl-C or SIGTERM before the first pair; nothing was written")
    of = f" of {summary.stated}" if summary.stated else ""
    raise InterruptionError(
        f"stopped by Ctrl-C or SIGTERM after {summary.pairs}{of} pairs; what was tracked so far is written to "
        f"{', '.join(map(str, written))}"
    )
