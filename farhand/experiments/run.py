"""Runs an experiment by its name, shows how far it is, and writes its folder."""

from collections.abc import Callable
from dataclasses import dataclass
from pathlib import Path

from rich.console import Console
from rich.progress import Progress

from common.errors import ConfigError
from farhand.experiments import drift_experiment, follow_experiment, hazel_experiment
from farhand.experiments.report import ExperimentReport, write_report
from farhand.outputs import check_folder, make_folder
from farhand.tracking.run import prepare_tracker
from local_site.tracking.choice import TrackingConfig


@dataclass(frozen=True, slots=True)
class Experiment:
    """How many steps it has, how it is run (quick or not, told of every step), and its figures in words."""

    steps: Callable[[bool], int]
    run: Callable[[bool, Callable[[], bool]], ExperimentReport]
    describe: Callable[[ExperimentReport], str]


EXPERIMENTS = {
    "drift": Experiment(drift_experiment.frames_of, drift_experiment.drift_report, drift_experiment.describe),
    "follow": Experiment(follow_experiment.frames_of, follow_experiment.follow_report, follow_experiment.describe),
    "hazel": Experiment(hazel_experiment.frames_of, hazel_experiment.hazel_report, hazel_experiment.describe),
}


def run_experiment(name: str, out: Path, quick: bool, should_stop: Callable[[], bool] = lambda: False) -> str:
    """Run an experiment, write its report, and sum it up in words.

    ConfigError for an unknown name or a folder that cannot be written, before any work; InterruptionError when stopped.
    """
    if name not in EXPERIMENTS:
        raise ConfigError(f"there is no experiment {name!r}; choose one of: {', '.join(sorted(EXPERIMENTS))}")
    experiment = EXPERIMENTS[name]
    check_folder("--out", out)
    make_folder("--out", out)
    prepare_tracker(TrackingConfig())
    with Progress(console=Console(stderr=True)) as progress:
        task = progress.add_task(name, total=experiment.steps(quick))

        def step() -> bool:
            progress.advance(task)
            return not should_stop()

        report = experiment.run(quick, step)
    write_report(report, out)
    return f"{experiment.describe(report)}\nwritten to {out / 'report.html'}"
