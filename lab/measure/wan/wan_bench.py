"""Measures links one by one on one pair of sites: `python -m lab.measure.wan.wan_bench [--full | --links=NAME,...]`.

Without a choice it takes a part of the matrix, in eight minutes. It writes build/wan: report.json, networks.md
(tables), networks.png. The whole needs the right to network namespaces and to /dev/net/tun.
"""

import json
import os
import subprocess
import sys
import tempfile
import time
from collections.abc import Callable, Mapping, Sequence
from functools import partial
from pathlib import Path
from typing import Any

import numpy as np

from lab.measure.wan.demands import judge_change, judge_links
from lab.measure.wan.figures import (
    Copying,
    Span,
    change_figures,
    following_figures,
    hand_age_figures,
    machine_figures,
    ready_after_s,
    session_figures,
)
from lab.measure.wan.links import Change, WanLink, chosen
from lab.measure.wan.pictures import Likeness, picture_figures, read_seen, understated_ms
from lab.measure.wan.report import write_report
from lab.measure.wan.setup import PLAYED
from lab.measure.wan.source import render_source
from lab.measure.wan.stage import FIGURE_HZ, FIGURE_M, GLIDE_S, MEMORY, WanStage
from lab.stage.network.namespaces import why_not
from lab.stage.processes import ROOT, cpu_s, module_command
from lab.stage.stolen_time import StolenTime

FOLDER = Path("build") / "wan"
CUT_S = 2.5  # more than a link's lease
ENGAGES_S = 10.0
SETTLES_S = 5.0  # the glide to the figure of eight, and the pictures' adaptation
WATCHED_S = 12.0  # more than once the whole figure
ALONE_S = 8.0
HAND_ALONE = WanLink(20, mbit_s=5)  # where the hand is measured without pictures first
CHANGED_WATCHED_S = 8.0
MOST_STOLEN, MOST_RUNS = 0.3, 3  # of all cores within 0.25 s; how often a link is then measured
CONGESTION = Path("/proc/sys/net/ipv4/tcp_congestion_control")

Figures = dict[str, Any]


def measure(*words: str) -> dict[str, float]:
    """The figures by link, and how many demands were met; in a process of its own, which leaves this host's network.

    The words choose the links, as in the command.
    """
    missing = why_not()
    if missing:
        sys.exit(f"wan: no two hosts on this machine: {missing}")
    subprocess.run([*module_command("lab.measure.wan.wan_bench"), *words], check=True, cwd=ROOT)
    report = json.loads((ROOT / FOLDER / "report.json").read_text())
    figures = {
        f"{name}_{key}": value
        for name, row in (report["links"] | report["changes"]).items()
        for key, value in row.items()
    }
    met = [verdict["passed"] for verdict in report["verdicts"]]
    return {k: float(v) for k, v in figures.items() if isinstance(v, int | float)} | {
        "demands_met": float(sum(met)),
        "demands_failed": float(len(met) - sum(met)),
    }


def run(links: Sequence[WanLink], changes: Sequence[Change]) -> None:
    """Measure the links and changes, print a line for each, and write the report."""
    with tempfile.TemporaryDirectory(prefix="farhand-wan-source-", dir=MEMORY) as folder:
        render_source(Path(folder))
        with WanStage(Path(folder)) as stage:
            bench = WanBench(stage, Likeness(Path(folder)))
            # Before any page: once one has sent the operator's intent, nothing engages while it is silent.
            measured = {
                link: undisturbed(partial(bench.link, link))
                for link in sorted(links, key=lambda link: link != HAND_ALONE)
            }
            changed = {change: undisturbed(partial(bench.change, change)) for change in changes}
    verdicts = judge_links(measured)
    verdicts += [one for change, figures in changed.items() for one in judge_change(change, figures, hand_mm_s())]
    write_report(FOLDER, measured, changed, verdicts, CONGESTION.read_text().strip())
    failed = sum(not one.passed for one in verdicts)
    print(f"{len(verdicts) - failed} demands met, {failed} failed: {FOLDER / 'networks.md'}")


def undisturbed(measure: Callable[[], Figures]) -> Figures:
    """Measure, and again, whatever the result, while the machine's host takes too much of its cores away.

    That is at most MOST_RUNS times. Adds `stolen`, the share of all cores in the worst 0.25 s, and how many `runs`.
    """
    figures: Figures = {}
    runs, share = 0, 1.0
    while share > MOST_STOLEN and runs < MOST_RUNS:
        with StolenTime(os.cpu_count() or 1) as stolen:
            figures = measure()
        runs, share = runs + 1, stolen.worst
    return figures | {"stolen": share, "runs": runs}


