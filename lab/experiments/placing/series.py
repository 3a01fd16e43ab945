"""The experiment "placing": the scripted visual operator places the thesis's block, 20 times under each condition."""

from collections.abc import Mapping

from lab.experiments.placing.plots import placing_plot
from lab.experiments.placing.tracked_operator import is_installed
from lab.experiments.placing.trial import Conditions, TrialResult
from lab.experiments.placing.trials import Results, csv, summary
from lab.experiments.report import ExperimentReport, Figures

ROLL_FIXED, FREE = "roll_fixed", "free"
# What a series is called: by its tracker, and whether the operator lets the robot do the last of the way.
SERIES: Mapping[str, tuple[str, bool]] = {
    "silhouette": ("silhouette", False),
    "markers": ("markers", False),
    "learned": ("learned", False),
    "assist": ("silhouette", True),
}
FIRST_SEED, TRIALS = 3001, 20  # seeds that no parameter was chosen on
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
    "target's corner, edge along edge. It sees the page and nothing else: the four published views as they are "
    "decoded from the link, 60 ms old, ten times a second, with their calibration, and state, reason and gripper. It "
    "moves a rendered arm before two cameras at 30 pictures a second; the tracker measures it, and mapping, guard, "
    "driver and the simulated cell do what they do at any site. Its limits: a reaction of 250 ms, a hand of minimum "
    "jerk with a peak of 0.3 m/s, a noise of 2 mm and 1.5 degrees, a room for the hand of 22 by 27 by 29 cm, beyond "
    "which it uses the clutch. The block starts anywhere in a disc of 150 mm, turned by up to 30 degrees. Errors are "
    "read from the simulation afterwards, of all trials in which the block was placed: it stands free on the table, "
    'within 20 mm and 10 degrees. In the series "learned" the arm is in colour, in an office that the operator enters '
    'after 1.5 s; without that tracker\'s models it is left out. In the series "assist" the cell has two markers, and '
    "the operator holds the key A where the page offers to lead the tool: to the grasp, and to the place. The thesis's "
    "figures are means over five and three trials of one person."
)


def placing_report(results: Results) -> ExperimentReport:
    """Report the outcome of the trials."""
    run = [name for name, (method, _) in SERIES.items() if any(each.method == method for each in results)]
    trials = {rolls: {name: _of(results, rolls, name) for name in run} for rolls in (ROLL_FIXED, FREE)}
    ours: Figures = {rolls: {name: summary(of) for name, of in by_name.items()} for rolls, by_name in trials.items()}
    return ExperimentReport(
        title="Placing a block through pixels",
        text=TEXT,
        summary="\n".join(_in_words(rolls, name, of) for rolls in ours for name, of in ours[rolls].items()),
        figures=ours,
        compared={**{f"thesis, {rolls}": dict(of) for rolls, of in THESIS.items()}, **ours},
        plots={"placing": placing_plot(trials)},
        data={f"placing_{rolls}_{name}": csv(of) for rolls in trials for name, of in trials[rolls].items()},
    )


def placing_conditions(quick: bool) -> list[Conditions]:
    """The trials, quick or in full, of all trackers that are installed."""
    seeds = QUICK_SEEDS if quick else range(FIRST_SEED, FIRST_SEED + TRIALS)
    series = [(method, led) for method, led in SERIES.values() if is_installed(method)]
    return [Conditions(method, f, s, assist=led) for method, led in series for f in (True, False) for s in seeds]


def _of(results: Mapping[Conditions, TrialResult], rolls: str, name: str) -> list[TrialResult]:
    """The results under one condition, by their seeds."""
    wanted = *SERIES[name], rolls == ROLL_FIXED
    chosen = (each for each in results if (each.method, each.assist, each.roll_fixed) == wanted)
    return [results[each] for each in sorted(chosen, key=lambda each: each.seed)]


def _in_words(rolls: str, name: str, of: Figures) -> str:
    x, y, angle, time_s = (of[name]["median"] for name in ("x_mm", "y_mm", "angle_deg", "time_s"))
    placed = f"placed {of['placed']} of {of['trials']}, {of['drops']} drops"
    return f"{rolls}, {name}: {placed}; medians {x} mm, {y} mm, {angle} deg, {time_s} s"
