"""The experiment "follow": one hand motion, followed as in the thesis, and as Farhand does it with three robots."""

from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from typing import TYPE_CHECKING, Any

import numpy as np
from msgspec.structs import replace

from common.clock import NS_PER_S
from common.geometry import Array
from common.messages.hand import TrackingStatus
from farhand.reports.plotting import describe_panel, panels, png, widen
from lab.experiments.follow_figures import (
    COLUMNS,
    GRID_NS,
    Curves,
    follow_figures,
    gripper_figures,
    hand_rows,
    pointing,
    rows_at,
    tool_rows,
    with_closed_hand,
)
from lab.experiments.following import Film, ToolPath, film, follow_by_mean, follow_by_pipeline, follow_on_robot
from lab.experiments.report import CsvTable, ExperimentReport, Figures, Progress, rounded
from lab.stage.stepped.robots import SteppedCell, SteppedController, SteppedRobot
from local_site.samples.smoothing import SmoothingConfig
from local_site.simulation.config import MotionConfig, SimulationConfig
from local_site.tracking.choice import TrackingConfig
from remote_site.config import RemoteConfig
from remote_site.drivers.c500c.emulator import Emulated
from remote_site.safety.config import TABLE

if TYPE_CHECKING:
    from matplotlib.axes import Axes

Style = dict[str, Any]

STILL_S = 4.0  # at 5 fps the tracker learns the arm for two seconds, and the mean fills for as long
STILL_NS = round(STILL_S * NS_PER_S)
MOVES_S, QUICK_MOVES_S = 34.0, 4.5
THESIS_FPS, FARHAND_FPS = 5.0, 30.0
LATENCY_MS = 10.0
THESIS_SMOOTHING = SmoothingConfig(method="mean", mean_frames=9, max_gap_s=1.0)
SIMULATION = SimulationConfig(motion=MotionConfig(name="reach_and_adjust", still_s=STILL_S))
OBJECT_M = 0.03  # between the emulated gripper's fingers, which open by no more than the block is thick
TABLE_RISE_M = 0.085  # above the configured table, so that the block stands where this hand closes
TEXT = (
    "A simulated hand reaches, adjusts, grasps, carries and releases as in figures 6.15 and 6.16 of the thesis. Two "
    "cameras film it, the tracker measures it, and the tool follows: once by the mean of nine frames at 5 frames per "
    "second, mapped onto an arm that reaches each target without delay, and by Farhand's own settings through its "
    "whole pipeline with three robots: one that follows exactly (kinematic), the arm with its controller in MuJoCo, "
    "where it carries a block, and the emulated controller of the A465 (C500C) behind its serial line. Lag is the "
    "delay at which hand and tool fit best; the residual is the distance that remains at that delay."
)
HAND_MEASURED = {"label": "hand, measured", "color": "#64b4eb", "linewidth": 3.4}
HAND_TRUE = {"label": "hand, true", "color": "#282828", "linewidth": 0.9}
GRIPPER: Style = {"label": "gripper's opening", "color": "#6e3cb4", "linewidth": 1.6}
HAND_OPENS: Style = {"label": "hand seen open", "color": "#8c8c8c", "linewidth": 1.0, "linestyle": ":"}
TOOL = {"label": "tool", "color": "#d72828", "linewidth": 1.6}
LABELS = ("X, mm", "Y, mm", "Z, mm", "XY plane, deg", "XZ plane, deg")
MIN_SPAN_MM, MIN_SPAN_DEG = 10.0, 4.0
GRIPPER_RANGE_MM = 0.0, 70.0


@dataclass(frozen=True, slots=True)
class Variant:
    """One method to follow the hand: its name, its frames per second, its curves and figures."""

    name: str
    fps: float
    curves: Curves
    figures: Figures


def frame_count(quick: bool) -> int:
    """Count the frames that are filmed, and followed by robots that take their time, for a progress bar."""
    slow, fast = (round(_filmed_s(quick) * fps) + 1 for fps in (THESIS_FPS, FARHAND_FPS))
    return slow + 3 * fast


