"""The experiment "realtime": ten trials of "placing" repeated in wall-clock time, with all processes of both sites."""

from collections import Counter
from collections.abc import Mapping, Sequence

import numpy as np

from lab.experiments.placing.kept_trials import KeptTrials
from lab.experiments.placing.live.pace import LiveResult, Pace
from lab.experiments.placing.live.trial import run_live
from lab.experiments.placing.plots import realtime_plot
from lab.experiments.placing.series import FIRST_SEED, FREE, ROLL_FIXED
from lab.experiments.placing.trial import Conditions, TrialResult
from lab.experiments.placing.trials import csv, run_all, summary
from lab.experiments.report import CsvTable, ExperimentReport, Figures, Progress, rounded

REAL_TIME, LOCKSTEP = "real_time", "lockstep"
TRIALS = 5  # of each condition, all with seeds of their own, the first of the experiment "placing"
QUICK_SEED = 1
COUNTS = ("periods", "missed", "cell_late", "hand_late", "lost")
MEDIANS = ("hands_per_s", "command_ms", "picture_age_ms", "looks_per_s", "look_ms")
TEXT = (
    'Trials of the experiment "placing", with the silhouette tracker, in wall-clock time: the remote site with '
    "its processes for control, driver, simulated cell and video, the local site with its cameras, tracker and "
    "sampler, and the console run as they do anywhere, with Zenoh between them. The scripted visual operator is a "
    "process of its own before the console's page, over the page's own connection: it gets what a browser gets, "
    "holds the key, sets scales and locks, and moves the hand before the simulated cameras. Its sight is another "
    "process, so that key and hand stay in time while it looks. Where the block is, only the process of the "
    "simulated cell knows, and it tells that once it ends, after the operator has left. Beside it are trials of "
    "the same seeds in lockstep with simulated time. What came in real time depends on the machine, and is not "
    "the same again: missed control periods, the age of the pictures, samples and looks per second show whether "
    "it kept up."
)


def trial_count(quick: bool) -> int:
    """Count the trials that are run, in real time and in lockstep, for a progress bar."""
    return 2 * len(live_conditions(quick))


def realtime_report(quick: bool, progress: Progress, kept: KeptTrials) -> ExperimentReport:
    """Run the experiment: one trial after the other in wall-clock time, then in lockstep those that are not kept."""
    live: dict[Conditions, LiveResult] = {}
    for conditions in live_conditions(quick):
        live[conditions] = run_live(conditions)
        progress()
    stepped = run_all(live_conditions(quick), progress, kept)
    trials = {rolls: _both(live, stepped, rolls) for rolls in (ROLL_FIXED, FREE)}
    paces = {rolls: [of.pace for each, of in live.items() if _rolls(each) == rolls] for rolls in trials}
    ours: Figures = {
        rolls: {**{name: summary(of) for name, of in by_name.items()}, "pace": pace_figures(paces[rolls])}
        for rolls, by_name in trials.items()
        if paces[rolls]
    }
    return ExperimentReport(
        title="Placing a block in real time",
        text=TEXT,
        summary="\n".join(_in_words(rolls, of) for rolls, of in ours.items()),
        figures=ours,
        compared=_compared(ours),
        plots={"realtime": realtime_plot({rolls: trials[rolls] for rolls in ours})},
        data={
            **{f"{name}_{rolls}": csv(trials[rolls][name]) for rolls in ours for name in (REAL_TIME, LOCKSTEP)},
            **{f"pace_{rolls}": _pace_csv(paces[rolls]) for rolls in ours},
        },
    )


def live_conditions(quick: bool) -> list[Conditions]:
    """The trials, quick or in full."""
    if quick:
        return [Conditions("silhouette", True, QUICK_SEED)]
    return [Conditions("silhouette", k < TRIALS, FIRST_SEED + k) for k in range(2 * TRIALS)]


def _rolls(conditions: Conditions) -> str:
    return ROLL_FIXED if conditions.roll_fixed else FREE


def _both(
    live: Mapping[Conditions, LiveResult], stepped: Mapping[Conditions, TrialResult], rolls: str
) -> dict[str, list[TrialResult]]:
    """The trials under one condition, by their seeds."""
    chosen = [each for each in live if _rolls(each) == rolls]
    return {REAL_TIME: [live[each].trial for each in chosen], LOCKSTEP: [stepped[each] for each in chosen]}


def pace_figures(paces: Sequence[Pace]) -> Figures:
    """Sums of what is counted, and medians over the trials of what is measured."""
    counted = {name: sum(getattr(pace, name) for pace in paces) for name in COUNTS}
    measured = {name: rounded(np.median([getattr(pace, name) for pace in paces])) for name in MEDIANS}
    missed = rounded(100 * counted["missed"] / max(1, counted["periods"]))
    reasons = sum((Counter(pace.reasons) for pace in paces), Counter[str]())
    return {**counted, "missed_percent": missed, **measured, "looks_by_reason": dict(reasons.most_common())}


def _pace_csv(paces: Sequence[Pace]) -> CsvTable:
    rows = [(k + 1, *(getattr(pace, name) for name in (*COUNTS, *MEDIANS))) for k, pace in enumerate(paces)]
    return CsvTable(("trial", *COUNTS, *MEDIANS), np.array(rows, dtype=float))


def _compared(ours: Figures) -> Figures:
    """A column for each series; the machine's pace is with the trials in real time."""
    columns: Figures = {}
    for rolls, of in ours.items():
        columns[f"{rolls}, real time"] = {**of[REAL_TIME], "pace": of["pace"]}
        columns[f"{rolls}, lockstep"] = of[LOCKSTEP]
    return columns


def _in_words(rolls: str, of: Figures) -> str:
    pace, lines = of["pace"], []
    for name in (REAL_TIME, LOCKSTEP):
        x, y, angle, time_s = (of[name][figure]["median"] for figure in ("x_mm", "y_mm", "angle_deg", "time_s"))
        placed = f"placed {of[name]['placed']} of {of[name]['trials']}, {of[name]['drops']} drops"
        lines.append(f"{rolls}, {name}: {placed}; medians {x} mm, {y} mm, {angle} deg, {time_s} s")
    kept = f"{pace['missed']} of {pace['periods']} control periods missed, pictures {pace['picture_age_ms']:.0f} ms old"
    looks = f"{pace['hands_per_s']:.1f} hand samples and {pace['looks_per_s']:.1f} looks a second"
    return "\n".join([*lines, f"{rolls}: {kept}, {looks}"])
