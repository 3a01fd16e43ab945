"""A track's report: one page with tables and plots, and the pairs that a person should look at, in a folder."""

import re
from collections.abc import Iterator, Sequence
from contextlib import contextmanager
from pathlib import Path

import numpy as np

from common.geometry import Array
from farhand.outputs import make_folder, write_result
from farhand.reports.page import heading, page, paragraph, picture, table
from farhand.tracking.results.report.history import STATUSES, Mask, TrackHistory
from farhand.tracking.results.report.origin import Rows
from farhand.tracking.results.report.plots import PLOTS, SHOWN_REASONS, Plot, plots
from farhand.tracking.results.report.worst_pairs import APART_S, ShownPair, WorstPairs
from farhand.tracking.results.tracked_pair import Take, TrackedPair
from farhand.tracking.track_line import ALL_POINTS, POINTS

PAGE = "report.html"
OWN_PICTURE = re.compile(r"(worst|reason)_\d\d\.png|(" + "|".join(PLOTS) + r")\.png")
SHOWN_PICTURE = re.compile(r'<img src="([^"]+)"')
NONE = "–"


@contextmanager
def track_report(folder: Path, origin: Rows) -> Iterator[Take]:
    """A report of the pairs that were tracked, however the track ended; ConfigError if it cannot be written.

    `origin` says what the track was made of.
    """
    history, shown = TrackHistory(), WorstPairs()

    def take(pair: TrackedPair) -> None:
        history.add(pair)
        shown.add(pair)

    try:
        yield take
    finally:
        if history.pairs:
            _write(folder, origin, history, shown)


def _write(folder: Path, origin: Rows, history: TrackHistory, shown: WorstPairs) -> None:
    """The pictures first, then the page that shows them; pictures that only an earlier page showed are removed."""
    make_folder("--report", folder)
    earlier = _pictures_of(folder / PAGE)
    drawn = plots(history)
    worst = {f"worst_{k:02d}.png": pair for k, pair in enumerate(shown.worst, start=1)}
    reasons = {f"reason_{k:02d}.png": pair for k, pair in enumerate(shown.first_of_reason, start=1)}
    for plot in drawn:
        write_result(folder / f"{plot.name}.png", plot.png)
    for name, pair in {**worst, **reasons}.items():
        write_result(folder / name, pair.png)
    made_of = table(("this track", "what it is of"), origin)
    body = [made_of, *_tables(history), *_plots(drawn), *_worst(worst), *_reasons(reasons)]
    write_result(folder / PAGE, page("Track report", body).encode())
    for name in earlier - {*worst, *reasons, *(f"{plot.name}.png" for plot in drawn)}:
        (folder / name).unlink(missing_ok=True)


def _pictures_of(page: Path) -> set[str]:
    """The pictures of its own that an earlier report shows; none where there is no such report."""
    try:
        shown = SHOWN_PICTURE.findall(page.read_text(encoding="utf-8", errors="replace"))
    except FileNotFoundError:
        return set()
    return {name for name in shown if OWN_PICTURE.fullmatch(name)}


def _tables(history: TrackHistory) -> Iterator[str]:
    seconds = history.t_s[-1]
    length = f"{history.pairs} pairs over {seconds:.2f} s; gripper toggles: {history.gripper_toggles}."
    yield paragraph(f"{length} Points are in the operator frame. {SIGMA}")
    yield table(("status", "pairs", "share"), [(s.value, *_count(history.had(s))) for s in STATUSES])
    yield table(("of each pair", "median", "95 % are below", "greatest"), _of_pairs(history))
    names = [name for name in ALL_POINTS if name in {*POINTS, *history.measured_points}]
    yield table(("point", *POINT_FIGURES), [(name, *_of_point(history, name)) for name in names])
    if reasons := history.reasons():
        rows = ((f"{k}: {reason}", *_count(had)) for k, (reason, had) in enumerate(reasons[:SHOWN_REASONS], start=1))
        yield table(("reason", "pairs", "share"), rows)


SIGMA = "Sigma is the rms length of a point's error in space, as the tracker states it."
POINT_FIGURES = ("found", "sigma, median mm", "sigma, 95 % mm", "speed, median m/s", "speed, 95 % m/s")


def _of_pairs(history: TrackHistory) -> list[tuple[str, ...]]:
    return [
        ("computing time, ms", *_levels(history.ms, 1, (50, 95, 100))),
        ("rms epipolar residual between the views, px", *_levels(history.residual_px, 2, (50, 95, 100))),
    ]


def _of_point(history: TrackHistory, name: str) -> tuple[str, ...]:
    found: Mask = np.isfinite(history.position(name)[:, 0])
    sigma, speed = 1e3 * history.sigma(name), history.speed(name)
    return _count(found)[1], *_levels(sigma, 1, (50, 95)), *_levels(speed, 3, (50, 95))


def _count(held: Mask) -> tuple[str, str]:
    """Format how many pairs, and which fraction."""
    return str(int(held.sum())), f"{100 * held.mean():.1f}\N{NO-BREAK SPACE}%"


def _levels(values: Array, decimals: int, percents: Sequence[int]) -> list[str]:
    """The values below which these percentages of the known ones are."""
    known = values[np.isfinite(values)]
    return [f"{np.percentile(known, percent):.{decimals}f}" if len(known) else NONE for percent in percents]


def _plots(drawn: Sequence[Plot]) -> Iterator[str]:
    yield heading("Over time")
    for plot in drawn:
        yield picture(f"{plot.name}.png", plot.alt)


def _worst(worst: dict[str, ShownPair]) -> Iterator[str]:
    yield heading("The worst pairs")
    if not worst:
        yield paragraph("In no pair was a point measured.")
        return
    yield paragraph(
        "Each pair counts by the greatest sigma of its points, or by their greatest jump if that is greater: the "
        "distance from where the straight line through the two pairs before would have led. At most one pair is "
        f"taken of each {APART_S:g} s. Ellipses show two sigma; a ring is a point that was inferred."
    )
    for name, pair in worst.items():
        yield _picture(name, pair)


def _reasons(reasons: dict[str, ShownPair]) -> Iterator[str]:
    if reasons:
        yield heading("The first pair of each reason")
    for name, pair in reasons.items():
        yield _picture(name, pair)


def _picture(name: str, pair: ShownPair) -> str:
    caption = f"Pair {pair.frame} at {pair.t_s:.3f} s, {pair.why}"
    return picture(name, f"all views side by side with what was found in them; {caption}", caption)
