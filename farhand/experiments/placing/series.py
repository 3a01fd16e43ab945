"""The experiment "placing": the scripted visual operator places the thesis's block, 20 times under each condition."""

import multiprocessing
from collections.abc import Mapping, Sequence
from concurrent.futures import ProcessPoolExecutor, as_completed
from os import cpu_count

import cv2
import numpy as np

from common.geometry import Array
from farhand.experiments.placing.plots import placing_plot
from farhand.experiments.placing.trial import Conditions, Exact, TrialResult, run_trial
from farhand.experiments.report import CsvTable, ExperimentReport, Figures, Progress, rounded
from local_site.tracking.config import Method

ROLL_FIXED, FREE = "roll_fixed", "free"
METHODS: tuple[Method, ...] = ("silhouette", "markers")
FIRST_SEED, TRIALS = 2001, 20  # seeds that no parameter was chosen on
EXACT: tuple[Exact, ...] = ("tracker", "sight", "hand")
QUICK_SEEDS = (1, 2)
COLUMNS = (
    "seed",
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
# Means of the thesis's tables 6.12 and 6.13, and of the marker-based system before it.
THESIS: Mapping[str, Mapping[str, Figures]] = {
    ROLL_FIXED: {
        "silhouette": {"x_mm": 11.6, "y_mm": 11.4, "angle_deg": 11.0},
        "markers": {"x_mm": 1.6, "y_mm": 8.5, "angle_deg": 3.2},
    },
    FREE: {"silhouette": {"x_mm": 33.7, "y_mm": 29.0, "angle_deg": 30.0}},
}
TEXT = (
    "A scripted visual operator, which is no person, stands the block on the table with its marked corner on the "
    "target's corner, edge along edge. It sees the page and nothing else: the four published views as they are decoded "
    "from the link, 60 ms old, ten times a second, with their calibration, and state, reason and gripper. It moves a "
    "rendered arm before two cameras at 30 pictures a second; the tracker measures it, and mapping, guard, driver and "
    "the simulated cell do what they do at any site. Its limits: a reaction of 250 ms, a hand of minimum jerk with a "
    "peak of 0.3 m/s, a noise of 2 mm and 1.5 degrees, a room for the hand of 22 by 27 by 29 cm, beyond which it uses "
    "the clutch. The block starts anywhere in a disc of 150 mm, turned by up to 30 degrees. Errors are read from the "
    "simulation afterwards, of all trials in which the block was placed: it stands free on the table, within 20 mm and "
    "10 degrees. In full, the series with the silhouette tracker is repeated with one part replaced by the truth: the "
    "tracker, the operator's sight, or its hand, then without noise. "
    "The thesis's figures are means over five and three trials of one person."
)


def trial_count(quick: bool) -> int:
    """How many trials are run, for a progress bar."""
    return len(_conditions(quick))


def placing_report(quick: bool, progress: Progress) -> ExperimentReport:
    """Run the experiment on all processors; always the same for the same installation."""
    results = _run_all(_conditions(quick), progress)
    trials = {rolls: {method: _of(results, rolls, method) for method in METHODS} for rolls in (ROLL_FIXED, FREE)}
    ours: Figures = {
        rolls: {method: _summary(of) for method, of in by_method.items()} for rolls, by_method in trials.items()
    }
    return ExperimentReport(
        title="Placing a block through pixels",
        text=TEXT,
        summary="\n".join(_in_words(rolls, method, of) for rolls in ours for method, of in ours[rolls].items()),
        figures=ours,
        compared={**{f"thesis, {rolls}": dict(of) for rolls, of in THESIS.items()}, **ours, **_exact_parts(results)},
        plots={"placing": placing_plot(trials)},
        data={f"placing_{rolls}_{method}": _csv(of) for rolls in trials for method, of in trials[rolls].items()},
    )


def _conditions(quick: bool) -> list[Conditions]:
    seeds = QUICK_SEEDS if quick else range(FIRST_SEED, FIRST_SEED + TRIALS)
    both = (True, False)
    series = [Conditions(method, fixed, seed) for method in METHODS for fixed in both for seed in seeds]
    parts = [] if quick else [Conditions(METHODS[0], f, seed, part) for part in EXACT for f in both for seed in seeds]
    return series + parts


def _run_all(conditions: Sequence[Conditions], progress: Progress) -> dict[Conditions, TrialResult]:
    context = multiprocessing.get_context("spawn")
    with ProcessPoolExecutor(
        cpu_count() or 1, mp_context=context, initializer=cv2.setNumThreads, initargs=(1,)
    ) as pool:
        running = {pool.submit(run_trial, each): each for each in conditions}
        try:
            for future in as_completed(running):
                future.result()
                progress()
        finally:
            pool.shutdown(cancel_futures=True)
    return {each: future.result() for future, each in running.items()}


def _of(
    results: Mapping[Conditions, TrialResult], rolls: str, method: Method, exact: Exact | None = None
) -> list[TrialResult]:
    """The results under one condition, by their seeds."""
    wanted = method, rolls == ROLL_FIXED, exact
    chosen = (each for each in results if (each.method, each.roll_fixed, each.exact) == wanted)
    return [results[each] for each in sorted(chosen, key=lambda each: each.seed)]


def _exact_parts(results: Mapping[Conditions, TrialResult]) -> dict[str, Figures]:
    """The summaries with one part replaced by the truth; none in a quick run."""
    parts = {part: {rolls: _of(results, rolls, METHODS[0], part) for rolls in (ROLL_FIXED, FREE)} for part in EXACT}
    return {
        f"{rolls}, exact {part}": {METHODS[0]: _summary(trials)}
        for part, by_rolls in parts.items()
        for rolls, trials in by_rolls.items()
        if trials
    }


def _summary(trials: Sequence[TrialResult]) -> Figures:
    ended = [trial.end for trial in trials if trial.end.placed]
    errors = {
        "x_mm": np.abs([end.x_mm for end in ended]),
        "y_mm": np.abs([end.y_mm for end in ended]),
        "angle_deg": np.abs([end.angle_deg for end in ended]),
    }
    return {
        **{name: _quartiles(values) for name, values in errors.items()},
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


def _quartiles(values: Array) -> Figures:
    if not len(values):
        return {"median": None, "q1": None, "q3": None}
    q1, median, q3 = np.percentile(values, [25, 50, 75])
    return {"median": rounded(median), "q1": rounded(q1), "q3": rounded(q3)}


def _in_words(rolls: str, method: str, summary: Figures) -> str:
    x, y, angle, time_s = (summary[name]["median"] for name in ("x_mm", "y_mm", "angle_deg", "time_s"))
    placed = f"placed {summary['placed']} of {summary['trials']}, {summary['drops']} drops"
    return f"{rolls}, {method}: {placed}; medians {x} mm, {y} mm, {angle} deg, {time_s} s"


def _csv(trials: Sequence[TrialResult]) -> CsvTable:
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
