"""Tracked points of a bare arm against tracked markers: the thesis's tables and ours, and the curves of both."""

from collections.abc import Iterator, Mapping
from dataclasses import dataclass

import numpy as np

from common.geometry import Array
from farhand.reports.plotting import describe_panel, panels, png, widen
from lab.experiments.report import Figures, rounded
from lab.experiments.thesis.tables import error_table, printed_table

POINTS = ("wrist", "index", "thumb")
EXPECTED_MM = {"wrist": 33.0, "index": 14.9, "thumb": 15.6}
THESIS: Mapping[str, Mapping[str, Figures]] = {
    "YZ": {
        "wrist": printed_table(
            [(26.7, 9.1, 4.5, 29.3), (3.0, 5.7, 3.2, 3.2), (33.3, 25.0, 11.9, 36.3), (18.7, 0.3, 0.1, 21.9)]
        ),
        "index": printed_table(
            [(10.9, 17.6, 5.8, 22.3), (2.0, 7.3, 3.5, 5.7), (14.6, 32.6, 13.3, 36.8), (7.2, 5.5, 0.3, 13.8)]
        ),
        "thumb": printed_table(
            [(18.6, 16.5, 18.6, 31.6), (2.7, 6.1, 5.0, 6.6), (23.3, 26.0, 27.9, 43.4), (10.6, 0.2, 7.6, 15.3)]
        ),
    },
    "XY": {
        "wrist": printed_table(
            [(25.9, 7.0, 10.8, 29.5), (3.8, 3.7, 3.5, 2.9), (33.9, 15.1, 18.0, 37.9), (17.9, 0.9, 3.3, 25.2)]
        ),
        "index": printed_table(
            [(8.8, 5.5, 21.9, 25.4), (4.2, 5.8, 6.2, 5.8), (24.8, 38.8, 39.4, 46.4), (1.4, 0.1, 6.2, 15.2)]
        ),
        "thumb": printed_table(
            [(14.9, 22.7, 25.8, 38.3), (3.7, 7.5, 6.6, 7.6), (22.4, 37.4, 36.7, 49.5), (5.2, 2.0, 7.1, 20.2)]
        ),
    },
    "XZ": {
        "wrist": printed_table(
            [(33.6, 5.6, 8.6, 36.2), (6.2, 4.0, 6.4, 4.6), (45.5, 16.8, 21.4, 46.1), (20.9, 0.2, 0.1, 26.6)]
        ),
        "index": printed_table(
            [(9.5, 5.3, 20.6, 24.2), (4.8, 5.0, 5.1, 6.0), (21.9, 27.5, 33.7, 40.2), (0.6, 0.2, 9.5, 12.7)]
        ),
        "thumb": printed_table(
            [(10.2, 12.5, 13.5, 22.1), (3.8, 8.3, 9.4, 10.4), (18.6, 36.0, 33.7, 47.0), (2.9, 0.1, 0.8, 6.1)]
        ),
    },
}
FIRST_TABLE = {"YZ": 3, "XY": 6, "XZ": 9}
FIRST_FIGURE = {"YZ": 3, "XY": 7, "XZ": 11}
OFF, VECTOR = "off the expected, mm", "vector error, mm"
MIN_SPAN_MM = 20.0
MARKED_LINE = {"label": "markers", "color": "#282828", "linewidth": 1.4}
BARE_LINE = {"label": "bare arm", "color": "#d72828", "linewidth": 1.2, "linestyle": "--"}
DIFFERENCE_LINE = {"label": "difference", "color": "#2878c8", "linewidth": 1.2}
TRUE_LINE = {"label": "true difference", "color": "#6e6e6e", "linewidth": 0.9}
EXPECTED_LINE = {"label": "expected difference", "color": "#6e6e6e", "linewidth": 0.9, "linestyle": ":"}


