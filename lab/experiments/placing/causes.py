"""The experiment "causes": placing with one part altered at a time, to find what limits it."""

from collections.abc import Mapping, Sequence

from lab.experiments.placing.alterations import Part
from lab.experiments.placing.plots import causes_plot
from lab.experiments.placing.series import FIRST_SEED, FREE, ROLL_FIXED
from lab.experiments.placing.trial import Conditions, TrialResult
from lab.experiments.placing.trials import Results, csv, errors, summary
from lab.experiments.report import ExperimentReport, Figures

SEEDS = range(FIRST_SEED, FIRST_SEED + 4)  # the first trials of the experiment "placing"
QUICK_SEEDS = (1,)
CAUSES: Mapping[str, tuple[Part, ...]] = {
    "as_it_is": (),
    "exact_tracker": ("exact_tracker",),
    "exact_sight": ("exact_sight",),
    "exact_hand": ("exact_hand",),
    "unseen_turn": ("unseen_turn",),
    "thesis_fingers": ("thesis_fingers",),
    "thesis_fingers_unseen_turn": ("thesis_fingers", "unseen_turn"),
    "thesis_rate": ("thesis_rate",),
}
TEXT = (
    'The task of the experiment "placing" with the silhouette tracker, with one part altered at a time. Exact: '
    "cameras and tracker are left out and the arm is known as it is; the operator is told the poses instead of seeing "
    "them; its hand is without noise. Unseen turn: once the operator has grasped the block it no longer sees how the "
    "block is turned, turns its hand by what is missing, and trusts. Thesis fingers: to index and thumb are added a "
    "constant of 9.1 and 15.7 mm in a direction by chance, and a slow wander of 5.8 and 8.2 mm (standard deviation), "
    "as large as the thesis measured them. Thesis rate: five pictures a second, the mean of nine, and the limits that "
    "go with them, as in the shipped configurations local-thesis and remote-thesis; the operator knows that the arm "
    "comes 1.6 s later. All start from the same places of the block, those of the first trials of that experiment. "
    "Errors are of all trials, wherever the block was left."
)


def causes_report(results: Results) -> ExperimentReport:
    """Report the outcome of the trials."""
    trials = {
        rolls: {name: _of(results, rolls, altered) for name, altered in CAUSES.items()} for rolls in (ROLL_FIXED, FREE)
    }
    ours: Figures = {rolls: {name: _figures(of) for name, of in by_name.items()} for rolls, by_name in trials.items()}
    return ExperimentReport(
        title="What limits placing, and why it failed",
        text=TEXT,
        summary="\n".join(_in_words(rolls, name, of) for rolls in ours for name, of in ours[rolls].items()),
        figures=ours,
        compared=ours,
        plots={"causes": causes_plot(trials)},
        data={f"causes_{rolls}_{name}": csv(of) for rolls in trials for name, of in trials[rolls].items()},
    )


def causes_conditions(quick: bool) -> list[Conditions]:
    """The trials, quick or in full."""
    return [
        Conditions("silhouette", fixed, seed, altered)
        for seed in (QUICK_SEEDS if quick else SEEDS)
        for altered in CAUSES.values()
        for fixed in (True, False)
    ]


def _of(results: Mapping[Conditions, TrialResult], rolls: str, altered: tuple[Part, ...]) -> list[TrialResult]:
    """The results under one condition, by their seeds."""
    wanted = altered, rolls == ROLL_FIXED
    return [result for each, result in results.items() if (each.altered, each.roll_fixed) == wanted]


def _figures(trials: Sequence[TrialResult]) -> Figures:
    """The summary, with the errors of all trials: a block that failed tells most."""
    return {**summary(trials), **errors([trial.end for trial in trials])}


def _in_words(rolls: str, name: str, of: Figures) -> str:
    x, y, angle, time_s = (of[figure]["median"] for figure in ("x_mm", "y_mm", "angle_deg", "time_s"))
    placed = f"placed {of['placed']} of {of['trials']}, {of['drops']} drops"
    return f"{rolls}, {name}: {placed}; medians {x} mm, {y} mm, {angle} deg, {time_s} s"
