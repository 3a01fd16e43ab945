"""The experiment "drift": the ROBONAUT report's incremental command against the relative one, on the humanoid arm."""

from collections.abc import Mapping

import numpy as np

from common.clock import NS_PER_MS, NS_PER_S
from common.config import load_config
from common.geometry import Array, transform
from common.messages.hand import TrackingStatus
from farhand.experiments.following import FollowingArm
from farhand.experiments.report import CsvTable, ExperimentReport, Figures, Progress, rounded
from farhand.loopback.scenario import ARM_FILES, HUMANOID, MONOCULAR, arm_settings
from farhand.reports.plotting import describe_panel, panels, png
from local_site.simulation.hazel import FRAMES_PER_S, HAZEL_S_FRAMES, Swing, true_points
from local_site.tracking.tracker import ArmEstimate
from remote_site.config import RemoteConfig
from remote_site.teleop.mapping import make_mapping

STILL_FRAMES, QUICK_FRAMES = 35, 60
LATENCY_NS = 10 * NS_PER_MS
COMMANDS = ("relative", "incremental")
ARRIVING = "incremental, an arm that arrives"
COLOURS = ("#288c28", "#d72828", "#2878c8")
MM = 1e3
TEXT = (
    "The palm of the arm of HAZEL-S, exactly as it is, commands the humanoid's. relative: the palm's motion since "
    "engagement, added to the tool's position then. incremental: the motion since the last sample, added to the "
    "measured position of the tool, as in section 3 of the ROBONAUT report; at 30 frames a second the arm has not "
    "arrived when the next sample comes, and the rest of its motion is lost. An arm that arrives before the next "
    "sample, as the report's could at a second per frame, loses nothing. The samples always carry the palm's position, "
    "not its motion."
)


def frame_count(quick: bool) -> int:
    """How many samples are sent, for a progress bar."""
    return len(COMMANDS) * (STILL_FRAMES + (QUICK_FRAMES if quick else HAZEL_S_FRAMES))


def drift_report(quick: bool, progress: Progress) -> ExperimentReport:
    """Run the experiment; always the same for the same installation."""
    frames = QUICK_FRAMES if quick else HAZEL_S_FRAMES
    runs = {command: _through_the_pipeline(command, frames, progress) for command in COMMANDS}
    runs[ARRIVING] = _arriving(frames)
    compared = {name: _figures(error_mm) for name, error_mm in runs.items()}
    columns = [f"{name.replace(', ', '_').replace(' ', '_')}_{axis}_mm" for name in runs for axis in "xyz"]
    rows = np.column_stack([np.arange(frames), *runs.values()])
    return ExperimentReport(
        title="Incremental against relative command",
        text=TEXT,
        summary="\n".join(f"{name}: {_in_words(figures['off_mm'])}" for name, figures in compared.items()),
        figures={"experiment": "drift", "quick": quick, "runs": compared},
        compared=compared,
        plots={"drift": _plot(runs)},
        data={"drift": CsvTable(("frame", *columns), rows)},
    )


def _figures(error_mm: Array) -> Figures:
    """Mean, largest and last distance."""
    distances = np.linalg.norm(error_mm, axis=1)
    figures = {"mean": distances.mean(), "largest": distances.max(), "last": distances[-1]}
    return {"frames": len(distances), "off_mm": {name: rounded(value) for name, value in figures.items()}}


def _in_words(off_mm: Figures) -> str:
    return f"{off_mm['mean']} mm on average, {off_mm['largest']} mm at most, {off_mm['last']} mm at the end"


def _config(command: str) -> RemoteConfig:
    return load_config(RemoteConfig, ARM_FILES[HUMANOID], (*arm_settings(MONOCULAR), f"mapping.command={command}"))


def _through_the_pipeline(command: str, frames: int, progress: Progress) -> Array:
    """The tool's error (N, 3) at every frame since engagement, base frame, mm."""
    remote = _config(command)
    arm, swing = FollowingArm(remote), Swing()
    times_ns, palms = [], []
    for k in range(STILL_FRAMES + frames):
        t_ns = round((k + 1) * NS_PER_S / FRAMES_PER_S)
        points = true_points(swing.arm(max(k - STILL_FRAMES, 0)))
        arm.run_until(t_ns + LATENCY_NS)
        elbow, wrist, palm = (points[name] for name in ("elbow", "wrist", "palm"))
        arm.send(ArmEstimate(t_ns, TrackingStatus.TRACKED, "", elbow=elbow, wrist=wrist, palm=palm))
        times_ns.append(t_ns)
        palms.append(palm)
        progress()
    tool = np.array([pose[:3, 3] for pose in arm.path.poses])
    seen_ns = np.array(times_ns[STILL_FRAMES:], dtype=np.float64)
    at_frames = np.column_stack([np.interp(seen_ns, arm.path.times_ns, tool[:, k]) for k in range(3)])
    return _error_mm(at_frames - tool[0], np.array(palms[STILL_FRAMES:]), remote)


def _arriving(frames: int) -> Array:
    """The tool's error of the mapping alone, with a tool that reaches each target before the next sample comes."""
    remote, swing = _config("incremental"), Swing()
    mapping = make_mapping(remote.mapping)
    palms = np.array([true_points(swing.arm(k))["palm"] for k in range(frames)])
    base_T_tool = transform(np.eye(3), np.zeros(3))
    mapping.engage(palms[0], None, base_T_tool)
    positions = []
    for palm in palms:
        mapping.read(base_T_tool)
        base_T_tool = mapping.target(palm, None)
        positions.append(base_T_tool[:3, 3])
    return _error_mm(np.array(positions), palms, remote)


def _error_mm(moved: Array, palms: Array, remote: RemoteConfig) -> Array:
    """The tool's error (N, 3) against the hand's position, base frame, mm."""
    base_R_operator, scale = np.array(remote.mapping.base_R_operator), remote.mapping.scale
    error_mm: Array = MM * (moved - scale * (palms - palms[0]) @ base_R_operator.T)
    return error_mm


def _plot(runs: Mapping[str, Array]) -> bytes:
    figure, axes = panels("Incremental against relative command", 1)
    for (name, error_mm), colour in zip(runs.items(), COLOURS, strict=True):
        axes[0, 0].plot(np.linalg.norm(error_mm, axis=1), label=name, color=colour, linewidth=1.2)
    describe_panel(axes[0, 0], "distance of the tool from the hand's position", "distance, mm")
    return png(figure, axes, "frame")
