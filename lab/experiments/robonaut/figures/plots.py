"""Curves as in the ROBONAUT report's figures: motion from frame to frame, positions, errors, the finger's rectangle."""

from collections.abc import Mapping
from typing import TYPE_CHECKING

import numpy as np

from common.geometry import Array
from farhand.reports.plotting import MEASURED, TRUE, describe_panel, panels, png, widen
from lab.experiments.robonaut.errors import MM, motions, true_and_measured
from lab.experiments.robonaut.footage import Tracked
from local_site.simulation.hazel import JOINTS

if TYPE_CHECKING:
    from matplotlib.axes import Axes

FIRST_FRAMES = 100
MIN_SPAN_MM, MIN_SPAN_DEG, MIN_SPAN_TIP_MM = 1.0, 1.0, 10.0
MOTIONS = (("shoulder moves", "along", "mm"), ("upper arm turns", "about", "deg"), ("forearm turns", "about", "deg"))
ERROR, MEAN = {**MEASURED, "label": "error"}, {"label": "mean", "color": "#6e6e6e", "linestyle": "--", "linewidth": 0.9}


def motion_plot(tracked: Tracked, title: str) -> bytes:
    """The nine components of motion from frame to frame, in the camera's frame, as PNG."""
    true, measured = motions(tracked)
    figure, axes = panels(title, 3, 3, sharex=True)
    for k, panel in enumerate(axes.flat):
        what, preposition, unit = MOTIONS[k // 3]
        _compare(panel, true[:, k], measured[:, k], MIN_SPAN_MM if unit == "mm" else MIN_SPAN_DEG)
        describe_panel(panel, f"{what} {preposition} {'xyz'[k % 3]}", f"{unit} per frame")
    return png(figure, axes, "frame")


def position_plot(tracked: Tracked) -> bytes:
    """The joints' positions in the first frames, in the camera's frame, as PNG (figure 11)."""
    title = f"Positions in the first {FIRST_FRAMES} frames (figure 11)"
    figure, axes = panels(title, 3, 3, sharex=True)
    for name, row in zip(JOINTS, axes, strict=True):
        true, measured = (MM * p[:FIRST_FRAMES] for p in true_and_measured(tracked, name))
        for k, panel in enumerate(row):
            _compare(panel, true[:, k], measured[:, k], MIN_SPAN_MM)
            describe_panel(panel, f"{name}, {'xyz'[k]}", "mm")
    return png(figure, axes, "frame")


def finger_plot(tracked: Tracked) -> bytes:
    """The finger tip on its rectangle as PNG (figure 15)."""
    true, measured = (MM * p for p in true_and_measured(tracked, "finger_tip"))
    figure, axes = panels("The finger tip on its rectangle (figure 15)", 2, sharex=True)
    for panel, k, title in zip(axes.flat, (1, 2), ("seen by the camera", "seen from above"), strict=True):
        panel.plot(true[:, 0], true[:, k], **TRUE)
        panel.plot(measured[:, 0], measured[:, k], **MEASURED)
        describe_panel(panel, title, f"{'xyz'[k]}, mm")
        widen(panel, MIN_SPAN_TIP_MM)
    axes[0, 0].invert_yaxis()  # the camera's y points down
    return png(figure, axes, "x, mm")


def error_plot(title: str, errors: Mapping[str, Array]) -> bytes:
    """Errors (N,) in mm by what they are of, as PNG."""
    figure, axes = panels(title, len(errors), sharex=True, sharey=True)
    for panel, (name, values) in zip(axes.flat, errors.items(), strict=True):
        mean = float(np.nanmean(values))
        panel.plot(values, **ERROR)
        panel.axhline(mean, **MEAN)
        describe_panel(panel, f"{name}: mean {mean:.2f} mm, largest {float(np.nanmax(values)):.2f} mm", "error, mm")
    axes[0, 0].set_ylim(0.0, max(axes[0, 0].get_ylim()[1], MIN_SPAN_MM))
    return png(figure, axes, "frame")


def _compare(panel: "Axes", true: Array, measured: Array, min_span: float) -> None:
    panel.plot(true, **TRUE)
    panel.plot(measured, **MEASURED)
    widen(panel, min_span)
