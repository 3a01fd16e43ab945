"""Runs trials on all processors, and sums them up: medians and quartiles, counts, and a row for each."""

import multiprocessing
from collections.abc import Callable, Mapping, Sequence
from concurrent.futures import ProcessPoolExecutor, as_completed
from dataclasses import dataclass
from os import cpu_count

import cv2
import numpy as np

from common.geometry import Array
from lab.experiments.placing.judge import Placed
from lab.experiments.placing.kept_trials import KeptTrials
from lab.experiments.placing.trial import Conditions, TrialResult, run_trial
from lab.experiments.report import CsvTable, ExperimentReport, Figures, Progress, rounded

Results = Mapping[Conditions, TrialResult]
ERRORS = "x_mm", "y_mm", "angle_deg"
COLUMNS = (
    "trial",
    "x_mm",
    "y_mm",
    "angle_deg",
    "placed",
    "time_s",
    "drops",
    "collisions",
    "clutches",
    "misses",
    "holds",
)


@dataclass(frozen=True, slots=True)
class TrialExperiment:
    """An experiment made of trials: which ones, quick or in full, and what is reported of their results."""

    conditions: Callable[[bool], list[Conditions]]
    report: Callable[[Results], ExperimentReport]


def run_all(conditions: Sequence[Conditions], progress: Progress, kept: KeptTrials) -> Results:
    """The results by their conditions, the same for the same installation; `progress` is told of each.

    What is kept is not run again.
    """
    context = multiprocessing.get_context("spawn")
    with ProcessPoolExecutor(
        cpu_count() or 1, mp_context=context, initializer=cv2.setNumThreads, initargs=(1,)
    ) as pool:
        running = {pool.submit(run_trial, each): each for each in conditions if each not in kept.results}
        try:
            for _ in range(len(conditions) - len(running)):
                progress()
            for future in as_completed(running):
                kept.keep(running[future], future.result())
                progress()
        finally:
            pool.shutdown(cancel_futures=True)
    return {each: kept.results[each] for each in conditions}


def summary(trials: Sequence[TrialResult]) -> Figures:
    """Errors of the placed trials, without their sign; time, clutches and force of all; counts."""
    ended = [trial.end for trial in trials if trial.end.placed]
    return {
        **errors(ended),
        "placed": len(ended),
        "trials": len(trials),
        "drops": sum(trial.drops for trial in trials),
        "time_s": _quartiles(np.array([trial.time_s for trial in trials])),
        "collisions": sum(trial.collisions for trial in trials),
        "grasps_missed": sum(trial.misses for trial in trials),
        "clutches": _quartiles(np.array([float(trial.clutches) for trial in trials])),
        "holds": sum(trial.holds for trial in trials),
        "contact_force_n": _quartiles(np.array([trial.grip_force_n for trial in trials])),
    }


def errors(ends: Sequence[Placed]) -> Figures:
    """Sum up how far off their target blocks were left, without the sign."""
    return {name: _quartiles(np.abs([getattr(end, name) for end in ends])) for name in ERRORS}


def _quartiles(values: Array) -> Figures:
    if not len(values):
        return {"median": None, "q1": None, "q3": None}
    q1, median, q3 = np.percentile(values, [25, 50, 75])
    return {"median": rounded(median), "q1": rounded(q1), "q3": rounded(q3)}


def csv(trials: Sequence[TrialResult]) -> CsvTable:
    """A row for each trial."""
    rows = [
        (
            k + 1,
            trial.end.x_mm,
            trial.end.y_mm,
            trial.end.angle_deg,
            trial.end.placed,
            trial.time_s,
            trial.drops,
            trial.collisions,
            trial.clutches,
            trial.misses,
            trial.holds,
        )
        for k, trial in enumerate(trials)
    ]
    return CsvTable(COLUMNS, np.array(rows, dtype=float))
