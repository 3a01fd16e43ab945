"""Tables as the thesis prints them: absolute errors along X, Y and Z and in total; ours divided by the thesis's."""

from collections.abc import Sequence

import numpy as np

from common.errors import ProcessError
from common.geometry import Array
from lab.experiments.report import Figures, rounded

MM = 1e3
ROWS = ("mean", "sd", "max", "min")
COLUMNS = ("x_mm", "y_mm", "z_mm", "total_mm")


def with_total(errors: Array) -> Array:
    """Absolute errors (N, 4) along the axes and in total, of error vectors (N, 3) in the same unit."""
    return np.column_stack([np.abs(errors), np.linalg.norm(errors, axis=1)])


def error_table(errors_mm: Array) -> Figures:
    """Mean, standard deviation, largest and least absolute error (N, 3) in mm; rows with NaN do not count.

    ProcessError where no row is left.
    """
    known = with_total(errors_mm[np.isfinite(errors_mm).all(axis=1)])
    if not len(known):
        raise ProcessError("nothing was tracked that could be compared; check the tracking")
    rows = known.mean(axis=0), known.std(axis=0), known.max(axis=0), known.min(axis=0)
    return printed_table([[rounded(value) for value in row] for row in rows])


def printed_table(rows: Sequence[Sequence[float]]) -> Figures:
    """A table of ROWS by COLUMNS as figures by name."""
    return {name: dict(zip(COLUMNS, row, strict=True)) for name, row in zip(ROWS, rows, strict=True)}


def ratios(ours: Figures, thesis: Figures) -> Figures:
    """Our figures divided by the thesis's of the same names."""
    return {
        name: ratios(ours[name], value) if isinstance(value, dict) else round(ours[name] / value, 2)
        for name, value in thesis.items()
        if name in ours
    }