def follow_report(quick: bool, progress: Progress) -> ExperimentReport:
    """Run the experiment; always the same for the same settings. ProcessError when the arm was never engaged."""
    filmed_s, remote = _filmed_s(quick), cell_with_block()
    slow, fast = (film(SIMULATION, TrackingConfig(), fps, filmed_s, progress) for fps in (THESIS_FPS, FARHAND_FPS))
    cell, controller = SteppedCell(remote), SteppedController(remote, Emulated(object_m=OBJECT_M))
    stood = cell.block_xy_m

    def with_robot(robot: SteppedRobot) -> ToolPath:
        return follow_on_robot(fast, SmoothingConfig(), remote, LATENCY_MS, robot, progress)

    exactly = follow_by_pipeline(fast, SmoothingConfig(), remote, LATENCY_MS)
    variants = {
        "mean_5fps": _variant("9-frame mean at 5 fps", slow, follow_by_mean(slow, THESIS_SMOOTHING, remote), remote),
        "kinematic_30fps": _variant("Farhand, kinematic", fast, exactly, remote),
        "mujoco_30fps": _variant("Farhand, MuJoCo", fast, with_robot(cell), remote),
        "c500c_30fps": _variant("Farhand, emulated C500C", fast, with_robot(controller), remote),
    }
    carried_mm = rounded(1e3 * float(np.linalg.norm(cell.block_xy_m - stood)))
    variants["mujoco_30fps"].figures["block_carried_mm"] = carried_mm
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
        title="Hand against tool: the thesis's mean, and Farhand's pipeline with three robots",
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


def cell_with_block() -> RemoteConfig:
    """The default cell, its table raised for the cell's physics and for the guard alike."""
    remote = RemoteConfig()
    collision, scene = remote.safety.collision, remote.simulation.scene
    top_m = scene.table_z_m + TABLE_RISE_M
    fixtures = tuple(
        replace(box, max_m=(*box.max_m[:2], top_m)) if box.name == TABLE.name else box for box in collision.fixtures
    )
    return replace(
        remote,
        safety=replace(remote.safety, collision=replace(collision, fixtures=fixtures)),
        simulation=replace(remote.simulation, scene=replace(scene, table_z_m=top_m)),
    )


def _filmed_s(quick: bool) -> float:
    return STILL_S + (QUICK_MOVES_S if quick else MOVES_S)


