"""The experiment "calibration": the thesis's plate of 25 discs at three heights, its DLT, and Farhand's own ways."""

from collections.abc import Mapping
from dataclasses import dataclass

import numpy as np

from common.geometry import Array
from farhand.reports.plotting import describe_panel, panels, png
from lab.experiments.report import CsvTable, ExperimentReport, Figures, Progress, rounded
from lab.experiments.thesis.calibration_rigs import (
    PlateScene,
    aligned,
    board_rig,
    dlt_points,
    every,
    film_plate,
    measured_to,
    rig_points,
)
from lab.experiments.thesis.tables import COLUMNS, MM, ratios, with_total
from local_site.calibration.solve import solve_rig
from local_site.simulation.cameras import PLATE_HEIGHTS_M

LENSES = {"no distortion": 0.0, "k1 = -0.1": -0.1}
POSES, QUICK_POSES = 15, 6
THIRD = 3
MEASURED_MM = 1.0
DLT_25, DLT_75, DLT_MEASURED = "DLT, 25 discs", "DLT, 75 discs", f"DLT, 25 discs known to {MEASURED_MM:g} mm"
PLATE_RIG, BOARD_RIG = "Farhand, 75 discs", "Farhand, chessboard"
COLUMN_OF = {
    DLT_25: "dlt_25",
    DLT_75: "dlt_75",
    DLT_MEASURED: "dlt_25_measured",
    PLATE_RIG: "farhand_plate",
    BOARD_RIG: "farhand_board",
}
THESIS_MM = dict(zip(COLUMNS, (2.6, 4.4, 3.6, 7.2), strict=True))
COLOURS = ("#282828", "#d72828", "#e6823c", "#c8aa32", "#2878c8", "#288c28")
DOTS = {"label": "centroid found", "color": "#d72828", "marker": ".", "markersize": 3.0, "linestyle": "none"}
TEXT = (
    "A plate of 25 discs is filmed at three heights by two simulated cameras that see the whole volume of 1000 x 1000 "
    "x 994 mm, once through lenses without distortion and once through slightly barrelled ones. The errors are those "
    "of the 75 discs, triangulated from the centroids found in the pictures, as mean absolute values. As in the "
    "thesis, the DLT is solved from 25 of the 75 discs (every third), and from all. Its linear cameras cannot follow "
    "a distorted lens; farhand calibrate fits the lens with the camera. A printed board sets a frame of its own, so "
    "that its points are first laid over the true ones by a rigid motion. The simulated plate is exact and so are its "
    "heights: a real plate's own errors are added, and one column shows discs known to 1 mm along each axis. "
    "The thesis does not say how exactly its plate was known, so that its error is not that of its method alone."
)

Errors = Mapping[str, Array]


@dataclass(frozen=True, slots=True)
class LensRun:
    """The plate filmed through one lens, and the errors (N, 3) in mm of its discs by each method."""

    scene: PlateScene
    errors_mm: Errors


def frame_count(quick: bool) -> int:
    """Count the instants that are filmed, for a progress bar."""
    return len(LENSES) * (2 * len(PLATE_HEIGHTS_M) + _poses(quick))


def calibration_report(quick: bool, progress: Progress) -> ExperimentReport:
    """Run the experiment; always the same for the same installation."""
    runs = {lens: _run(k1, _poses(quick), progress) for lens, k1 in LENSES.items()}
    compared: dict[str, Figures] = {"thesis": dict.fromkeys(LENSES, _with_ratio(THESIS_MM))}
    for method in COLUMN_OF:
        compared[method] = {lens: _with_ratio(_means(run.errors_mm[method])) for lens, run in runs.items()}
    return ExperimentReport(
        title="Calibration by a plate of discs",
        text=TEXT,
        summary="\n".join(f"{method}: {_in_words(figures)}" for method, figures in compared.items()),
        figures={"experiment": "calibration", "quick": quick, "runs": compared},
        compared=compared,
        plots={
            "figure_3_25_plate": _plate_plot(runs["no distortion"].scene),
            "errors": _error_plot(compared),
        },
        data={f"calibration_{name}": _csv(run) for name, run in zip(("pinhole", "barrel"), runs.values(), strict=True)},
    )


