"""The plots of figures 10, 11, 12, 15 and 16 of the ROBONAUT report."""

from collections.abc import Mapping

import numpy as np

from common.cameras.camera import Image
from common.geometry import Array
from farhand.experiments.charts import Line, Panel, common_range, figure
from farhand.experiments.hazel_figures import FINGER_REACH_M, JOINTS, MM, joint_errors, lengths, motions
from farhand.experiments.hazel_filming import Tracked, joints
from local_site.simulation.hazel import FOREARM_M

TRUE, MEASURED = (40, 40, 40), (40, 40, 215)
FIRST_FRAMES = 100
MOTIONS = (
    *(f"shoulder, {axis}, mm" for axis in "xyz"),
    *(f"{link} turn about {axis}, deg" for link in ("upper arm", "forearm") for axis in "xyz"),
)


def hazel_plots(synthetic: Tracked, pointing: Tracked) -> Mapping[str, Image]:
    """All plots by the name of their file."""
    return {
        "figure_10_motion": _motion_plot(synthetic),
        "figure_11_positions": _position_plot(synthetic),
        "figure_12_errors": _error_plot(synthetic),
        "figure_15_finger_tip": _finger_plot(pointing),
        "figure_16_finger_errors": _finger_error_plot(pointing),
    }


def _motion_plot(tracked: Tracked) -> Image:
    true, measured = motions(tracked)
    panels = [_panel(name, "frame", name, true[:, k], measured[:, k]) for k, name in enumerate(MOTIONS)]
    return figure("Motion from frame to frame (figure 10)", [panels[k : k + 3] for k in (0, 3, 6)])


def _position_plot(tracked: Tracked) -> Image:
    rows = []
    for name in JOINTS:
        true, measured = (MM * joints(arms, name, FOREARM_M)[:FIRST_FRAMES] for arms in (tracked.arms, tracked.poses))
        rows.append(
            [
                _panel(f"{name}, {axis}", "frame", f"{axis}, mm", true[:, k], measured[:, k])
                for k, axis in enumerate("xyz")
            ]
        )
    return figure("Positions in the first 100 frames (figure 11)", rows)


def _error_plot(tracked: Tracked) -> Image:
    panels = [_errors(name, lengths(joint_errors(tracked, name))) for name in JOINTS]
    return figure("Position errors (figure 12)", [[panel] for panel in panels])


def _finger_plot(tracked: Tracked) -> Image:
    true, measured = (MM * joints(arms, "", FINGER_REACH_M) for arms in (tracked.arms, tracked.poses))
    # The picture's y runs down.
    views = (("y", -true[:, 1], -measured[:, 1]), ("z", true[:, 2], measured[:, 2]))
    panels = [
        Panel(
            title=f"finger tip, x and {axis}",
            x_label="x, mm",
            y_label=f"{'-' if axis == 'y' else ''}{axis}, mm",
            lines=_lines(true[:, 0], down, measured[:, 0], found),
            x_range=common_range([true[:, 0], measured[:, 0]], 10.0),
            y_range=common_range([down, found], 10.0),
        )
        for axis, down, found in views
    ]
    return figure("The finger tip on its rectangle (figure 15)", [[panel] for panel in panels])


def _finger_error_plot(tracked: Tracked) -> Image:
    true, measured = (MM * joints(arms, "", FINGER_REACH_M) for arms in (tracked.arms, tracked.poses))
    off = measured - true
    panels = [_errors(f"finger tip along {axis}", np.abs(off[:, k])) for k, axis in enumerate("xyz")]
    return figure(
        "Errors of the finger tip (figure 16)", [panels[:2], [panels[2], _errors("finger tip", lengths(off))]]
    )


def _panel(title: str, x_label: str, y_label: str, true: Array, measured: Array) -> Panel:
    frames = np.arange(len(true), dtype=np.float64)
    return Panel(
        title=title,
        x_label=x_label,
        y_label=y_label,
        lines=_lines(frames, true, frames, measured),
        x_range=(0.0, float(len(true))),
        y_range=common_range([true, measured], 1.0),
    )


def _lines(true_x: Array, true_y: Array, measured_x: Array, measured_y: Array) -> tuple[Line, ...]:
    return Line("true", TRUE, 3, true_x, true_y), Line("measured", MEASURED, 1, measured_x, measured_y)


def _errors(name: str, errors_mm: Array) -> Panel:
    frames = np.arange(len(errors_mm), dtype=np.float64)
    mean = float(np.nanmean(errors_mm))
    return Panel(
        title=f"{name}: mean {mean:.2f} mm",
        x_label="frame",
        y_label="error, mm",
        lines=(Line("error", MEASURED, 1, frames, errors_mm),),
        x_range=(0.0, float(len(errors_mm))),
        y_range=(0.0, max(1.05 * float(np.nanmax(errors_mm)), 1.0)),
    )
