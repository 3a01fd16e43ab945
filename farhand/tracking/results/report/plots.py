"""The plots of a track's report: where each point was, how fast and how certain, and how the tracking went."""

from dataclasses import dataclass
from typing import TYPE_CHECKING, Any

import numpy as np

from common.geometry import Array
from common.messages.hand import TrackingStatus
from farhand.reports.plotting import describe_panel, panels, png
from farhand.tracking.results.report.history import STATUSES, Mask, TrackHistory

if TYPE_CHECKING:
    from matplotlib.axes import Axes

PLOTS = POSITION, SPEED_SIGMA, COURSE = "position", "speed_sigma", "course"
SHOWN_REASONS = 8
TIME = "time, s"
MEASURED: dict[str, Any] = {
    "color": "#1558b0",
    "linewidth": 0.9,
    "marker": ".",
    "markersize": 2.0,  # so that a single pair between two losses is seen
}
BANDS: dict[TrackingStatus, str] = {
    TrackingStatus.TRACKED: "#3f9142",
    TrackingStatus.DEGRADED: "#d9822b",
    TrackingStatus.INITIALISING: "#6e6e6e",
    TrackingStatus.LOST: "#c23030",
}


@dataclass(frozen=True, slots=True)
class Plot:
    """A plot as PNG by its name without extension; `alt` says in words what it shows."""

    name: str
    alt: str
    png: bytes


def plots(history: TrackHistory) -> list[Plot]:
    """All plots of a track; those of points are left out where no point was ever measured."""
    names = history.measured_points
    of_points = [_positions(history, names), _speeds_and_sigmas(history, names)] if names else []
    return [*of_points, _course(history)]


def _positions(history: TrackHistory, names: list[str]) -> Plot:
    figure, axes = panels("Position in the operator frame", len(names), 3, sharex=True)
    for row, name in zip(axes, names, strict=True):
        for panel, axis, values in zip(row, "xyz", history.position(name).T, strict=True):
            panel.plot(history.t_s, values, **MEASURED)
            describe_panel(panel, f"{name} {axis}", "m")
    spans = "; ".join(f"{name} {_span(history.position(name))}" for name in names)
    return Plot(POSITION, f"x, y and z of each point over time: {spans}", png(figure, axes, TIME))


def _span(position: Array) -> str:
    low, high = np.nanmin(position, axis=0), np.nanmax(position, axis=0)
    return ", ".join(f"{axis} {a:.3f} to {b:.3f} m" for axis, a, b in zip("xyz", low, high, strict=True))


def _speeds_and_sigmas(history: TrackHistory, names: list[str]) -> Plot:
    figure, axes = panels("Speed and sigma", len(names), 2, sharex=True)
    for (speed, sigma), name in zip(axes, names, strict=True):
        speed.plot(history.t_s, history.speed(name), **MEASURED)
        describe_panel(speed, f"{name}, speed", "m/s")
        sigma.plot(history.t_s, 1e3 * history.sigma(name), **MEASURED)
        describe_panel(sigma, f"{name}, sigma", "mm")
    shown = ", ".join(names)
    return Plot(SPEED_SIGMA, f"speed and sigma of {shown} over time, as in the table", png(figure, axes, TIME))


def _course(history: TrackHistory) -> Plot:
    """Status, reasons, residual and computing time, one below the other."""
    figure, axes = panels("Course", 4, sharex=True)
    (status,), (reason,), (residual,), (ms,) = axes
    shown = [had for _, had in history.reasons()[:SHOWN_REASONS]]
    _draw_bands(status, history.t_s, [history.had(s) for s in STATUSES], [BANDS[s] for s in STATUSES])
    status.set_yticks(range(len(STATUSES)), [s.value for s in STATUSES])
    describe_panel(status, "status", "")
    _draw_bands(reason, history.t_s, shown, ["#1558b0"] * len(shown))
    reason.set_yticks(range(len(shown)), [str(k + 1) for k in range(len(shown))])
    describe_panel(reason, "reason", "number in the table")
    residual.plot(history.t_s, history.residual_px, **MEASURED)
    describe_panel(residual, "rms epipolar residual between the views", "px")
    ms.plot(history.t_s, history.ms, **MEASURED)
    describe_panel(ms, "computing time", "ms per pair")
    alt = "status, reasons by their numbers, residual between the views and computing time over time, as in the tables"
    return Plot(COURSE, alt, png(figure, axes, TIME))


def _draw_bands(axes: "Axes", t_s: Array, rows: list[Mask], colours: list[str]) -> None:
    """A row for each sequence (N,) of whether something held, the first at the top, with a bar wherever it did."""
    for k, (held, colour) in enumerate(zip(rows, colours, strict=True)):
        axes.broken_barh(_bars(t_s, held), (k - 0.4, 0.8), facecolors=colour, edgecolors=colour, linewidth=0.4)
    axes.set_ylim(max(len(rows), 1) - 0.5, -0.5)


def _bars(t_s: Array, held: Mask) -> list[tuple[float, float]]:
    """Start and duration (s) of every stretch of pairs that held; the last pair lasts as long as the one before."""
    ends = np.append(t_s, t_s[-1] + (t_s[-1] - t_s[-2] if len(t_s) > 1 else 1.0))
    turns = np.flatnonzero(np.diff(np.concatenate([[0], held.astype(int), [0]])))
    return [(ends[a], ends[b] - ends[a]) for a, b in turns.reshape(-1, 2)]
