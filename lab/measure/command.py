"""Runs every measurement, prints one table each, and writes build/bench.json: {benchmark: {figure: value}}.

    python -m bench [NAME ...] [--full | --links=LINK,...]

cells      how many cells one router carries: age and fraction of hands and pictures, processor time and memory
control    what a control tick costs, from decoding to writing, beside Pink's inverse kinematics on the same targets
endurance  an hour of both sites with recorder, viewers and a page: memory, descriptors and threads of each process
fluency    ten minutes of the operator's page: its slowest and latest ten seconds; what it takes without pictures
fuzz       a million hostile payloads for the codec: the reasons of the refusals, payloads per second, growth of memory
load       processor time with both sites and the page open, by process and stage, and the demonstration's share
monocular  the monocular tracker: error against the number of points per link, and time per frame
mutants    small changes to what decides about motion: how many a test notices; goes on from build/mutants.jsonl
page       the operator's page in Chromium: from glass to glass, on one machine and on split cores, beside a bare page
recording  a recording of an hour: time to open it, to seek in it, to repair it; bytes a minute as JPEG and H.264
rendering  time to render a stereo pair of the simulated operator and the views of the cell, and their size as JPEG
soak       ten minutes of simulated time in which everything goes wrong: the worst that each driver received
tracking   both trackers of a bare arm beside MediaPipe Hands: time, gaps, errors, honest covariances; a real film
video      the four views: processor time, bytes, and what arrives through links of 20, 5 and 2 Mbit/s
wan        both sites over Internet links of a matrix: following, holds, lag, pictures, beside what is demanded

--full has wan take the whole matrix, 45 minutes, instead of a part, eight minutes; --links=120ms_20pc_3pc_5mbit has it
take that link alone, --links="cut of 1 s" that change.

Pink and MediaPipe are installed below build/ when they are first needed, and skipped where that fails.
"""

import json
import sys
from collections.abc import Callable
from functools import partial
from pathlib import Path

from rich.console import Console
from rich.table import Table

from lab.measure import cells, endurance, fuzz, load, rendering
from lab.measure.control import tick as control
from lab.measure.page import fluency
from lab.measure.page import page_bench as page
from lab.measure.recording import recording_bench as recording
from lab.measure.soak import worst_commands as soak
from lab.measure.tracking import comparison as tracking
from lab.measure.tracking import monocular
from lab.measure.video import views as video
from lab.measure.wan import wan_bench as wan
from lab.measure.wan.links import FULL, LINKS
from lab.mutants import survivors as mutants

BENCHMARKS: dict[str, Callable[[], dict[str, float]]] = {
    "cells": cells.measure,
    "control": control.measure,
    "endurance": endurance.measure,
    "fluency": fluency.measure,
    "fuzz": fuzz.measure,
    "load": load.measure,
    "monocular": monocular.measure,
    "mutants": mutants.measure,
    "page": page.measure,
    "recording": recording.measure,
    "rendering": rendering.measure,
    "soak": soak.measure,
    "tracking": tracking.measure,
    "video": video.measure,
    "wan": wan.measure,
}
SHOW_THEMSELVES = {"tracking", "wan"}
RESULTS = Path("build") / "bench.json"


def main(names: list[str]) -> None:
    """Run the named benchmarks; without names, all."""
    if {"-h", "--help"} & set(names):
        print(__doc__)
        return
    words = [name for name in names if name.startswith("-")]
    if strange := [word for word in words if word != FULL and not word.startswith(LINKS)]:
        sys.exit(f"no such option: {', '.join(strange)}; there are {FULL}, {LINKS}LINK,... and --help")
    benchmarks = BENCHMARKS | {"wan": partial(wan.measure, *words)}
    names = [name for name in names if name not in words]
    unknown = set(names) - set(BENCHMARKS)
    if unknown:
        sys.exit(f"no such benchmark: {', '.join(sorted(unknown))}; there are {', '.join(BENCHMARKS)}")
    results: dict[str, dict[str, float]] = {}
    for name in names or BENCHMARKS:
        results[name] = benchmarks[name]()
        RESULTS.parent.mkdir(exist_ok=True)
        RESULTS.write_text(json.dumps(results, indent=2) + "\n", encoding="utf-8")  # another may fail
        if name not in SHOW_THEMSELVES:
            _show(name, results[name])


def _show(name: str, figures: dict[str, float]) -> None:
    table = Table(title=name, show_header=False)
    for figure, value in figures.items():
        table.add_row(figure, f"{value:.3f}")
    Console().print(table)
