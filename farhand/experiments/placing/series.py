"""The experiment "placing": the scripted visual operator places the thesis's block, 20 times under each condition."""

from collections.abc import Mapping

from farhand.experiments.placing.plots import placing_plot
from farhand.experiments.placing.trial import Conditions, Exact, TrialResult
from farhand.experiments.placing.trials import csv, run_all, summary
from farhand.experiments.report import ExperimentReport, Figures, Progress
from local_site.tracking.config import Method

ROLL_FIXED, FREE = "roll_fixed", "free"
METHODS: tuple[Method, ...] = ("silhouette", "markers")
FIRST_SEED, TRIALS = 2001, 20  # seeds that no parameter was chosen on
EXACT: tuple[Exact, ...] = ("tracker", "sight", "hand")
QUICK_SEEDS = (1, 2)
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
    results = run_all(_conditions(quick), progress)
    trials = {rolls: {method: _of(results, rolls, method) for method in METHODS} for rolls in (ROLL_FIXED, FREE)}
    ours: Figures = {
        rolls: {method: summary(of) for method, of in by_method.items()} for rolls, by_method in trials.items()
    }
    return ExperimentReport(
        title="Placing a block through pixels",
        text=TEXT,
        summary="\n".join(_in_words(rolls, method, of) for rolls in ours for method, of in ours[rolls].items()),
        figures=ours,
        compared={**{f"thesis, {rolls}": dict(of) for rolls, of in THESIS.items()}, **ours, **_exact_parts(results)},
        plots={"placing": placing_plot(trials)},
        data={f"placing_{rolls}_{method}": csv(of) for rolls in trials for method, of in trials[rolls].items()},
    )


def _conditions(quick: bool) -> list[Conditions]:
    seeds = QUICK_SEEDS if quick else range(FIRST_SEED, FIRST_SEED + TRIALS)
    both = (True, False)
    series = [Conditions(method, fixed, seed) for method in METHODS for fixed in both for seed in seeds]
    parts = [] if quick else [Conditions(METHODS[0], f, seed, part) for part in EXACT for f in both for seed in seeds]
    return series + parts


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
        f"{rolls}, exact {part}": {METHODS[0]: summary(trials)}
        for part, by_rolls in parts.items()
        for rolls, trials in by_rolls.items()
        if trials
    }


def _in_words(rolls: str, method: str, of: Figures) -> str:
    x, y, angle, time_s = (of[name]["median"] for name in ("x_mm", "y_mm", "angle_deg", "time_s"))
    placed = f"placed {of['placed']} of {of['trials']}, {of['drops']} drops"
    return f"{rolls}, {method}: {placed}; medians {x} mm, {y} mm, {angle} deg, {time_s} s"
