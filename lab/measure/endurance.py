"""Runs both sites for an hour, with recorder, viewers and a page: `python -m lab.measure.endurance [MINUTES]`.

Each minute the page is closed and opened again, the viewers leave and come again, and the arm is engaged again. It
writes build/endurance.json: by process, its memory, descriptors and threads in the first, the middle and the last fifth
of the time. It needs what `bench wan` needs, and 12 GB of disk an hour for the recording, which is deleted.
"""

import json
import subprocess
import sys
import tempfile
import time
from collections.abc import Sequence
from contextlib import ExitStack
from dataclasses import dataclass
from pathlib import Path

import numpy as np

from common.link.channels import CAMERA, STATE, ChannelSession
from common.link.transport import open_link
from lab.measure.wan.setup import CELL, PLAYED
from lab.measure.wan.source import render_source
from lab.measure.wan.stage import MEMORY, WanStage
from lab.stage.network.namespaces import why_not
from lab.stage.processes import ROOT, family, memory_mb, module_command, name_of

REPORT = Path("build") / "endurance.json"
MINUTES = 60.0
SETTLES_S = 60.0  # not counted: caches fill, the first page and the first engagement load what they need
ROUND_S, SAMPLE_S = 60.0, 5.0
ENGAGES_S = 10.0
VIEWERS = 8
LINK = {"delay_ms": 20.0, "mbit_s": 20.0}
S_PER_HOUR = 3600.0
SHARE = 5  # the first, the middle and the last fifth are compared


@dataclass(frozen=True, slots=True)
class Usage:
    """The resources of a process `t_s` after the start: resident memory, open descriptors, threads."""

    t_s: float
    memory_mb: float
    descriptors: int
    threads: int


def usage_of(pid: int, t_s: float) -> Usage | None:
    """Read what a process holds now; None where it has just ended."""
    process = Path(f"/proc/{pid}")
    try:
        counts = (sum(1 for _ in (process / part).iterdir()) for part in ("fd", "task"))
        return Usage(t_s, memory_mb(pid), *counts)
    except (OSError, StopIteration):
        return None


def growth(usages: Sequence[Usage]) -> dict[str, float]:
    """Compute medians of the first, middle and last fifth, and the memory's slope between the latter two, MB an hour.

    A median passes over what comes and goes, and buffers are full by the middle; what only grows is in the difference.
    ValueError for fewer than five.
    """
    part = len(usages) // SHARE
    if part == 0:
        raise ValueError(f"growth needs at least {SHARE} usages, there are {len(usages)}")
    middle_from = (len(usages) - part) // 2
    first, middle, last = (_medians(usages[k : k + part]) for k in (0, middle_from, len(usages) - part))
    hours = (last["t_s"] - middle["t_s"]) / S_PER_HOUR
    figures = {
        f"{name}_{when}": ends[name]
        for name in ("mb", "fds", "threads")
        for when, ends in (("first", first), ("middle", middle), ("last", last))
    }
    return figures | {"mb_per_hour": (last["mb"] - middle["mb"]) / hours}


def _medians(usages: Sequence[Usage]) -> dict[str, float]:
    rows = np.array([(each.t_s, each.memory_mb, each.descriptors, each.threads) for each in usages])
    return dict(zip(("t_s", "mb", "fds", "threads"), np.median(rows, axis=0).tolist(), strict=True))


def measure(minutes: float = MINUTES) -> dict[str, float]:
    """Measure in a process of its own, which leaves this host's network; the figures are by process."""
    if missing := why_not():
        sys.exit(f"endurance: no two hosts on this machine: {missing}")
    subprocess.run(module_command("lab.measure.endurance", minutes), check=True, cwd=ROOT)  # noqa: S603 - our own words
    figures: dict[str, float] = json.loads((ROOT / REPORT).read_text())
    return figures


def run(minutes: float) -> dict[str, float]:
    """Keep the pair busy, and watch its processes."""
    with ExitStack() as stack:
        source, recordings = (
            Path(stack.enter_context(tempfile.TemporaryDirectory(prefix="farhand-endurance-", dir=place)))
            for place in (MEMORY, None)
        )
        render_source(source)
        stage = stack.enter_context(WanStage(source, watched=True))
        stage.network.impair(**LINK)
        stage.record(recordings)
        watch = UsageWatch(stage)
        until_s = time.monotonic() + SETTLES_S + 60.0 * minutes
        rounds = engaged = 0
        while time.monotonic() < until_s:
            engaged += _round(stage, watch)
            rounds += 1
        return watch.figures() | {"rounds": float(rounds), "engaged": float(engaged)}


def _round(stage: WanStage, watch: "UsageWatch") -> bool:
    """Run a minute with a page and viewers, engaged; return whether the arm engaged."""
    files = stage.open_page("page")
    with ExitStack() as stack:
        for _ in range(VIEWERS):
            security = stage.setup.security_of_viewer
            link = stack.enter_context(
                open_link(connect=(stage.setup.viewers,), security=security, sessions=list(ChannelSession))
            )
            seen = [link.latest(STATE, CELL), *(link.latest(CAMERA, CELL, view) for view in PLAYED)]
            stack.callback(seen.clear)
        engaged = stage.engage(ENGAGES_S)
        until_s = time.monotonic() + ROUND_S
        while time.monotonic() < until_s:
            stage.sites.check()
            watch.look()
            time.sleep(SAMPLE_S)
    stage.disengage()
    stage.close_page()
    stage.states.clear()
    for file in files:
        file.unlink()
    return engaged


class UsageWatch:
    """The resources of every process of the sites but the page's, every few seconds once they have settled."""

    def __init__(self, stage: WanStage) -> None:
        self._stage, self._began_s = stage, time.monotonic()
        self._usages: dict[str, list[Usage]] = {}

    def look(self) -> None:
        """Read what each process holds now, unless they are still settling."""
        t_s = time.monotonic() - self._began_s
        if t_s < SETTLES_S:
            return
        for process in self._stage.sites.processes:
            for pid in family(process.pid) if process.name != "page" else ():
                usage = usage_of(pid, t_s)
                if usage is not None:
                    self._usages.setdefault(f"{process.name}/{name_of(pid)}/{pid}", []).append(usage)

    def figures(self) -> dict[str, float]:
        """Compute how each process that lasted has grown, and print a line for each."""
        figures: dict[str, float] = {}
        longest = max(map(len, self._usages.values()))
        for name, usages in self._usages.items():
            if len(usages) == longest:
                grown = growth(usages)
                figures |= {f"{name} {key}": value for key, value in grown.items()}
                print(name, " ".join(f"{key} {value:.1f}" for key, value in grown.items()), flush=True)
        return figures | {"processes": float(len(self._usages)), "samples": float(longest)}


if __name__ == "__main__":
    REPORT.parent.mkdir(exist_ok=True)
    REPORT.write_text(json.dumps(run(float(sys.argv[1]) if len(sys.argv) > 1 else MINUTES), indent=2) + "\n")
