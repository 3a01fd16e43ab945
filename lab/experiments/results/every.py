"""The experiment "all": every other one into a folder of its own, and a page of all results."""

import json
from collections.abc import Callable, Sequence
from pathlib import Path
from typing import Any

from common.errors import ConfigError
from farhand.outputs import check_folder, make_folder, write_result
from lab.experiments.report import ExperimentReport, write_report
from lab.experiments.results.results_page import as_html, as_markdown

DONE = "done.json"  # which experiments of the folder are finished, and whether they were quick


def run_every(
    names: Sequence[str], run: Callable[[str], ExperimentReport], out: Path, quick: bool, version: str
) -> str:
    """Run all experiments, each into a folder of its own, and write results.md and results.html of those that are done.

    What is done in this folder already is not run again, unless it was of another version, or quick and is not to be.
    ConfigError when a folder cannot be written, or what is done cannot be read.
    """
    for name in names:
        if not _is_done(out / name, quick, version):
            check_folder("--out", out / name)
            make_folder("--out", out / name)
            write_report(run(name), out / name)
            write_result(out / name / DONE, json.dumps({"version": version, "quick": quick}).encode())
        _write_page([each for each in names if _is_done(out / each, quick, version)], out, quick, version)
    return f"every table and figure is listed in {out / 'results.md'}"


def _write_page(names: Sequence[str], out: Path, quick: bool, version: str) -> None:
    reports = {name: _figures(out / name) for name in names}
    write_result(out / "results.md", as_markdown(reports, version, quick).encode())
    write_result(out / "results.html", as_html(reports, version, quick).encode())


def _is_done(folder: Path, quick: bool, version: str) -> bool:
    try:
        done = json.loads((folder / DONE).read_text())
    except (OSError, ValueError):
        return False
    return bool(done == {"version": version, "quick": quick})


def _figures(folder: Path) -> dict[str, Any]:
    try:
        figures: dict[str, Any] = json.loads((folder / "report.json").read_text())
    except (OSError, ValueError) as error:
        raise ConfigError(
            f"{folder / 'report.json'} cannot be read ({error}); remove {folder} and run again"
        ) from error
    return figures
