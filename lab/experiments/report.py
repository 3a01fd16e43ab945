"""Writes an experiment's results to a folder: report.json, report.html, plots as PNG, data as CSV; other files stay."""

import json
from collections.abc import Callable, Iterator, Mapping
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import numpy as np

from common.geometry import Array
from farhand.outputs import write_result
from farhand.reports.page import files, page, paragraph, picture, table

Figures = dict[str, Any]  # numbers by name, possibly nested
Progress = Callable[[], object]  # called after every frame; may raise, as InterruptionError when a person ends the work


@dataclass(frozen=True, slots=True)
class CsvTable:
    """One CSV file: its column names, and its rows (N, columns); NaN becomes an empty field."""

    columns: tuple[str, ...]
    rows: Array


@dataclass(frozen=True, slots=True)
class ExperimentReport:
    """The results of a finished experiment.

    `text` is the paragraph under the title of report.html. `figures` go to report.json; `compared` are the runs that
    report.html shows side by side, by their names; `summary` is a few lines for the terminal. `plots` (PNG) and `data`
    (CSV) are by file name without extension.
    """

    title: str
    text: str
    summary: str
    figures: Figures
    compared: Mapping[str, Figures]
    plots: Mapping[str, bytes]
    data: Mapping[str, CsvTable]


def rounded(value: float | np.floating[Any]) -> float:
    """Round a figure to the three decimals of a report."""
    return round(float(value), 3)


def write_report(report: ExperimentReport, folder: Path) -> None:
    """Write all files, each whole or not at all; ConfigError when the folder cannot be written."""
    for name, data in report.data.items():
        lines = [",".join(data.columns)]
        lines += [",".join("" if np.isnan(value) else f"{value:.10g}" for value in row) for row in data.rows.round(4)]
        write_result(folder / f"{name}.csv", ("\n".join(lines) + "\n").encode())
    for name, plot in report.plots.items():
        write_result(folder / f"{name}.png", plot)
    write_result(folder / "report.json", (json.dumps(report.figures, indent=2) + "\n").encode())
    write_result(folder / "report.html", _page(report).encode())


def _page(report: ExperimentReport) -> str:
    flat = {name: dict(_flat(figures)) for name, figures in report.compared.items()}
    fullest_first = sorted(flat.values(), key=len, reverse=True)
    keys = list(dict.fromkeys(key for figures in fullest_first for key in figures))
    rows = ([key, *(figures.get(key, "–") for figures in flat.values())] for key in keys)
    plots = [picture(f"{name}.png", f"plot: {name.replace('_', ' ')}") for name in report.plots]
    names = files(("report.json", *(f"{name}.csv" for name in report.data)))
    return page(report.title, [paragraph(report.text), table(("figure", *flat), rows), *plots, names])


def _flat(figures: Figures, prefix: str = "") -> Iterator[tuple[str, Any]]:
    """Flatten nested figures to pairs of label and value, as ("wrist mm, mean", 0.55)."""
    for name, value in figures.items():
        label = f"{prefix}{name.replace('_', ' ')}"
        if isinstance(value, dict):
            yield from _flat(value, f"{label}, ")
        else:
            yield label, value
