"""Runs an experiment by its name, or all with a page of their results, shows its progress, and writes its folder."""

import json
from collections.abc import Callable, Sequence
from importlib import metadata
from pathlib import Path
from typing import Any

from rich.console import Console
from rich.progress import Progress as ProgressBar

from common.errors import ConfigError, InterruptionError
from common.text import instead_of
from farhand.outputs import check_folder, make_folder, write_result
from farhand.reports.plotting import require_matplotlib
from farhand.tracking.track_run import prepare_tracker
from lab.experiments import follow
from lab.experiments.placing import causes, over_network
from lab.experiments.placing import series as placing
from lab.experiments.placing.kept_trials import KeptTrials
from lab.experiments.placing.live import series as realtime
from lab.experiments.placing.trials import TrialExperiment, run_all
from lab.experiments.report import ExperimentReport, Progress, write_report
from lab.experiments.results.results_page import as_html, as_markdown
from lab.experiments.robonaut import commanding, drift, hazel
from lab.experiments.thesis import calibration, icr, markers
from local_site.tracking.choice import TrackingConfig

# Of each experiment, quick or in full: how many frames it makes, and how it is run, reporting each frame.
EXPERIMENTS: dict[str, tuple[Callable[[bool], int], Callable[[bool, Progress], ExperimentReport]]] = {
    "calibration": (calibration.frame_count, calibration.calibration_report),
    "drift": (drift.frame_count, drift.drift_report),
    "follow": (follow.frame_count, follow.follow_report),
    "hazel": (hazel.frame_count, hazel.hazel_report),
    "icr": (icr.frame_count, icr.icr_report),
    "markers": (markers.frame_count, markers.markers_report),
    "robonaut": (commanding.frame_count, commanding.robonaut_report),
}
TRIAL_EXPERIMENTS: dict[str, TrialExperiment] = {
    "causes": TrialExperiment(causes.causes_conditions, causes.causes_report),
    "network": TrialExperiment(over_network.network_conditions, over_network.network_report),
    "placing": TrialExperiment(placing.placing_conditions, placing.placing_report),
}
REPEATABLE = sorted([*EXPERIMENTS, *TRIAL_EXPERIMENTS])
REAL_TIME = "realtime"  # depends on the machine, so that it is not part of the page of all results
NAMES = sorted([*REPEATABLE, REAL_TIME])
ALL = "all"
VERSION = metadata.version("farhand")
DONE = "done.json"  # which experiments of the folder are finished, and whether they were quick


def run_experiment(name: str, out: Path, quick: bool, should_stop: Callable[[], bool] = lambda: False) -> str:
    """Run an experiment, or "all" that are the same each time, write what came of it, and summarise it in words.

    Before any work, ConfigError for an unknown name or a folder that cannot be written, and FarhandError without
    matplotlib; InterruptionError when stopped.
    """
    if name not in NAMES and name != ALL:
        raise ConfigError(f"there is no experiment {name!r}; {instead_of(name, sorted([*NAMES, ALL]))}")
    require_matplotlib()
    check_folder("--out", out)
    make_folder("--out", out)
    prepare_tracker(TrackingConfig())
    with ProgressBar(console=Console(stderr=True)) as progress:

        def run(each: str) -> ExperimentReport:
            return _run(each, out, quick, progress, should_stop)

        if name == ALL:
            return run_every(REPEATABLE, run, out, quick, VERSION)
        report = run(name)
    write_report(report, out)
    return f"{report.summary}\nwritten to {out / 'report.html'}"


def _run(name: str, out: Path, quick: bool, progress: ProgressBar, should_stop: Callable[[], bool]) -> ExperimentReport:
    """One experiment; its trials are kept in the folder `out`, where others may have left some of the same."""
    task = progress.add_task(name, total=None)

    def step() -> None:
        progress.advance(task)
        if should_stop():
            left = "its finished trials are kept" if name in TRIAL_EXPERIMENTS else "nothing of it was written"
            raise InterruptionError(f"interrupted before the experiment {name} was done; {left}")

    if name in TRIAL_EXPERIMENTS:
        trials = TRIAL_EXPERIMENTS[name]
        conditions = trials.conditions(quick)
        progress.update(task, total=len(conditions))
        return trials.report(run_all(conditions, step, KeptTrials(out, VERSION)))
    if name == REAL_TIME:
        progress.update(task, total=realtime.trial_count(quick))
        return realtime.realtime_report(quick, step, KeptTrials(out, VERSION))
    frame_count, experiment = EXPERIMENTS[name]
    progress.update(task, total=frame_count(quick))
    return experiment(quick, step)


def run_every(
    names: Sequence[str], run: Callable[[str], ExperimentReport], out: Path, quick: bool, version: str
) -> str:
    """Run all experiments, each into a folder of its own, and write results.md and results.html of those that are done.

    What is done in this folder already is not run again, unless it was of another version, or quick and is not to be.
    ConfigError when a folder cannot be written, or what is done cannot be read.
    """
    for name in names:
        if not _is_done(out / name, quick, version):
            check_folder("--out", out / name)
            make_folder("--out", out / name)
            write_report(run(name), out / name)
            write_result(out / name / DONE, json.dumps({"version": version, "quick": quick}).encode())
        _write_page([each for each in names if _is_done(out / each, quick, version)], out, quick, version)
    return f"every table and figure is listed in {out / 'results.md'}"


def _write_page(names: Sequence[str], out: Path, quick: bool, version: str) -> None:
    reports = {name: _figures(out / name) for name in names}
    write_result(out / "results.md", as_markdown(reports, version, quick).encode())
    write_result(out / "results.html", as_html(reports, version, quick).encode())


def _is_done(folder: Path, quick: bool, version: str) -> bool:
    try:
        done = json.loads((folder / DONE).read_text())
    except (OSError, ValueError):
        return False
    return bool(done == {"version": version, "quick": quick})


def _figures(folder: Path) -> dict[str, Any]:
    try:
        figures: dict[str, Any] = json.loads((folder / "report.json").read_text())
    except (OSError, ValueError) as error:
        raise ConfigError(
            f"{folder / 'report.json'} cannot be read ({error}); remove {folder} and run again"
        ) from error
    return figures
