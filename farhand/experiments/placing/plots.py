"""Where the block's marked corner was left, trial by trial, and how far its edges were off."""

from collections.abc import Mapping, Sequence

from farhand.experiments.placing.trial import TrialResult
from farhand.reports.plotting import describe_panel, panels, png
from local_site.tracking.config import Method

COLOURS = {"silhouette": "#d72828", "markers": "#2864b4", "learned": "#287828"}
ERRORS = {"x_mm": "x, mm", "y_mm": "y, mm", "angle_deg": "angle, deg"}


def placing_plot(results: Mapping[str, Mapping[Method, Sequence[TrialResult]]]) -> bytes:
    """A PNG of the errors of all placed trials, by the rotations that were free, and by the tracker's name."""
    figure, axes = panels("The placed block against the target", len(ERRORS), len(results), sharex=True, sharey="row")
    for column, (rolls, by_method) in zip(axes.T, results.items(), strict=True):
        for panel, (error, label) in zip(column, ERRORS.items(), strict=True):
            describe_panel(panel, rolls.replace("_", " "), label)
            panel.axhline(0.0, color="#6e6e6e", linewidth=0.8)
            for method, trials in by_method.items():
                placed = [(k + 1, getattr(t.end, error)) for k, t in enumerate(trials) if t.end.placed]
                panel.plot(*zip(*placed, strict=True), "o", label=method, color=COLOURS[method], markersize=4)
    return png(figure, axes, "trial")
