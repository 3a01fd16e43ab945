"""The experiment "follow": one hand motion, followed as in the thesis and as Farhand does it, side by side."""

from dataclasses import dataclass

import numpy as np

from common.clock import NS_PER_S
from common.geometry import Array
from common.messages.hand import TrackingStatus
from farhand.experiments.filming import Film, Progress, film
from farhand.experiments.follow import (
    COLUMNS,
    GRID_NS,
    Curves,
    Figures,
    follow_figures,
    hand_rows,
    pointing,
    rows_at,
    seconds,
    tool_rows,
)
from farhand.experiments.following import ToolPath, follow_by_mean, follow_by_pipeline
from farhand.experiments.plots import Way, follow_plots
from farhand.experiments.report import Data, ExperimentReport
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
TEXT = (
    "A simulated hand reaches, adjusts and carries as in figures 6.15 and 6.16 of the thesis. Two cameras film it, the "
    "tracker measures it, and the tool follows: once by the mean of nine frames at 5 frames per second, mapped onto an "
    "arm that is at once where its model reaches, and once by Farhand's own settings through its whole chain. Lag is "
    "the delay at which hand and tool fit best, the residual what is left at that delay."
)


@dataclass(frozen=True, slots=True)
class Setup:
    """What both ways have in common."""

    simulation: SimulationConfig
    remote: RemoteConfig
    seconds: float


def frames_of(quick: bool) -> int:
    """How many frames are filmed, for a progress bar."""
    filmed_s = _setup(quick).seconds
    return sum(round(filmed_s * fps) + 1 for fps in (THESIS_FPS, FARHAND_FPS))


def follow_report(quick: bool, progress: Progress) -> ExperimentReport:
    """Run the experiment; always the same for the same settings. FarhandError says why it could not be run."""
    setup, tracking, own = _setup(quick), TrackingConfig(), SmoothingConfig()
    slow = film(setup.simulation, tracking, THESIS_FPS, setup.seconds, progress)
    fast = film(setup.simulation, tracking, FARHAND_FPS, setup.seconds, progress)
    by_mean = follow_by_mean(slow, THESIS_SMOOTHING, setup.remote)
    by_chain = follow_by_pipeline(fast, own, setup.remote, LATENCY_MS)
    ways = {
        "mean_5fps": _way("9-frame mean at 5 fps", slow, by_mean, setup),
        "farhand_30fps": _way("Farhand at 30 fps", fast, by_chain, setup),
    }
    return ExperimentReport(
        title="Hand against tool: the thesis's mean and Farhand's chain",
        text=TEXT,
        figures={
            "experiment": "follow",
            "settings": _settings(quick, setup),
            **{k: w.figures for k, w in ways.items()},
        },
        compared={way.name: way.figures for way in ways.values()},
        plots=follow_plots(tuple(ways.values())),
        data={f"follow_{name}": _data(way.curves, way.fps) for name, way in ways.items()},
    )


def _setup(quick: bool) -> Setup:
    motion = MotionConfig(name="reach_and_adjust", still_s=STILL_S)
    moves_s = QUICK_MOVES_S if quick else MOVES_S
    return Setup(SimulationConfig(motion=motion), RemoteConfig(), STILL_S + moves_s)


def _settings(quick: bool, setup: Setup) -> Figures:
    return {
        "quick": quick,
        "seed": setup.simulation.seed,
        "motion": setup.simulation.motion.name,
        "still_s": STILL_S,
        "seconds": setup.seconds,
        "robot": setup.remote.robot.model,
        "mean_frames": THESIS_SMOOTHING.mean_frames,
        "mean_latency_ms": 0.0,
        "farhand_latency_ms": LATENCY_MS,
    }


def _way(name: str, filmed: Film, path: ToolPath, setup: Setup) -> Way:
    curves = _curves(filmed, path, setup)
    figures = {
        "fps": filmed.fps,
        "engaged_s": path.engaged_ns / NS_PER_S,
        **follow_figures(curves, STILL_NS),
        "hindered": dict(path.hindered),
    }
    return Way(name, filmed.fps, curves, figures)


def _curves(filmed: Film, path: ToolPath, setup: Setup) -> Curves:
    """Hand and tool at every frame since the engagement."""
    mapping = setup.remote.mapping
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
    """The measured hand's rows, NaN where it was not measured, since its mean place while it was tracked and still."""
    points = np.array([[_known(e.wrist), _known(e.index), _known(e.thumb)] for e in estimates])
    wrists, directions = points[:, 0], pointing(points[:, 0], points[:, 1], points[:, 2])
    still = np.array([e.t_ns <= STILL_NS and e.status is TrackingStatus.TRACKED for e in estimates])
    return hand_rows(wrists, directions, np.nanmean(wrists[still], axis=0), np.nanmean(directions[still], axis=0))


def _known(point: Array | None) -> Array:
    return np.full(3, np.nan) if point is None else point


def _data(curves: Curves, fps: float) -> Data:
    kinds = {"hand_true": curves.hand_true, "hand_measured": curves.hand_measured, "tool": curves.tool}
    frames = np.round(seconds(curves.frames_ns) * fps)
    names = [f"{kind}_{column}" for kind in kinds for column in COLUMNS]
    return Data(("frame", "t_s", *names), np.column_stack([frames, seconds(curves.frames_ns), *kinds.values()]))


def describe(report: ExperimentReport) -> str:
    """Lag and residual of both ways, behind the true and behind the measured hand, a line each."""
    return "\n".join(
        f"{name}, behind the {hand} hand: {_behind(figures[f'tool_behind_{hand}_hand'])}"
        for name, figures in report.compared.items()
        for hand in ("true", "measured")
    )


def _behind(behind: Figures) -> str:
    xy, xz = (behind["residual_deg"][plane]["mean"] for plane in ("xy_deg", "xz_deg"))
    return (
        f"lag {behind['lag_ms']:.0f} ms, residual {behind['residual_mm']['mean']:.1f} mm; "
        f"angles {behind['angle_lag_ms']:.0f} ms, {xy:.1f} deg (XY), {xz:.1f} deg (XZ)"
    )
