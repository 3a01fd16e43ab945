"""Plots that correspond to figures 10, 11, 12, 15 and 16 of the ROBONAUT report, in the camera's frame."""

from collections.abc import Mapping
from typing import TYPE_CHECKING

import numpy as np

from common.geometry import Array
from farhand.experiments.hazel_figures import JOINTS, MM, errors_mm, lengths, motions, true_and_measured
from farhand.experiments.hazel_filming import Tracked
from farhand.experiments.plotting import MEASURED, TRUE, describe_panel, panels, plot_frames, png, widen

if TYPE_CHECKING:
    from matplotlib.axes import Axes

FIRST_FRAMES = 100
MIN_SPAN_MM, MIN_SPAN_DEG, MIN_SPAN_TIP_MM = 1.0, 1.0, 10.0
MOTIONS = (("shoulder moves", "along", "mm"), ("upper arm turns", "about", "deg"), ("forearm turns", "about", "deg"))
ERROR, MEAN = {**MEASURED, "label": "error"}, {"label": "mean", "color": "#6e6e6e", "linestyle": "--", "linewidth": 0.9}


def hazel_plots(swing: Tracked, pointing: Tracked) -> Mapping[str, bytes]:
    """The plots of HAZEL-S (`swing`) and HAZEL-C (`pointing`) as PNG, by file name without extension."""
    return {
        "figure_10_motion": _motion_plot(swing),
        "figure_11_positions": _position_plot(swing),
        "figure_12_errors": _error_plot(
            "Position errors (figure 12)", {name: lengths(errors_mm(swing, name)) for name in JOINTS}
        ),
        "figure_15_finger_tip": _finger_plot(pointing),
        "figure_16_finger_errors": _finger_error_plot(pointing),
    }


def _motion_plot(tracked: Tracked) -> bytes:
    true, measured = motions(tracked)
    figure, axes = panels("Motion from frame to frame (figure 10)", 3, 3, sharex=True)
    for k, panel in enumerate(axes.flat):
        what, preposition, unit = MOTIONS[k // 3]
        _compare(panel, true[:, k], measured[:, k], MIN_SPAN_MM if unit == "mm" else MIN_SPAN_DEG)
        describe_panel(panel, f"{what} {preposition} {'xyz'[k % 3]}", f"{unit} per frame")
    return png(figure, axes, "frame")


def _position_plot(tracked: Tracked) -> bytes:
    figure, axes = panels(f"Positions in the first {FIRST_FRAMES} frames (figure 11)", 3, 3, sharex=True)
    for name, row in zip(JOINTS, axes, strict=True):
        true, measured = (MM * p[:FIRST_FRAMES] for p in true_and_measured(tracked, name))
        for k, panel in enumerate(row):
            _compare(panel, true[:, k], measured[:, k], MIN_SPAN_MM)
            describe_panel(panel, f"{name}, {'xyz'[k]}", "mm")
    return png(figure, axes, "frame")


def _finger_plot(tracked: Tracked) -> bytes:
    true, measured = (MM * p for p in true_and_measured(tracked, "finger_tip"))
    figure, axes = panels("The finger tip on its rectangle (figure 15)", 2, sharex=True)
    for panel, k, title in zip(axes.flat, (1, 2), ("seen by the camera", "seen from above"), strict=True):
        panel.plot(true[:, 0], true[:, k], **TRUE)
        panel.plot(measured[:, 0], measured[:, k], **MEASURED)
        describe_panel(panel, title, f"{'xyz'[k]}, mm")
        widen(panel, MIN_SPAN_TIP_MM)
    axes[0, 0].invert_yaxis()  # the camera's y points down
    return png(figure, axes, "x, mm")


def _finger_error_plot(tracked: Tracked) -> bytes:
    errors_xyz = errors_mm(tracked, "finger_tip")
    errors = {f"along {axis}": np.abs(errors_xyz[:, k]) for k, axis in enumerate("xyz")}
    return _error_plot("Errors of the finger tip (figure 16)", errors | {"distance": lengths(errors_xyz)})


def _error_plot(title: str, errors: Mapping[str, Array]) -> bytes:
    figure, axes = panels(title, len(errors), sharex=True, sharey=True)
    for panel, (name, values) in zip(axes.flat, errors.items(), strict=True):
        mean = float(np.nanmean(values))
        plot_frames(panel, values, **ERROR)
        panel.axhline(mean, **MEAN)
        describe_panel(panel, f"{name}: mean {mean:.2f} mm, largest {float(np.nanmax(values)):.2f} mm", "error, mm")
    axes[0, 0].set_ylim(0.0, max(axes[0, 0].get_ylim()[1], MIN_SPAN_MM))
    return png(figure, axes, "frame")


def _compare(panel: "Axes", true: Array, measured: Array, min_span: float) -> None:
    plot_frames(panel, true, **TRUE)
    plot_frames(panel, measured, **MEASURED)
    widen(panel, min_span)