def hand_mm_s() -> float:
    """The greatest speed of the figure of eight."""
    phase = np.linspace(0.0, 4 * np.pi, 1000)
    x, y = (a * np.sin(p * phase) for a, p in zip(FIGURE_M[:2], (1.0, 0.5), strict=True))
    per_s = len(phase) / (4 * np.pi) * 2 * np.pi * FIGURE_HZ
    return 1e3 * per_s * float(np.hypot(np.diff(x), np.diff(y)).max())


class WanBench:
    """Plays one link after the other on a stage."""

    def __init__(self, stage: WanStage, likeness: Likeness) -> None:
        self._stage, self._likeness = stage, likeness
        mapping = stage.config.mapping
        self._copying = Copying(mapping.scale, np.array(mapping.base_R_operator))

    def link(self, link: WanLink) -> Figures:
        """Engage over a link, follow, look; all figures of it."""
        stage = self._stage
        healed_ns = self._connect(link)
        figures = self._hand_alone() if link == HAND_ALONE else {}
        files = stage.open_page(link.name)
        began_ns = time.monotonic_ns()
        stage.engage(ENGAGES_S)
        time.sleep(SETTLES_S)
        stage.network.report()
        used_s, from_ns = cpu_s(stage.network.link_pid), time.monotonic_ns()
        time.sleep(WATCHED_S)
        to_ns, used_s = time.monotonic_ns(), cpu_s(stage.network.link_pid) - used_s
        carried = stage.network.report()
        states, path = stage.since(began_ns), stage.hand.path
        stage.disengage()
        stage.close_page()
        seen = read_seen(*files)
        figures |= {"ready_after_s": ready_after_s(stage.since(healed_ns), healed_ns)}
        figures |= session_figures(states)
        figures |= following_figures(states, from_ns, lambda t_ns: path.at(t_ns)[:3], self._copying)
        figures |= hand_age_figures(states, from_ns)
        figures |= picture_figures(seen, PLAYED, from_ns, to_ns)
        figures |= self._likeness.figures(seen, PLAYED, from_ns, to_ns)
        figures |= machine_figures(states)
        figures |= {"link_late_p99_ms": max(way["late_p99_ms"] for way in carried), "link_cpu": used_s / WATCHED_S}
        for file in files:
            file.unlink()
        _tell(link.name, figures)
        return figures

    def change(self, change: Change) -> Figures:
        """Follow, change the link, and watch."""
        stage = self._stage
        self._connect(change.before)
        files = stage.open_page("change")
        began_ns = time.monotonic_ns()
        stage.engage(ENGAGES_S)
        time.sleep(SETTLES_S)
        changed_ns = time.monotonic_ns()
        stage.network.impair(**change.impairment)
        if change.seconds:
            time.sleep(change.seconds)
            stage.network.impair(**change.before.impairment)
        healed_ns = time.monotonic_ns() if change.seconds else changed_ns
        time.sleep(CHANGED_WATCHED_S)
        states = stage.since(began_ns)
        stage.disengage()
        stage.close_page()
        seen = [one for one in read_seen(*files) if one.sight.seen_ns > changed_ns]
        figures = change_figures(states, Span(changed_ns, healed_ns))
        figures |= {"age_understated_ms": understated_ms(seen)}
        for file in files:
            file.unlink()
        _tell(change.name, figures)
        return figures

    def _connect(self, link: WanLink) -> int:
        """Cut the link for so long that all connections have ended, and have them made again over this one."""
        self._stage.network.impair(cut=True)
        time.sleep(CUT_S)
        self._stage.network.impair(**link.impairment)
        return time.monotonic_ns()

    def _hand_alone(self) -> Figures:
        """Measure how old the hand is on arrival while no picture is sent."""
        stage = self._stage
        stage.engage(ENGAGES_S)
        time.sleep(GLIDE_S)
        from_ns = time.monotonic_ns()
        time.sleep(ALONE_S)
        alone = hand_age_figures(stage.since(from_ns), from_ns)
        stage.disengage()
        return {f"hand_alone_{key.removeprefix('hand_')}": value for key, value in alone.items()}


def _tell(name: str, figures: Mapping[str, Any]) -> None:
    words = (f"{key} {value:.4g}" if isinstance(value, float) else f"{key} {value}" for key, value in figures.items())
    print(f"{name}: {', '.join(words)}", flush=True)


if __name__ == "__main__":
    try:
        links, changes = chosen(sys.argv[1:])
    except ValueError as error:
        sys.exit(f"wan: {error}")
    run(links, changes)