def _poses(quick: bool) -> int:
    return QUICK_POSES if quick else POSES


def _run(k1: float, poses: int, progress: Progress) -> LensRun:
    """Film plate and board through one lens, calibrate in every way, and triangulate the discs."""
    scene = film_plate(k1, progress)
    found, centred = scene.found, scene.centred
    by_board = rig_points(board_rig(scene.cameras, poses, progress), centred)
    points = {
        DLT_25: dlt_points(every(found, THIRD), found),
        DLT_75: dlt_points(found, found),
        DLT_MEASURED: dlt_points(every(measured_to(found, MEASURED_MM), THIRD), found),
        PLATE_RIG: rig_points(solve_rig(centred, created="simulated"), centred),
        BOARD_RIG: aligned(by_board, found.points),
    }
    return LensRun(scene, {method: MM * (own - found.points) for method, own in points.items()})


def _means(errors_mm: Array) -> Figures:
    """Mean absolute errors along the axes and in total, mm."""
    means = np.nanmean(with_total(errors_mm), axis=0)
    return {name: rounded(value) for name, value in zip(COLUMNS, means, strict=True)}


def _with_ratio(means: Figures) -> Figures:
    return {**means, "of the thesis's": ratios(means, THESIS_MM)}


def _in_words(figures: Figures) -> str:
    return "; ".join(f"{lens} {means['total_mm']} mm" for lens, means in figures.items())


def _csv(run: LensRun) -> CsvTable:
    columns = tuple(f"{name}_{axis}_error_mm" for name in COLUMN_OF.values() for axis in "xyz")
    rows = np.column_stack([MM * run.scene.found.points, *(run.errors_mm[method] for method in COLUMN_OF)])
    return CsvTable(("x_mm", "y_mm", "z_mm", *columns), rows)


def _plate_plot(scene: PlateScene) -> bytes:
    """The pictures of the plate side by side, a row for each height, with the discs found."""
    figure, axes = panels("The plate at three heights, as found (figures 3.25 and 3.26)", len(PLATE_HEIGHTS_M))
    across = np.cumsum([0.0, *(own[0].shape[1] for own in scene.pictures[:-1])])
    for k, panel in enumerate(axes[:, 0]):
        panel.imshow(np.hstack([own[k] for own in scene.pictures]), cmap="gray")
        panel.grid(False)
        for pixels, left in zip(scene.found.pixels, across, strict=True):
            seen = np.split(pixels, len(PLATE_HEIGHTS_M))[k]
            panel.plot(seen[:, 0] + left, seen[:, 1], **DOTS)
        describe_panel(panel, f"position {k + 1} ({MM * PLATE_HEIGHTS_M[k]:g} mm), left and right view", "v, px")
    return png(figure, axes, "u, px; the right view beside the left one")


def _error_plot(compared: Mapping[str, Figures]) -> bytes:
    """Mean absolute errors by axis on a logarithmic scale, a panel for each lens."""
    figure, axes = panels("Mean absolute error of the calibration, by axis", len(LENSES), sharex=True, sharey=True)
    places, width = np.arange(len(COLUMNS)), 0.13
    for panel, lens in zip(axes[:, 0], LENSES, strict=True):
        for k, ((method, figures), colour) in enumerate(zip(compared.items(), COLOURS, strict=True)):
            heights = [figures[lens][name] for name in COLUMNS]
            panel.bar(places + (k - 2.5) * width, heights, width, label=method, color=colour)
        panel.set_yscale("log")
        panel.set_yticks((0.1, 1.0, 10.0), ("0.1", "1", "10"))
        panel.set_xticks(places, ("X", "Y", "Z", "total"))
        describe_panel(panel, f"lens: {lens}", "error, mm")
    return png(figure, axes, "axis of the operator frame")
