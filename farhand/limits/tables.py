"""A report on an arm's limits as tables for people, and as builtins for programs; pure."""

from collections.abc import Sequence
from dataclasses import dataclass
from typing import Any

from farhand.limits.report import TICKS, LimitsReport, figure
from remote_site.safety.stop_figures import StopFigures

MS = MM = 1000.0


@dataclass(frozen=True, slots=True)
class LimitsTable:
    """A table of limits: what it shows, in a sentence, the heads of its columns, and its rows."""

    title: str
    head: Sequence[str]
    rows: Sequence[Sequence[str]]


def tables_of(report: LimitsReport) -> list[LimitsTable]:
    """The tables that people read, the figures rounded."""
    return [_limits(report), _sources(report), _tool(report), _stops(report), _ages(report)]


def _limits(report: LimitsReport) -> LimitsTable:
    """A row for each joint, since names of limits break into lines, and numbers do not."""
    head = ["joint", *(row.name for row in report.limits)]
    columns = [report.joints, *([figure(value) for value in row.values] for row in report.limits)]
    return LimitsTable(f"The limits of the arm {report.arm}, joint by joint:", head, list(zip(*columns, strict=True)))


def _sources(report: LimitsReport) -> LimitsTable:
    return LimitsTable("Where they come from:", ["limit", "from"], [[row.name, row.source] for row in report.limits])


def _tool(report: LimitsReport) -> LimitsTable:
    return LimitsTable("Its tool, and what holds for all joints:", ["what", "value", "from"], report.tool)


def _stops(report: LimitsReport) -> LimitsTable:
    way = "the tool by one joint, by all"
    head = ["joint speed", "steady", way, "still accelerating", way]
    rows = [[f"{figure(row.speed_rad_s)} rad/s", *_stop(row.steady), *_stop(row.rising)] for row in report.stops]
    rows[-1][0] += ", full speed"
    reach = f"{report.reach_m:.2f} m"
    title = f"A stop takes at most, from a speed that no joint exceeds, with the tool up to {reach} from an axis:"
    return LimitsTable(title, head, rows)


def _ages(report: LimitsReport) -> LimitsTable:
    head = ["age limit", "greatest joint speed", "rest after", "the tool by one joint, by all"]
    rows = [[f"{row.age_ms:g} ms", f"{figure(row.speed_rad_s)} rad/s", *_stop(row.whole)] for row in report.ages]
    title = f"From the exposure of the last good sample to rest, with {TICKS} ticks of control, at most:"
    return LimitsTable(title, head, rows)


def _stop(figures: StopFigures) -> tuple[str, str]:
    return f"{MS * figures.seconds:.0f} ms", f"{MM * figures.by_one_m:.0f} mm, {MM * figures.by_all_m:.0f} mm"


def as_builtins(report: LimitsReport) -> dict[str, Any]:
    """The same for programs, with units in the keys, nothing rounded."""
    return {
        "arm": report.arm,
        "joints": report.joints,
        "reach_m": report.reach_m,
        "limits": {row.key: {"values": row.values, "from": row.source} for row in report.limits},
        "tool": [dict(zip(("what", "value", "from"), row, strict=True)) for row in report.tool],
        "stops": [
            {"speed_rad_s": row.speed_rad_s, "steady": row.steady._asdict(), "rising": row.rising._asdict()}
            for row in report.stops
        ],
        "ages": [{"age_ms": row.age_ms, "speed_rad_s": row.speed_rad_s, **row.whole._asdict()} for row in report.ages],
    }
