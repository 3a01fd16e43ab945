"""What an experiment leaves in its folder: report.json, report.html, plots as PNG, data as CSV; other files stay."""

import html
import json
from collections.abc import Iterator, Mapping
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import cv2
import numpy as np

from common.cameras.camera import Image
from common.geometry import Array
from farhand.outputs import write_result

STYLE = (
    "body{font:15px/1.5 sans-serif;max-width:1620px;margin:2em auto;padding:0 1em;color:#222}"
    "img{max-width:100%}table{border-collapse:collapse}td,th{padding:.2em 1em;border-bottom:1px solid #ddd;"
    "text-align:right}td:first-child,th:first-child{text-align:left}"
)


@dataclass(frozen=True, slots=True)
class Data:
    """One CSV: the names of its columns, and its rows (N, columns), NaN where there is nothing."""

    columns: tuple[str, ...]
    rows: Array


@dataclass(frozen=True, slots=True)
class ExperimentReport:
    """A finished experiment. `figures` are all of them by name; `compared` those to be shown side by side."""

    title: str
    text: str
    figures: Mapping[str, Any]
    compared: Mapping[str, Mapping[str, Any]]
    plots: Mapping[str, Image]
    data: Mapping[str, Data]


def write_report(report: ExperimentReport, folder: Path) -> None:
    """Write all files, each whole or not at all; ConfigError when the folder cannot be written."""
    for name, data in report.data.items():
        write_result(folder / f"{name}.csv", _csv(data).encode())
    for name, plot in report.plots.items():
        write_result(folder / f"{name}.png", cv2.imencode(".png", plot)[1].tobytes())
    write_result(folder / "report.json", (json.dumps(report.figures, indent=2) + "\n").encode())
    write_result(folder / "report.html", _page(report).encode())


def _csv(data: Data) -> str:
    lines = [",".join(data.columns)]
    lines += [",".join("" if np.isnan(value) else f"{value:.10g}" for value in row) for row in data.rows.round(4)]
    return "\n".join(lines) + "\n"


def _page(report: ExperimentReport) -> str:
    flat = {name: dict(_flat(figures)) for name, figures in report.compared.items()}
    keys = list(dict.fromkeys(key for figures in flat.values() for key in figures))
    head = "".join(f"<th>{html.escape(name)}</th>" for name in ("", *flat))
    rows = ([html.escape(key), *(str(figures.get(key, "–")) for figures in flat.values())] for key in keys)
    body = "".join(f"<tr><td>{'</td><td>'.join(row)}</td></tr>" for row in rows)
    plots = "".join(f'<p><img src="{name}.png" alt="{name}"></p>' for name in report.plots)
    files = ", ".join(f'<a href="{name}">{name}</a>' for name in ("report.json", *(f"{n}.csv" for n in report.data)))
    title = html.escape(report.title)
    return (
        f'<!doctype html><html lang="en"><meta charset="utf-8"><title>{title}</title><style>{STYLE}</style>'
        f"<h1>{title}</h1><p>{html.escape(report.text)}</p><table><tr>{head}</tr>{body}</table>"
        f"{plots}<p>Files: {files}</p></html>\n"
    )


def _flat(figures: Mapping[str, Any], before: str = "") -> Iterator[tuple[str, Any]]:
    """Nested figures as pairs of a name in words and a value."""
    for name, value in figures.items():
        words = f"{before}{name.replace('_', ' ')}"
        if isinstance(value, Mapping):
            yield from _flat(value, f"{words}, ")
        else:
            yield words, value