@dataclass(frozen=True, slots=True)
class Crossing:
    """One motion: tracked points of the bare arm, tracked markers, true marker less true point, each (N, 3) in mm by
    the point's name; NaN where not tracked."""

    bare: Mapping[str, Array]
    marked: Mapping[str, Array]
    true_offset: Mapping[str, Array]

    def difference(self, point: str) -> Array:
        """Tracked marker less tracked point (N, 3), mm."""
        return self.marked[point] - self.bare[point]


def crossing_figures(of_plane: Crossing) -> Mapping[str, Figures]:
    """The table of differences of each point, its vector error, and in how many frames both were tracked."""
    return {point: _point_figures(of_plane.difference(point), of_plane.true_offset[point]) for point in POINTS}


def _point_figures(difference: Array, true_offset: Array) -> Figures:
    table, errors = error_table(difference), np.linalg.norm(difference - true_offset, axis=1)
    known = errors[np.isfinite(errors)]
    vector = {"mean": rounded(known.mean()), "max": rounded(known.max())}
    return {**table, "frames": len(known), VECTOR: vector}


def off_expected_mm(table: Figures, point: str) -> float:
    """Compute how far a table's mean total difference is off the expected one, as in the thesis's section 7.2.2."""
    return abs(float(table["mean"]["total_mm"]) - EXPECTED_MM[point])


def crossing_plots(plane: str, of_plane: Crossing) -> Iterator[tuple[str, bytes]]:
    """The four figures of a motion as PNG, by file name without extension."""
    number = FIRST_FIGURE[plane]
    for k, point in enumerate(POINTS):
        title = f"{point.capitalize()} in the motion within {plane} (figure 6.{number + k})"
        yield f"figure_6_{number + k}_{plane.lower()}_{point}", _point_plot(title, of_plane, point)
    title = f"Distance from the origin, and total difference, in the motion within {plane} (figure 6.{number + 3})"
    yield f"figure_6_{number + 3}_{plane.lower()}_total", _total_plot(title, of_plane)


def _point_plot(title: str, of_plane: Crossing, point: str) -> bytes:
    """Position along each axis, and beside it the difference on a scale of its own."""
    figure, axes = panels(title, 3, 2, sharex=True)
    marked, bare, difference = of_plane.marked[point], of_plane.bare[point], of_plane.difference(point)
    for k, (row, axis) in enumerate(zip(axes, "XYZ", strict=True)):
        _compare(row, (marked[:, k], bare[:, k], difference[:, k]), (f"{axis}, position", f"{axis}, difference"))
        row[1].plot(np.arange(1, len(difference) + 1), of_plane.true_offset[point][:, k], **TRUE_LINE)
        for panel in row:
            widen(panel, MIN_SPAN_MM)
    return png(figure, axes, "frame")


def _total_plot(title: str, of_plane: Crossing) -> bytes:
    figure, axes = panels(title, 3, 2, sharex=True)
    for row, point in zip(axes, POINTS, strict=True):
        points = of_plane.marked[point], of_plane.bare[point], of_plane.difference(point)
        marked, bare, difference = (np.linalg.norm(rows, axis=1) for rows in points)
        _compare(row, (marked, bare, difference), (f"{point}, position", f"{point}, total difference"))
        widen(row[0], MIN_SPAN_MM)
        row[1].axhline(EXPECTED_MM[point], **EXPECTED_LINE)
        row[1].set_ylim(bottom=0.0)
    return png(figure, axes, "frame")


def _compare(row: Array, curves: tuple[Array, Array, Array], titles: tuple[str, str]) -> None:
    marked, bare, difference = curves
    frames = np.arange(1, len(marked) + 1)
    row[0].plot(frames, marked, **MARKED_LINE)
    row[0].plot(frames, bare, **BARE_LINE)
    row[1].plot(frames, difference, **DIFFERENCE_LINE)
    for panel, title in zip(row, titles, strict=True):
        describe_panel(panel, title, "mm")
