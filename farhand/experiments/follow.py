"""The experiment "follow": one hand motion, followed as in the thesis and as Farhand does it, side by side."""

from collections.abc import Mapping, Sequence
from dataclasses import dataclass

import numpy as np

from common.clock import NS_PER_S
from common.geometry import Array
from common.messages.hand import TrackingStatus
from farhand.experiments.follow_figures import (
    COLUMNS,
    GRID_NS,
    Curves,
    follow_figures,
    hand_rows,
    pointing,
    rows_at,
    tool_rows,
)
from farhand.experiments.following import Film, ToolPath, film, follow_by_mean, follow_by_pipeline
from farhand.experiments.report import CsvTable, ExperimentReport, Figures, Progress
from farhand.reports.plotting import describe_panel, panels, png, widen
from local_site.samples.smoothing import SmoothingConfig
from local_site.simulation.config import MotionConfig, SimulationConfig
from local_site.tracking.choice import TrackingConfig
from local_site.tracking.tracker import ArmEstimate
from remote_site.config import RemoteConfig

STILL_S = 4.0  # at 5 fps the tracker learns the arm for two seconds, and the mean fills for as long
STILL_NS = round(STILL_S * NS_PER_S)
MOVES_S, QUICK_MOVES_S = 32.0, 4.5
THESIS_FPS, FARHAND_FPS = 5.0, 30.0
LATENCY_MS = 10.0
THESIS_SMOOTHING = SmoothingConfig(method="mean", mean_frames=9, max_gap_s=1.0)
SIMULATION = SimulationConfig(motion=MotionConfig(name="reach_and_adjust", still_s=STILL_S))
TEXT = (
    "A simulated hand reaches, adjusts and carries as in figures 6.15 and 6.16 of the thesis. Two cameras film it, the "
    "tracker measures it, and the tool follows: once by the mean of nine frames at 5 frames per second, mapped onto an "
    "arm that reaches each target without delay, and once by Farhand's own settings through its whole pipeline. Lag "
    "is the delay at which hand and tool fit best; the residual is the distance that remains at that delay."
)
HAND_MEASURED = {"label": "hand, measured", "color": "#64b4eb", "linewidth": 3.4}
HAND_TRUE = {"label": "hand, true", "color": "#282828", "linewidth": 0.9}
TOOL = {"label": "tool", "color": "#d72828", "linewidth": 1.6}
LABELS = ("X, mm", "Y, mm", "Z, mm", "XY plane, deg", "XZ plane, deg")
MIN_SPAN_MM, MIN_SPAN_DEG = 10.0, 4.0


@dataclass(frozen=True, slots=True)
class Variant:
    """One method to follow the hand: its name, its frames per second, its curves and figures."""

    name: str
    fps: float
    curves: Curves
    figures: Figures


def frame_count(quick: bool) -> int:
    """How many frames are filmed, for a progress bar."""
    return sum(round(_filmed_s(quick) * fps) + 1 for fps in (THESIS_FPS, FARHAND_FPS))


def follow_report(quick: bool, progress: Progress) -> ExperimentReport:
    """Run the experiment; always the same for the same settings. ProcessError when the arm was never engaged."""
    filmed_s, remote = _filmed_s(quick), RemoteConfig()
    slow, fast = (film(SIMULATION, TrackingConfig(), fps, filmed_s, progress) for fps in (THESIS_FPS, FARHAND_FPS))
    by_mean = follow_by_mean(slow, THESIS_SMOOTHING, remote)
    by_pipeline = follow_by_pipeline(fast, SmoothingConfig(), remote, LATENCY_MS)
    variants = {
        "mean_5fps": _variant("9-frame mean at 5 fps", slow, by_mean, remote),
        "farhand_30fps": _variant("Farhand at 30 fps", fast, by_pipeline, remote),
    }
    settings = {
        "quick": quick,
        "seed": SIMULATION.seed,
        "motion": SIMULATION.motion.name,
        "still_s": STILL_S,
        "seconds": filmed_s,
        "robot": remote.robot.model,
        "mean_frames": THESIS_SMOOTHING.mean_frames,
        "mean_latency_ms": 0.0,
        "farhand_latency_ms": LATENCY_MS,
    }
    figures = {name: variant.figures for name, variant in variants.items()}
    return ExperimentReport(
        title="Hand against tool: the thesis's mean and Farhand's pipeline",
        text=TEXT,
        summary="\n".join(
            f"{variant.name}, behind the {hand} hand: {_in_words(variant.figures[f'tool_behind_{hand}_hand'])}"
            for variant in variants.values()
            for hand in ("true", "measured")
        ),
        figures={"experiment": "follow", "settings": settings, **figures},
        compared={variant.name: variant.figures for variant in variants.values()},
        plots=_plots(tuple(variants.values())),
        data={f"follow_{name}": _table(variant) for name, variant in variants.items()},
    )


def _filmed_s(quick: bool) -> float:
    return STILL_S + (QUICK_MOVES_S if quick else MOVES_S)


def _variant(name: str, filmed: Film, path: ToolPath, remote: RemoteConfig) -> Variant:
    curves = _curves(filmed, path, remote)
    figures = {
        "fps": filmed.fps,
        "engaged_s": path.engaged_ns / NS_PER_S,
        **follow_figures(curves, STILL_NS),
        "hindered": dict(path.hindered),
    }
    return Variant(name, filmed.fps, curves, figures)