def _variant(name: str, filmed: Film, path: ToolPath, remote: RemoteConfig) -> Variant:
    curves = _curves(filmed, path, remote)
    figures = {
        "fps": filmed.fps,
        "engaged_s": path.engaged_ns / NS_PER_S,
        **follow_figures(curves, STILL_NS),
        **gripper_figures(curves.gripper_mm),
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
    truth = with_closed_hand(truth, _is_closed(filmed, truth_ns))
    tool = tool_rows(np.array(path.poses), np.array(mapping.base_R_operator), mapping.scale, ahead)
    return Curves(
        frames_ns=frames_ns,
        hand_true=rows_at(frames_ns, truth_ns, truth),
        hand_measured=_measured(filmed)[-len(frames) :],
        tool=rows_at(frames_ns, np.array(path.times_ns), tool),
        truth_ns=truth_ns,
        truth=truth,
        gripper_mm=1e3 * np.interp(frames_ns, path.times_ns, path.openings_m),
        hand_open=np.array([e.hand_open for e in frames]),
    )


def _is_closed(filmed: Film, times_ns: Array) -> Array:
    """Return at which of these times (N,) the true hand does not open."""
    return np.array([filmed.operator.pose(t_ns / NS_PER_S).openness == 0.0 for t_ns in times_ns])


def _measured(filmed: Film) -> Array:
    """The measured hand's rows, NaN where it was not measured, since its mean pose while it was tracked and still."""
    estimates = filmed.estimates
    points = np.array([[_known(e.wrist), _known(e.index), _known(e.thumb)] for e in estimates])
    wrists, directions = points[:, 0], pointing(points[:, 0], points[:, 1], points[:, 2])
    still = np.array([e.t_ns <= STILL_NS and e.status is TrackingStatus.TRACKED for e in estimates])
    rows = hand_rows(wrists, directions, np.nanmean(wrists[still], axis=0), np.nanmean(directions[still], axis=0))
    return with_closed_hand(rows, _is_closed(filmed, np.array([e.t_ns for e in estimates])))


def _known(point: Array | None) -> Array:
    return np.full(3, np.nan) if point is None else point


def _table(variant: Variant) -> CsvTable:
    curves, time_s = variant.curves, variant.curves.frames_ns / NS_PER_S
    kinds = {"hand_true": curves.hand_true, "hand_measured": curves.hand_measured, "tool": curves.tool}
    names = [f"{kind}_{column}" for kind in kinds for column in COLUMNS]
    frames = np.round(time_s * variant.fps)
    hand_and_gripper = curves.hand_open, curves.gripper_mm
    columns = ("frame", "t_s", *names, "hand_open", "gripper_mm")
    return CsvTable(columns, np.column_stack([frames, time_s, *kinds.values(), *hand_and_gripper]))


def _in_words(behind: Figures) -> str:
    xy, xz = (behind["residual_deg"][plane]["mean"] for plane in ("xy_deg", "xz_deg"))
    return (
        f"lag {behind['lag_ms']:.0f} ms, residual {behind['residual_mm']['mean']:.1f} mm; "
        f"angles {behind['angle_lag_ms']:.0f} ms, {xy:.1f} deg (XY), {xz:.1f} deg (XZ)"
    )


def _plots(variants: Sequence[Variant]) -> Mapping[str, bytes]:
    """Positions with the gripper (figure 6.15) and directions (figure 6.16), as PNG, all variants side by side."""
    since = "of hand and tool since engagement, operator frame"
    return {
        "figure_6_15_positions": _plot(f"Position {since} (figure 6.15)", variants, (0, 1, 2), with_gripper=True),
        "figure_6_16_orientations": _plot(f"Direction {since} (figure 6.16)", variants, (3, 4)),
    }


def _plot(title: str, variants: Sequence[Variant], columns: Sequence[int], *, with_gripper: bool = False) -> bytes:
    figure, axes = panels(title, len(columns) + with_gripper, len(variants), sharex=True, sharey="row")
    for row, column in zip(axes, columns, strict=False):
        for panel, variant in zip(row, variants, strict=True):
            curves = variant.curves
            time_s = curves.frames_ns / NS_PER_S
            panel.plot(time_s, curves.hand_measured[:, column], **HAND_MEASURED)
            panel.plot(time_s, curves.hand_true[:, column], **HAND_TRUE)
            panel.plot(time_s, curves.tool[:, column], **TOOL)
            describe_panel(panel, f"{variant.name}\n{_lag_and_residual(variant.figures, column)}", LABELS[column])
        widen(row[0], MIN_SPAN_MM if column < 3 else MIN_SPAN_DEG)
    if with_gripper:
        _plot_grippers(axes[-1], variants)
    return png(figure, axes, "time, s")


def _plot_grippers(row: "Sequence[Axes]", variants: Sequence[Variant]) -> None:
    """The gripper's opening, and when the hand was seen open, which toggles it."""
    for panel, variant in zip(row, variants, strict=True):
        curves = variant.curves
        time_s, opens = curves.frames_ns / NS_PER_S, np.diff(curves.hand_open.astype(int), prepend=0) > 0
        panel.plot(time_s, curves.gripper_mm, **GRIPPER)
        for t_s in time_s[opens]:
            panel.axvline(t_s, **HAND_OPENS)
        without = np.isnan(curves.gripper_mm).all()
        describe_panel(panel, f"{variant.name}: {'no gripper' if without else 'gripper'}", "gripper, mm")
    row[0].set_ylim(*GRIPPER_RANGE_MM)


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
