"""The experiment "network": the visual operator places the block over eight networks, one factor at a time."""

from collections.abc import Mapping, Sequence

import numpy as np

from lab.experiments.placing.network import Network
from lab.experiments.placing.plots import network_plot
from lab.experiments.placing.trial import Conditions, TrialResult
from lab.experiments.placing.trials import Results, csv, summary
from lab.experiments.report import ExperimentReport, Figures, rounded

FIRST_SEED, TRIALS = 3001, 10  # seeds that no parameter was chosen on
QUICK_SEEDS = (1,)
NETWORKS: Mapping[str, Network] = {
    "0_ms": Network(),
    "40_ms": Network(delay_ms=40.0),
    "80_ms": Network(delay_ms=80.0),
    "120_ms": Network(delay_ms=120.0),
    "1_percent_lost": Network(loss=0.01),
    "3_percent_lost": Network(loss=0.03),
    "5_mbit_s": Network(mbit_s=5.0),
    "2_mbit_s": Network(mbit_s=2.0),
}
TEXT = (
    'The task of the experiment "placing", with the roll fixed and the silhouette tracker, over a network between both '
    "sites: 0 to 120 ms each way, 1 and 3 % of the packets lost, 5 and 2 Mbit/s, one factor at a time, the others "
    "without bounds. Hand samples and states are packets that may be lost. Pictures are a stream of packets at the "
    "link's rate, in which a lost one is sent again a round trip later and what finds 100 ms or 64 kB waiting is "
    "dropped; codec, quality, size and rate follow the console's reports, as at a site. The operator waits for the end "
    "of each movement as much longer as the page says that samples are on their way. The network is a model on stepped "
    "time, with a congestion control that knows the link; how the transport itself does over such links is measured by "
    "the bench for networks. Each trial starts from the same places of the block on all networks."
)


def network_report(results: Results) -> ExperimentReport:
    """Report the outcome of the trials."""
    trials = {name: [results[each] for each in results if each.network == of] for name, of in NETWORKS.items()}
    ours: Figures = {name: _figures(of) for name, of in trials.items()}
    return ExperimentReport(
        title="Placing a block over a network",
        text=TEXT,
        summary="\n".join(_in_words(name, of) for name, of in ours.items()),
        figures=ours,
        compared=ours,
        plots={"network": network_plot(NETWORKS, trials)},
        data={f"network_{name}": csv(of) for name, of in trials.items()},
    )


def network_conditions(quick: bool) -> list[Conditions]:
    """The trials, quick or in full."""
    seeds = QUICK_SEEDS if quick else range(FIRST_SEED, FIRST_SEED + TRIALS)
    return [Conditions("silhouette", True, seed, network=network) for network in NETWORKS.values() for seed in seeds]


def _figures(trials: Sequence[TrialResult]) -> Figures:
    ages = [trial.picture_age_ms for trial in trials if trial.picture_age_ms is not None]
    return {**summary(trials), "picture_age_ms": rounded(float(np.median(ages))) if ages else None}


def _in_words(name: str, of: Figures) -> str:
    x, y, angle, time_s = (of[figure]["median"] for figure in ("x_mm", "y_mm", "angle_deg", "time_s"))
    placed = f"placed {of['placed']} of {of['trials']}, {of['drops']} drops"
    return f"{name}: {placed}; medians {x} mm, {y} mm, {angle} deg, {time_s} s; pictures {of['picture_age_ms']} ms old"
