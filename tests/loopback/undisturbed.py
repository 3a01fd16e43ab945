"""Loopback runs for tests: one that the machine itself has ended, by standing still for too long, is made again."""

import json
import subprocess
import sys
from collections.abc import Callable
from pathlib import Path
from typing import Any

from tests.late_machine import was_late

# A sample that grows a second old ends an engagement, and no configuration waits longer.
PATIENT = ("--set", "safety.t_latch_ms=1000")
RUNS = 4


def run_loopback(*arguments: str, report: Path, timeout_s: float) -> dict[str, Any]:
    """The figures of a run whose engagement no pause of the machine ended; the last run's if all were disturbed."""

    def run() -> None:
        command = [sys.executable, "-m", "farhand", "loopback", *arguments, *PATIENT, "--report", str(report)]
        done = subprocess.run(command, check=False, capture_output=True, text=True, timeout=timeout_s)
        assert done.returncode == 0, done.stderr

    return undisturbed(run, report)


def undisturbed(run: Callable[[], object], report: Path) -> dict[str, Any]:
    """The figures that a run leaves in its report, run again while the machine's pauses end its engagement."""
    for _ in range(RUNS):
        run()
        figures: dict[str, Any] = json.loads(report.read_text())
        if not was_disturbed(figures["events"]):
            break
    return figures


def was_disturbed(events: list[str]) -> bool:
    """Whether the machine has ended the engagement; an event is a time, the new state, and its reason."""
    return any(was_late(event.partition(", ")[2]) for event in events)
