"""No part of the product reads the wall clock, except to write a date into a file, and to compute its age."""

import ast
from pathlib import Path

import pytest

ROOT = Path(__file__).parents[2]
PACKAGES = ("common", "local_site", "remote_site", "farhand")
WALL = {"time", "time_ns", "localtime", "gmtime", "ctime", "clock_gettime", "clock_gettime_ns", "now", "utcnow"}
DATED = {  # for people the day of a calibration, a recording, a report, a stop; and when certificates are good
    "farhand/authority/engage.py": {"now"},
    "farhand/calibration/points.py": {"now"},
    "farhand/commands/files.py": {"now"},
    "farhand/commands/record.py": {"now"},
    "farhand/doctor/examination.py": {"now"},
    "farhand/tracking/track_run.py": {"now"},
}
STEADY = {"common/host_clock.py": {"clock_gettime_ns"}}  # of CLOCK_MONOTONIC_RAW and CLOCK_BOOTTIME


def wall_clock_reads(tree: ast.AST) -> set[str]:
    """The attributes of `time`, `datetime` or `date` by which a source reads the wall clock."""
    attributes = (node for node in ast.walk(tree) if isinstance(node, ast.Attribute))
    reads = {a.attr for a in attributes if isinstance(a.value, ast.Name) and a.value.id in ("time", "datetime", "date")}
    imports = (node for node in ast.walk(tree) if isinstance(node, ast.ImportFrom) and node.module == "time")
    return (reads | {alias.name for node in imports for alias in node.names}) & WALL


def test_only_monotonic_clocks_are_read() -> None:
    sources = [path for package in PACKAGES for path in (ROOT / package).rglob("*.py")]
    reads = {str(path.relative_to(ROOT)): wall_clock_reads(ast.parse(path.read_text())) for path in sources}
    assert {path: found for path, found in reads.items() if found} == DATED | STEADY


@pytest.mark.parametrize("line", ["time.time()", "time.time_ns()", "datetime.now(UTC)"])
def test_a_wall_clock_would_be_found(line: str) -> None:
    assert wall_clock_reads(ast.parse(line))


def test_an_imported_wall_clock_would_be_found() -> None:
    assert wall_clock_reads(ast.parse("from time import time as now")) == {"time"}
