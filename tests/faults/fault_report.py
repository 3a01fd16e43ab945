"""The report of the faults: one table, as a page and as JSON."""

import json
from dataclasses import asdict
from html import escape
from pathlib import Path
from typing import Any

from tests.faults.fault_rows import Row
from tests.faults.trial import Outcome

BUILD = Path(__file__).parents[2] / "build"
HEAD = "fault", "expected", "measured", "stop ms", "bound ms", "travel mm", "worst braking rad/s²", "limits", "result"
STYLE = (
    "body{font:15px sans-serif;margin:2em}table{border-collapse:collapse}"
    "th,td{border:1px solid #999;padding:.3em .6em;text-align:left;vertical-align:top}.failed{background:#fdd}"
)


class Report:
    """Collects rows and writes the report after each, so that an interrupted run leaves what it has."""

    def __init__(self, about: str, figures: Path, page: Path) -> None:
        """`figures` is the JSON file, `page` the HTML file, both below the folder build."""
        self._about, self._figures, self._page = about, BUILD / figures, BUILD / page
        self._rows: list[dict[str, Any]] = []

    def add(self, row: Row, outcome: Outcome, seconds: float) -> None:
        """Note a row."""
        self._rows.append(
            {"fault": row.fault, "expected": row.expected, "seconds": round(seconds, 1)}
            | asdict(outcome)
            | {"passed": not outcome.failures}
        )
        passed = sum(row["passed"] for row in self._rows)
        whole = {"about": self._about, "passed": passed, "failed": len(self._rows) - passed}
        whole["seconds"] = round(sum(row["seconds"] for row in self._rows), 1)
        self._page.parent.mkdir(parents=True, exist_ok=True)
        self._figures.write_text(json.dumps(whole | {"rows": self._rows}, indent=2) + "\n")
        self._page.write_text(self._html())

    def _html(self) -> str:
        head = "".join(f"<th>{name}</th>" for name in HEAD)
        body = "\n".join(_line(row) for row in self._rows)
        return (
            f"<!doctype html><html lang=en><meta charset=utf-8><title>Faults</title><style>{STYLE}</style>"
            f"<h1>Faults</h1><p>{escape(self._about)}</p><table><tr>{head}</tr>\n{body}\n</table></html>\n"
        )


def _line(row: dict[str, Any]) -> str:
    worst = row["worst"] or {}
    fractions = ", ".join(f"{name} {fraction:.2f}" for name, fraction in worst.items() if name != "finite")
    figures = [_figure(row[name]) for name in ("stop_ms", "bound_ms", "travel_mm", "deceleration")]
    result = "pass" if row["passed"] else "; ".join(row["failures"])
    cells = (row["fault"], row["expected"], "; ".join(row["notes"]), *figures, fractions, result)
    mark = "" if row["passed"] else " class=failed"
    return f"<tr{mark}>" + "".join(f"<td>{escape(cell)}</td>" for cell in cells) + "</tr>"


def _figure(value: float | None) -> str:
    return "" if value is None else f"{value:.1f}"
