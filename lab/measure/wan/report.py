"""The results in files: report.json, the tables of docs/networks.md, and its picture."""

import json
from collections.abc import Mapping, Sequence
from dataclasses import asdict
from pathlib import Path
from typing import Any

from lab.measure.wan.demands import DemandResult
from lab.measure.wan.links import Change, WanLink

Figures = Mapping[str, Any]
MINUS = "–"
COLUMNS: tuple[tuple[str, str, str], ...] = (
    ("ready_after_s", "ready after s", ".1f"),
    ("followed", "followed", ".1%"),
    ("holds_a_minute", "holds a minute", ".1f"),
    ("latches", "latches", "d"),
    ("changes_in_a_second", "changes in the worst second", "d"),
    ("lag_ms", "lag ms", ".0f"),
    ("error_mm", "error mm", ".2f"),
    ("hand_p99_ms", "hand p99 ms", ".0f"),
    ("age_limit_ms", "age limit ms", ".0f"),
    ("age_p50_ms", "picture p50 ms", ".0f"),
    ("age_p95_ms", "p95 ms", ".0f"),
    ("fps", "fps", ".1f"),
    ("h264", "as H.264", ".0%"),
    ("ssim", "SSIM", ".3f"),
    ("ssim_below_jpeg", "below JPEG 80", ".3f"),
    ("ticks_missed", "ticks missed", ".2%"),
    ("link_late_p99_ms", "link late ms", ".1f"),
    ("stolen", "stolen", ".0%"),
    ("runs", "runs", "d"),
    ("held_for", "held for", ""),
    ("why", "not followed because", ""),
)


def write_report(
    folder: Path,
    links: Mapping[WanLink, Figures],
    changes: Mapping[Change, Figures],
    verdicts: Sequence[DemandResult],
    congestion: str,
) -> None:
    """Write all three files."""
    folder.mkdir(parents=True, exist_ok=True)
    rows = {
        "congestion_control": congestion,
        "links": {link.name: dict(figures) for link, figures in links.items()},
        "changes": {change.name: dict(figures) for change, figures in changes.items()},
        "verdicts": [asdict(verdict) for verdict in verdicts],
    }
    (folder / "report.json").write_text(json.dumps(rows, indent=2) + "\n", encoding="utf-8")
    tables = f"{link_table(links)}\n{change_table(changes)}\n{verdict_table(verdicts)}"
    (folder / "networks.md").write_text(tables, encoding="utf-8")
    draw(folder / "networks.png", links)


def link_table(links: Mapping[WanLink, Figures]) -> str:
    """A row for each link."""
    head = ["ms each way", "jitter", "loss", "Mbit/s", *(title for _, title, _ in COLUMNS)]
    rows = [
        [f"{k.delay_ms:g}", f"{k.jitter:.0%}", f"{k.loss:.0%}", f"{k.mbit_s:g}"]
        + [cell(figures.get(name), form) for name, _, form in COLUMNS]
        for k, figures in sorted(links.items())
    ]
    return table(head, rows)


def change_table(changes: Mapping[Change, Figures]) -> str:
    """A row for each change."""
    columns = (
        ("held", "held", ""),
        ("latched", "latched", ""),
        ("holds", "holds", "d"),
        ("followed_after_s", "followed after s", ".2f"),
        ("ready_after_s", "ready after s", ".2f"),
        ("moved_mrad", "moved since mrad", ".1f"),
        ("tool_mm_s", "tool at most mm/s", ".0f"),
        ("tool_before_mm_s", "before mm/s", ".0f"),
        ("age_understated_ms", "age understated ms", ".0f"),
        ("why", "says", ""),
    )
    rows = [[c.name, *(cell(f.get(name), form) for name, _, form in columns)] for c, f in changes.items()]
    return table(["change", *(title for _, title, _ in columns)], rows)


def verdict_table(verdicts: Sequence[DemandResult]) -> str:
    """A row for each demand, those that failed first."""
    ordered = sorted(verdicts, key=lambda one: one.passed)
    rows = [[v.where, v.demand, cell(v.value, ".3f"), "met" if v.passed else "**failed**"] for v in ordered]
    return table(["where", "demand", "measured", ""], rows)


def cell(value: Any, form: str) -> str:
    """A figure as a reader wants it."""
    if isinstance(value, bool):
        return "yes" if value else "no"
    return MINUS if value in (None, "") else format(value, form)


def table(head: Sequence[str], rows: Sequence[Sequence[str]]) -> str:
    """A table in Markdown."""
    lines = [head, ["---"] * len(head), *rows]
    return "\n".join(f"| {' | '.join(line)} |" for line in lines) + "\n"


def draw(path: Path, links: Mapping[WanLink, Figures]) -> None:
    """Following, the hand's lag, the pictures' age and their rate over the delay; a line for each kind of link."""
    import matplotlib as mpl  # noqa: PLC0415  # other benchmarks need no plots

    mpl.use("Agg")
    import matplotlib.pyplot as plt  # noqa: PLC0415  # after the choice of its backend

    shown = (
        ("followed", "share of time followed"),
        ("lag_ms", "lag of the arm, ms"),
        ("error_mm", "error without the lag, mm"),
        ("age_p95_ms", "age of pictures, p95, ms"),
        ("fps", "pictures a second of each view"),
        ("ssim_below_jpeg", "SSIM below JPEG 80's"),
    )
    figure, axes = plt.subplots(2, 3, figsize=(12, 6.5), layout="constrained")
    kinds = sorted({(link.mbit_s, link.jitter, link.loss) for link in links}, reverse=True)
    for axis, (name, title) in zip(axes.flat, shown, strict=True):
        for kind in kinds:
            points = [
                (link.delay_ms, f[name])
                for link, f in sorted(links.items())
                if (link.mbit_s, link.jitter, link.loss) == kind and f.get(name) is not None
            ]
            label = f"{kind[0]:g} Mbit/s, jitter {kind[1]:.0%}, loss {kind[2]:.0%}"
            axis.plot(*zip(*points, strict=True) if points else ((), ()), "o-", label=label)
        axis.set(title=title, xlabel="delay each way, ms")
        axis.grid(alpha=0.3)
    handles, labels = axes.flat[0].get_legend_handles_labels()
    figure.legend(handles, labels, loc="outside lower center", ncols=3)
    figure.savefig(path, dpi=110)
    plt.close(figure)
