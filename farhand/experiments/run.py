"""Runs an experiment by its name, shows its progress, and writes its folder."""

from collections.abc import Callable
from pathlib import Path

from rich.console import Console
from rich.progress import Progress as ProgressBar

from common.errors import ConfigError, InterruptionError
from farhand.experiments import follow
from farhand.experiments.placing import causes, over_network
from farhand.experiments.placing import series as placing
from farhand.experiments.report import ExperimentReport, Progress, write_report
from farhand.experiments.results.every import run_every
from farhand.experiments.robonaut import commanding, drift, hazel
from farhand.experiments.thesis import calibration, icr, markers
from farhand.outputs import check_folder, make_folder
from farhand.reports.plotting import require_matplotlib
from farhand.tracking.run import prepare_tracker
from local_site.tracking.choice import TrackingConfig

# Of each experiment, quick or in full: how many frames it makes, and how it is run, reporting each frame.
EXPERIMENTS: dict[str, tuple[Callable[[bool], int], Callable[[bool, Progress], ExperimentReport]]] = {
    "calibration": (calibration.frame_count, calibration.calibration_report),
    "causes": (causes.trial_count, causes.causes_report),
    "drift": (drift.frame_count, drift.drift_report),
    "follow": (follow.frame_count, follow.follow_report),
    "hazel": (hazel.frame_count, hazel.hazel_report),
    "icr": (icr.frame_count, icr.icr_report),
    "markers": (markers.frame_count, markers.markers_report),
    "network": (over_network.trial_count, over_network.network_report),
    "placing": (placing.trial_count, placing.placing_report),
    "robonaut": (commanding.frame_count, commanding.robonaut_report),
}


ALL = "all"


def run_experiment(name: str, out: Path, quick: bool, should_stop: Callable[[], bool] = lambda: False) -> str:
    """Run an experiment, or "all" of them, write what came of it, and summarise it in words.

    Before any work, ConfigError for an unknown name or a folder that cannot be written, and FarhandError without
    matplotlib; InterruptionError when stopped.
    """
    if name not in EXPERIMENTS and name != ALL:
        raise ConfigError(f"there is no experiment {name!r}; choose one of: {', '.join(sorted([*EXPERIMENTS, ALL]))}")
    require_matplotlib()
    check_folder("--out", out)
    make_folder("--out", out)
    prepare_tracker(TrackingConfig())
    with ProgressBar(console=Console(stderr=True)) as progress:
        if name == ALL:
            return run_every(sorted(EXPERIMENTS), lambda each: _run(each, quick, progress, should_stop), out, quick)
        report = _run(name, quick, progress, should_stop)
    write_report(report, out)
    return f"{report.summary}\nwritten to {out / 'report.html'}"


def _run(name: str, quick: bool, progress: ProgressBar, should_stop: Callable[[], bool]) -> ExperimentReport:
    frame_count, run = EXPERIMENTS[name]
    task = progress.add_task(name, total=frame_count(quick))

    def step() -> None:
        progress.advance(task)
        if should_stop():
            raise InterruptionError(f"interrupted before the experiment {name} was done; nothing of it was written")

    return run(quick, step)
