"""A recording's figures as a table for people: a row for each tracker and point, and a line of totals for each."""

import math
from collections.abc import Mapping

from rich.console import Group
from rich.table import Table

from bench.tracking.figures import PointFigures, TrackingFigures

COLUMNS = ("frames", "mean", "p95", "max", "bias x", "y", "z mm", "NEES (3)", "rank")


def shown(scene: str, by_tracker: Mapping[str, TrackingFigures], notes: tuple[str, ...]) -> Group:
    """Errors in mm by tracker and point; time, frames without result and toggles beneath, then the notes."""
    totals = [f"{name}: {_totals(figures)}" for name, figures in by_tracker.items()]
    return Group(_table(scene, by_tracker), *totals, *notes, "")


def _table(scene: str, by_tracker: Mapping[str, TrackingFigures]) -> Table:
    table = Table(title=scene, title_justify="left")
    table.add_column("tracker")
    table.add_column("point")
    for column in COLUMNS:
        table.add_column(column, justify="right")
    for name, figures in by_tracker.items():
        for point, values in figures.points.items():
            table.add_row(name, point, *_cells(values))
        table.add_section()
    return table


def _totals(figures: TrackingFigures) -> str:
    time = f"median {figures.median_ms:.1f}, p95 {figures.p95_ms:.1f} ms a pair (processor {figures.processor_ms:.1f})"
    gaps = f"{figures.without_result} of {figures.frames} frames without result"
    toggles = "" if figures.toggles is None else f"; {figures.toggles} toggles of {figures.true_toggles}"
    return f"{time}; {gaps}{toggles}"


def _cells(point: PointFigures) -> list[str]:
    errors = [f"{value:.1f}" for value in (point.mean, point.p95, point.largest, *point.bias)]
    honesty = ["-" if math.isnan(value) else f"{value:.2f}" for value in (point.normalised, point.rank)]
    return [str(point.frames), *errors, *honesty]
