"""Plots of where the block was left, trial by trial, and of how long it took over each network."""

from collections.abc import Mapping, Sequence

import numpy as np

from farhand.reports.plotting import describe_panel, panels, png
from lab.experiments.placing.network import Network
from lab.experiments.placing.trial import TrialResult

COLOURS = {"silhouette": "#d72828", "markers": "#2864b4", "learned": "#287828", "assist": "#c88214"}
ERRORS = {"x_mm": "x, mm", "y_mm": "y, mm", "angle_deg": "angle, deg"}


def placing_plot(results: Mapping[str, Mapping[str, Sequence[TrialResult]]]) -> bytes:
    """A PNG of the errors of all placed trials, by the rotations that were free, and by the series' name."""
    figure, axes = panels("The placed block against the target", len(ERRORS), len(results), sharex=True, sharey="row")
    for column, (rolls, by_name) in zip(axes.T, results.items(), strict=True):
        for panel, (error, label) in zip(column, ERRORS.items(), strict=True):
            describe_panel(panel, rolls.replace("_", " "), label)
            panel.axhline(0.0, color="#6e6e6e", linewidth=0.8)
            for name, trials in by_name.items():
                placed = [(k + 1, getattr(t.end, error)) for k, t in enumerate(trials) if t.end.placed]
                panel.plot(*zip(*placed, strict=True), "o", label=name, color=COLOURS[name], markersize=4)
    return png(figure, axes, "trial")


def realtime_plot(results: Mapping[str, Mapping[str, Sequence[TrialResult]]]) -> bytes:
    """A PNG of errors and time of each trial, in real time and in lockstep, by the rotations that were free."""
    rows = {**ERRORS, "time_s": "time, s"}
    figure, axes = panels("The same trials in real time and in lockstep", len(rows), len(results), sharey="row")
    for column, (rolls, by_name) in zip(axes.T, results.items(), strict=True):
        for panel, (of, label) in zip(column, rows.items(), strict=True):
            describe_panel(panel, rolls.replace("_", " "), label)
            panel.margins(x=0.1)
            for (name, trials), colour in zip(by_name.items(), ("#d72828", "#2864b4"), strict=True):
                shown = [(k + 1, t.time_s if of == "time_s" else getattr(t.end, of)) for k, t in enumerate(trials)]
                points = [each for each, t in zip(shown, trials, strict=True) if t.end.placed or of == "time_s"]
                panel.plot(*np.array(points).reshape(-1, 2).T, "o", label=name.replace("_", " "), color=colour)
                panel.set_xticks(range(1, len(trials) + 1))
        column[-1].set_ylim(bottom=0)
    return png(figure, axes, "trial")


def network_plot(networks: Mapping[str, Network], results: Mapping[str, Sequence[TrialResult]]) -> bytes:
    """A PNG of time and success over the delay, and beside it with packets lost, and at a narrow rate."""
    figure, axes = panels("Placing a block over a network", 2, 2, sharex="col", sharey="row")
    delays = {name: of.delay_ms for name, of in networks.items() if not of.loss and of.mbit_s is None}
    others = {name: float(k) for k, name in enumerate(name for name in networks if name not in delays)}
    for column, at in zip(axes.T, (delays, others), strict=True):
        describe_panel(column[0], "time of a trial, its median and quartiles", "s")
        describe_panel(column[1], "placed", "%")
        times = {name: np.percentile([trial.time_s for trial in results[name]], [25, 50, 75]) for name in at}
        low, middle, high = np.array([times[name] for name in at]).T
        spread = [middle - low, high - middle]
        style = "o-" if at is delays else "o"
        column[0].errorbar(list(at.values()), middle, spread, fmt=style, color="#2864b4", capsize=3)
        placed = [100.0 * np.mean([trial.end.placed for trial in results[name]]) for name in at]
        column[1].plot(list(at.values()), placed, style, color="#2864b4", markersize=5)
        column[1].set_ylim(0, 105)
        column[0].set_ylim(bottom=0)
    axes[1, 1].set_xticks(list(others.values()), [_label(networks[name]) for name in others])
    axes[1, 1].set_xlim(-0.5, len(others) - 0.5)
    axes[1, 0].set_xticks(list(delays.values()))
    return png(figure, axes, "delay each way, ms (on the right none)")


def _label(network: Network) -> str:
    return f"{100 * network.loss:g} % lost" if network.loss else f"{network.mbit_s:g} Mbit/s"


def causes_plot(results: Mapping[str, Mapping[str, Sequence[TrialResult]]]) -> bytes:
    """A PNG of the errors of all trials without their sign, by what was altered."""
    figure, axes = panels("Placing with one part altered", len(ERRORS), len(results), sharex=True, sharey="row")
    for column, (rolls, by_name) in zip(axes.T, results.items(), strict=True):
        for panel, (error, label) in zip(column, ERRORS.items(), strict=True):
            describe_panel(panel, rolls.replace("_", " "), label)
            panel.set_yscale("symlog", linthresh=1.0)
            for k, trials in enumerate(by_name.values()):
                errors = np.abs([getattr(trial.end, error) for trial in trials])
                panel.plot([k] * len(errors), errors, "o", color="#2864b4", alpha=0.5, markersize=4)
        column[-1].set_xticks(
            range(len(by_name)), [name.replace("_", " ") for name in by_name], rotation=30, ha="right"
        )
    return png(figure, axes, "")
