"""The page of results, as Markdown and as HTML: what the sources print and draw beside ours, with the ratio."""

from collections.abc import Callable, Iterable, Mapping, Sequence
from dataclasses import dataclass
from typing import Any

from lab.experiments.placing.over_network import NETWORKS
from lab.experiments.placing.series import FREE, ROLL_FIXED
from lab.experiments.results import why
from lab.experiments.results.drawn import DrawnFigure, in_report, in_thesis
from lab.experiments.results.printed import Printed, of_report, of_thesis
from farhand.reports.page import heading, page, paragraph, table

Reports = Mapping[str, Mapping[str, Any]]  # report.json of each experiment that was run, by its name
TITLE = "Results"
ABOUT = (
    "All tables and figures of the two sources beside Farhand's own. Ours come from simulated arms, cameras and "
    "robots, whose truth is known; the sources measured real ones. Below a ratio of 1 Farhand's error is the smaller. "
    "What each experiment does, and what the comparison is worth, is told in docs/experiments.md."
)
PLACING_TEXT = (
    "Medians of the placed trials with their quartiles; drops, collisions, missed grasps and holds of all trials "
    "together. The thesis's errors are in the table above."
)
PRINTED_HEAD = ("source", "what", "printed", "Farhand", "ratio")
DRAWN_HEAD = ("source", "what", "file")
PLACING_COUNTS = ("drops", "collisions", "grasps_missed", "holds")
PLACING_HEAD = (
    "rotations",
    "tracker",
    "placed",
    "time, s",
    "x, mm",
    "y, mm",
    "angle, deg",
    "drops",
    "collisions",
    "missed",
    "holds",
    "clutches",
    "grip, N",
)
NETWORK_HEAD = ("network", "placed", "time, s", "x, mm", "y, mm", "angle, deg", "pictures, ms old")
THESIS = "The thesis: markerless stereo hand-arm tracking (2004)"
REPORT = "The report: Teleoperating ROBONAUT (2002)"
ERRORS = ("x_mm", "y_mm", "angle_deg")
ROTATIONS = {ROLL_FIXED: "roll fixed", FREE: "all"}
TITLES = {"placing": "The block placed", "network": "The block placed over a network", "causes": why.TITLE}


@dataclass(frozen=True, slots=True)
class _Section:
    """A heading, paragraphs, and tables below: column names and rows each."""

    title: str
    tables: Sequence[tuple[Sequence[str], Sequence[Sequence[str]]]]
    text: Sequence[str] = ()


def as_markdown(reports: Reports, version: str, quick: bool) -> str:
    """The page for the documentation, of this version of Farhand."""
    parts = [f"# {TITLE}", _about(version, quick)]
    for section in _sections(reports):
        parts += [f"## {section.title}", *section.text, *(_markdown_table(head, rows) for head, rows in section.tables)]
    return "\n\n".join(parts) + "\n"


def as_html(reports: Reports, version: str, quick: bool) -> str:
    """The same page for a browser."""
    body = [paragraph(_about(version, quick))]
    for section in _sections(reports):
        body += [heading(section.title), *map(paragraph, section.text)]
        body += [*(table(head, rows) for head, rows in section.tables)]
    return page(TITLE, body)


def _about(version: str, quick: bool) -> str:
    short = " This is a quick run, whose figures are of a few frames and trials." if quick else ""
    return f"{ABOUT}{short} The whole page is written by `farhand experiment all`, here of version {version}."


def _sections(reports: Reports) -> list[_Section]:
    return [
        _Section(THESIS, _beside(of_thesis(), in_thesis(), reports)),
        _Section(REPORT, _beside(of_report(), in_report(), reports)),
        _of("placing", reports, _placing),
        _of("network", reports, _over_networks),
        _of("causes", reports, _causes),
    ]


def _of(name: str, reports: Reports, section: Callable[[Mapping[str, Any]], _Section]) -> _Section:
    """The section of one experiment, which may not have been run yet."""
    if name not in reports:
        return _Section(TITLES[name], [], [f"The experiment `{name}` has not been run yet."])
    return section(reports[name])


def _placing(placing: Mapping[str, Any]) -> _Section:
    rows = [_placed(ROTATIONS[rolls], name, of) for rolls in ROTATIONS for name, of in placing[rolls].items()]
    return _Section(TITLES["placing"], [(PLACING_HEAD, rows)], [PLACING_TEXT])


def _over_networks(network: Mapping[str, Any]) -> _Section:
    return _Section(TITLES["network"], [(NETWORK_HEAD, [_over(name, network[name]) for name in NETWORKS])])


def _causes(causes: Mapping[str, Any]) -> _Section:
    return _Section(TITLES["causes"], [(why.HEAD, why.rows(causes))], list(why.in_words(causes)))


def _beside(
    printed: Iterable[Printed], drawn: Iterable[DrawnFigure], reports: Reports
) -> list[tuple[Sequence[str], Sequence[Sequence[str]]]]:
    return [
        (PRINTED_HEAD, [_row(each, reports) for each in printed]),
        (DRAWN_HEAD, [(each.where, each.what, f"{each.experiment}/{each.file}") for each in drawn]),
    ]


def _row(printed: Printed, reports: Reports) -> Sequence[str]:
    ours = _ours(printed, reports)
    theirs, unit = f"{printed.theirs:g} {printed.unit}", printed.unit
    if ours is None:
        return printed.where, printed.what, theirs, "–", "–"
    return printed.where, printed.what, theirs, f"{ours:.3g} {unit}", f"{ours / printed.theirs:.2f}"


def _ours(printed: Printed, reports: Reports) -> float | None:
    """Our figure; None where the experiment is still to be run, a quick run leaves it out, or nothing was placed."""
    found: Any = reports.get(printed.experiment)
    for name in printed.path:
        found = found.get(name) if found is not None else None
    return None if found is None else float(found)


def _placed(rotations: str, tracker: str, of: Mapping[str, Any]) -> Sequence[str]:
    """One series: medians with their quartiles, and what happened in all trials together."""
    spreads = (_spread(of[error], 1) for error in ERRORS)
    counts = (str(of[name]) for name in PLACING_COUNTS)
    ends = _spread(of["clutches"], 0), _spread(of["contact_force_n"], 0)
    return rotations, tracker, f"{of['placed']} of {of['trials']}", _spread(of["time_s"], 0), *spreads, *counts, *ends


def _spread(of: Mapping[str, float | None], decimals: int) -> str:
    """Median and quartiles; a dash where there are none."""
    if of["median"] is None:
        return "–"
    return f"{of['median']:.{decimals}f} ({of['q1']:.{decimals}f}–{of['q3']:.{decimals}f})"


def _over(name: str, of: Mapping[str, Any]) -> Sequence[str]:
    """One network's row: medians, with the quartiles of the time."""
    errors = ("–" if of[error]["median"] is None else f"{of[error]['median']:.1f}" for error in ERRORS)
    age = "–" if of["picture_age_ms"] is None else f"{of['picture_age_ms']:.0f}"
    return _words(name), f"{of['placed']} of {of['trials']}", _spread(of["time_s"], 0), *errors, age


def _words(name: str) -> str:
    network = NETWORKS[name]
    if network.loss:
        return f"{100 * network.loss:g} % lost"
    return f"{network.delay_ms:g} ms each way" if "ms" in name else f"{network.mbit_s:g} Mbit/s"


def _markdown_table(head: Sequence[str], rows: Iterable[Sequence[str]]) -> str:
    lines = [head, ["---"] * len(head), *rows]
    return "\n".join(f"| {' | '.join(cells)} |" for cells in lines)
