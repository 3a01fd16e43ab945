"""The experiment "markers": a bare arm against one with markers, as in the thesis's tables 6.3 to 6.11."""

from collections.abc import Mapping, Sequence

import numpy as np

from lab.experiments.report import CsvTable, ExperimentReport, Figures, Progress, rounded
from lab.experiments.thesis.filmed import film_recorded
from lab.experiments.thesis.marker_figures import (
    FIRST_TABLE,
    OFF,
    POINTS,
    THESIS,
    VECTOR,
    Crossing,
    crossing_figures,
    crossing_plots,
    off_expected_mm,
)
from lab.experiments.thesis.paths import crossing
from lab.experiments.thesis.tables import MM, ratios
from local_site.simulation.config import SimulationConfig

FRAMES = 60
QUICK_PLANES = ("YZ",)
SIMULATION = SimulationConfig(markers_worn="beside_the_tips")
SUMMED = "mean of the motions"
TEXT = (
    "The hand crosses the volume and turns to and fro within one plane, in three motions of 60 frames (a quick run: "
    "in the first of them). Each is filmed twice from one seed: bare, tracked by the silhouette tracker, and with a "
    "dark glove and three markers, tracked by the marker tracker. The markers are where the thesis had them: on the "
    "radial side of the wrist (33.0 mm from its centre) and of the index finger (14.9 mm from its tip), and on the "
    "back of the thumb (15.6 mm from its tip). So the two must differ by that much. As in the thesis, the error is "
    "how far the mean total difference is off the expected one: a difference of lengths, in which errors across the "
    "offset hardly count. The vector error does not have this fault: it is the length of the difference less the true "
    "offset, which only a simulation knows. The spread over the axes depends on how the hand is held, so that only "
    "totals compare."
)


def frame_count(quick: bool) -> int:
    """Count the frames that are filmed, for a progress bar."""
    return 2 * crossing("YZ", FRAMES).filmed_frames * len(_planes(quick))


def markers_report(quick: bool, progress: Progress) -> ExperimentReport:
    """Run the experiment; always the same for the same installation."""
    crossings = {plane: _crossing(plane, progress) for plane in _planes(quick)}
    ours = {plane: crossing_figures(of_plane) for plane, of_plane in crossings.items()}
    compared = {"thesis": _compared({plane: THESIS[plane] for plane in crossings}), "Farhand": _compared(ours)}
    compared["Farhand / thesis"] = ratios(compared["Farhand"], compared["thesis"])
    return ExperimentReport(
        title="A bare arm against markers",
        text=TEXT,
        summary="\n".join(f"{name}: {_in_words(compared[name][SUMMED])}" for name in ("thesis", "Farhand")),
        figures={"experiment": "markers", "quick": quick, "seed": SIMULATION.seed, "runs": compared},
        compared=compared,
        plots={name: plot for plane, of_plane in crossings.items() for name, plot in crossing_plots(plane, of_plane)},
        data={f"markers_{plane.lower()}": _csv(of_plane) for plane, of_plane in crossings.items()},
    )


def _planes(quick: bool) -> tuple[str, ...]:
    return QUICK_PLANES if quick else tuple(THESIS)


def _crossing(plane: str, progress: Progress) -> Crossing:
    recorded = crossing(plane, FRAMES)
    bare, marked = (film_recorded(SIMULATION, recorded, method, progress) for method in ("silhouette", "markers"))
    return Crossing(
        bare={point: MM * bare.tracked(point) for point in POINTS},
        marked={point: MM * marked.tracked(point) for point in POINTS},
        true_offset={point: MM * (marked.true(point) - bare.true(point)) for point in POINTS},
    )


def _compared(planes: Mapping[str, Mapping[str, Figures]]) -> Figures:
    """All tables by their names, and first each point's means over the motions."""
    named = {point: [planes[plane][point] for plane in planes] for point in POINTS}
    tables: Figures = {SUMMED: {point: _means(point, of_point) for point, of_point in named.items()}}
    for plane, of_plane in planes.items():
        for k, point in enumerate(POINTS):
            off = {OFF: rounded(off_expected_mm(of_plane[point], point))}
            tables[f"table 6.{FIRST_TABLE[plane] + k}, {plane}, {point}"] = {**of_plane[point], **off}
    return tables


def _means(point: str, tables: Sequence[Figures]) -> Figures:
    """Compute how far the point is off the expected difference, and its known vector error; means over motions."""
    means = {OFF: np.mean([off_expected_mm(table, point) for table in tables])}
    if all(VECTOR in table for table in tables):
        means[VECTOR] = np.mean([table[VECTOR]["mean"] for table in tables])
    return {name: rounded(value) for name, value in means.items()}


def _in_words(summed: Figures) -> str:
    words = {OFF: "{} mm off the expected difference", VECTOR: "vector error {} mm"}
    of_points = (", ".join(words[name].format(value) for name, value in of.items()) for of in summed.values())
    return "; ".join(f"{point} {of_point}" for point, of_point in zip(summed, of_points, strict=True))


def _csv(of_plane: Crossing) -> CsvTable:
    kinds = {"markers": of_plane.marked, "bare": of_plane.bare}
    columns = tuple(f"{point}_{kind}_{axis}_mm" for point in POINTS for kind in kinds for axis in "xyz")
    rows = np.hstack([points[point] for point in POINTS for points in kinds.values()])
    return CsvTable(("frame", *columns), np.column_stack([np.arange(1, len(rows) + 1), rows]))