def _curves(filmed: Film, path: ToolPath, remote: RemoteConfig) -> Curves:
    """Hand and tool at every frame since the engagement."""
    mapping = remote.mapping
    frames = [e for e in filmed.estimates if e.t_ns >= path.engaged_ns]
    frames_ns = np.array([e.t_ns for e in frames])
    truth_ns = np.arange(0, frames_ns[-1] + GRID_NS, GRID_NS)
    truths = [filmed.operator.truth(t_ns / NS_PER_S) for t_ns in truth_ns]
    directions = np.array([pointing(t.wrist, t.index, t.thumb) for t in truths])
    ahead = directions[0]
    truth = hand_rows(np.array([t.wrist for t in truths]), directions, truths[0].wrist, ahead)
    tool = tool_rows(np.array(path.poses), np.array(mapping.base_R_operator), mapping.scale, ahead)
    return Curves(
        frames_ns=frames_ns,
        hand_true=rows_at(frames_ns, truth_ns, truth),
        hand_measured=_measured(filmed.estimates)[-len(frames) :],
        tool=rows_at(frames_ns, np.array(path.times_ns), tool),
        truth_ns=truth_ns,
        truth=truth,
    )


def _measured(estimates: tuple[ArmEstimate, ...]) -> Array:
    """The measured hand's rows, NaN where it was not measured, since its mean pose while it was tracked and still."""
    points = np.array([[_known(e.wrist), _known(e.index), _known(e.thumb)] for e in estimates])
    wrists, directions = points[:, 0], pointing(points[:, 0], points[:, 1], points[:, 2])
    still = np.array([e.t_ns <= STILL_NS and e.status is TrackingStatus.TRACKED for e in estimates])
    return hand_rows(wrists, directions, np.nanmean(wrists[still], axis=0), np.nanmean(directions[still], axis=0))


def _known(point: Array | None) -> Array:
    return np.full(3, np.nan) if point is None else point


def _table(variant: Variant) -> CsvTable:
    curves, time_s = variant.curves, variant.curves.frames_ns / NS_PER_S
    kinds = {"hand_true": curves.hand_true, "hand_measured": curves.hand_measured, "tool": curves.tool}
    names = [f"{kind}_{column}" for kind in kinds for column in COLUMNS]
    frames = np.round(time_s * variant.fps)
    return CsvTable(("frame", "t_s", *names), np.column_stack([frames, time_s, *kinds.values()]))


def _in_words(behind: Figures) -> str:
    xy, xz = (behind["residual_deg"][plane]["mean"] for plane in ("xy_deg", "xz_deg"))
    return (
        f"lag {behind['lag_ms']:.0f} ms, residual {behind['residual_mm']['mean']:.1f} mm; "
        f"angles {behind['angle_lag_ms']:.0f} ms, {xy:.1f} deg (XY), {xz:.1f} deg (XZ)"
    )


def _plots(variants: Sequence[Variant]) -> Mapping[str, bytes]:
    """Positions (figure 6.15) and directions (figure 6.16), as PNG, all variants side by side."""
    since = "of hand and tool since engagement, operator frame"
    return {
        "positions": _plot(f"Position {since} (figure 6.15)", variants, (0, 1, 2)),
        "orientations": _plot(f"Direction {since} (figure 6.16)", variants, (3, 4)),
    }


def _plot(title: str, variants: Sequence[Variant], columns: Sequence[int]) -> bytes:
    figure, axes = panels(title, len(columns), len(variants), sharex=True, sharey="row")
    for row, column in zip(axes, columns, strict=True):
        for panel, variant in zip(row, variants, strict=True):
            curves = variant.curves
            time_s = curves.frames_ns / NS_PER_S
            panel.plot(time_s, curves.hand_measured[:, column], **HAND_MEASURED)
            panel.plot(time_s, curves.hand_true[:, column], **HAND_TRUE)
            panel.plot(time_s, curves.tool[:, column], **TOOL)
            describe_panel(panel, f"{variant.name}\n{_lag_and_residual(variant.figures, column)}", LABELS[column])
        widen(row[0], MIN_SPAN_MM if column < 3 else MIN_SPAN_DEG)
    return png(figure, axes, "time, s")


def _lag_and_residual(figures: Figures, column: int) -> str:
    """Lag and residual of one column behind the true and, in brackets, behind the measured hand."""
    lag_ms, residual = _behind(figures["tool_behind_true_hand"], column)
    measured_lag_ms, measured_residual = _behind(figures["tool_behind_measured_hand"], column)
    unit = "mm" if column < 3 else "deg"
    return (
        f"lag {lag_ms:.0f} ms, residual {residual:.1f} {unit} "
        f"(behind the measured hand: {measured_lag_ms:.0f} ms, {measured_residual:.1f} {unit})"
    )


def _behind(figures: Figures, column: int) -> tuple[float, float]:
    if column < 3:
        return figures["lag_ms"], figures["residual_by_axis_mm"]["xyz"[column]]
    return figures["angle_lag_ms"], figures["residual_deg"][("xy_deg", "xz_deg")[column - 3]]["mean"]
