"""The page of results, as Markdown and as HTML: what the sources print and draw beside ours, with the ratio."""

from collections.abc import Callable, Iterable, Iterator, Mapping, Sequence
from dataclasses import dataclass
from typing import Any

from farhand.reports.page import heading, page, paragraph, table
from lab.experiments.placing.over_network import NETWORKS
from lab.experiments.placing.series import FREE, ROLL_FIXED
from lab.experiments.results import why
from lab.experiments.results.printed import Printed, of_report, of_thesis
from lab.experiments.thesis.marker_figures import FIRST_FIGURE, POINTS

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
TOTAL = "total difference"


@dataclass(frozen=True, slots=True)
class DrawnFigure:
    """A figure in a source, what it shows, and the file of ours in the folder of `experiment`."""

    where: str
    what: str
    experiment: str
    file: str


def in_thesis() -> Iterator[DrawnFigure]:
    """The figures of the thesis, in its order."""
    yield DrawnFigure("figure 3.25", "the plate at three heights", "calibration", "figure_3_25_plate.png")
    yield DrawnFigure("figure 6.1", "the elbow against its centre of rotation", "icr", "figure_6_1_elbow.png")
    yield DrawnFigure("figure 6.2", "the wrist against its centre of rotation", "icr", "figure_6_2_wrist.png")
    for plane, first in FIRST_FIGURE.items():
        for k, point in enumerate((*POINTS, "total")):
            shows = f"{TOTAL}s, motion in {plane}" if point == "total" else f"{point}, motion in {plane}"
            file = f"figure_6_{first + k}_{plane.lower()}_{point}.png"
            yield DrawnFigure(f"figure 6.{first + k}", shows, "markers", file)
    yield DrawnFigure("figure 6.15", "positions of hand and tool", "follow", "figure_6_15_positions.png")
    yield DrawnFigure("figure 6.16", "orientations of hand and tool", "follow", "figure_6_16_orientations.png")


def in_report() -> Iterator[DrawnFigure]:
    """The figures of the report of 2002 from 9 on, which show its results."""
    for number, shows, file in (
        (9, "frames of HAZEL-S", "figure_9_hazel_s_frames.png"),
        (10, "HAZEL-S: motion from frame to frame", "figure_10_motion.png"),
        (11, "HAZEL-S: positions", "figure_11_positions.png"),
        (12, "HAZEL-S: errors", "figure_12_errors.png"),
        (13, "frames of HAZEL-C, with the model over them", "figure_13_hazel_c_frames.png"),
        (14, "HAZEL-C: motion from frame to frame", "figure_14_hazel_c_motion.png"),
        (15, "the finger tip on its rectangle", "figure_15_finger_tip.png"),
        (16, "errors of the finger tip", "figure_16_finger_errors.png"),
    ):
        yield DrawnFigure(f"figure {number}", shows, "hazel", file)
    for number, shows, file in (
        (17, "frames of HAZEL-A, with the model over them", "figure_17_hazel_a_frames.png"),
        (18, "HAZEL-A: motion from frame to frame", "figure_18_hazel_a_motion.png"),
        (19, "frames of HAZEL-B, with the model over them", "figure_19_hazel_b_frames.png"),
        (20, "HAZEL-B: motion from frame to frame", "figure_20_hazel_b_motion.png"),
        (21, "the humanoid during HAZEL-A, from the front and from the side", "figure_21_hazel_a_humanoid.png"),
        (22, "the humanoid during HAZEL-B, from the front and from the side", "figure_22_hazel_b_humanoid.png"),
    ):
        yield DrawnFigure(f"figure {number}", shows, "robonaut", file)


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
