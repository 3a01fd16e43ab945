"""The experiment "drift": the ROBONAUT report's incremental command against the relative one, on the humanoid arm."""

from collections.abc import Iterable, Iterator, Mapping, Sequence

import numpy as np

from common.config.loading import load_config
from common.geometry import Array, transform
from common.messages.hand import TrackingStatus
from farhand.loopback.scenario import ARM_FILES, HUMANOID, MONOCULAR, arm_settings
from farhand.reports.plotting import describe_panel, panels, png
from lab.experiments.following import follow_estimates
from lab.experiments.report import CsvTable, ExperimentReport, Figures, Progress, rounded
from lab.experiments.robonaut.footage import bare, frame_ns, render_footage, track_footage
from local_site.simulation.hazel import HAZEL_S_FRAMES, Swing, TrueArm, hazel_film, true_points
from local_site.tracking.config import MonocularConfig
from local_site.tracking.tracker import ArmEstimate
from remote_site.config import RemoteConfig
from remote_site.teleop.mapping import make_mapping

STILL_FRAMES, QUICK_FRAMES = 35, 60
LATENCY_MS = 10.0
COMMANDS = ("relative", "incremental")
PALMS = ("exact", "estimated")
ARRIVING = "incremental, an arm that arrives"
COLOURS = ("#288c28", "#d72828", "#2878c8")
MM = 1e3
TEXT = (
    "The palm of the arm of HAZEL-S commands the humanoid's: once exactly as it is, once as the monocular tracker "
    "estimates it in the pictures, not smoothed. relative: the palm's motion since engagement, added to the tool's "
    "position then. incremental: the motion since the last sample, added to where the tool was sent last, as in "
    "section 3 of the ROBONAUT report; at 30 frames a second the arm has not arrived when the next sample comes, and "
    "the rest of its motion is lost. An arm that arrives before the next sample, as the report's could at a second per "
    "frame, loses nothing. The samples always carry the palm's position, not its motion. All distances are from the "
    "true palm's motion, so they include the tracker's error where the palm is estimated."
)


def frame_count(quick: bool) -> int:
    """Count the pictures that are rendered and the samples that are sent, for a progress bar."""
    frames = STILL_FRAMES + (QUICK_FRAMES if quick else HAZEL_S_FRAMES)
    return frames * (1 + len(PALMS) * len(COMMANDS))


def drift_report(quick: bool, progress: Progress) -> ExperimentReport:
    """Run the experiment; always the same for the same installation."""
    frames, swing = QUICK_FRAMES if quick else HAZEL_S_FRAMES, Swing()
    arms = [swing.arm(max(k - STILL_FRAMES, 0)) for k in range(STILL_FRAMES + frames)]
    estimates = dict(zip(PALMS, (_exact(arms), _estimated(arms, progress)), strict=True))
    palms = np.array([true_points(arm)["palm"] for arm in arms])
    runs = {
        f"{command}, {palm} palm": _through_the_pipeline(command, estimates[palm], palms, progress)
        for command in COMMANDS
        for palm in PALMS
    }
    runs |= {f"{ARRIVING}, {palm} palm": _arriving(estimates[palm], palms) for palm in PALMS}
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


def _exact(arms: Iterable[TrueArm]) -> list[ArmEstimate]:
    """The true points, as if they were tracked."""
    estimates = []
    for k, arm in enumerate(arms):
        elbow, wrist, palm = (true_points(arm)[name] for name in ("elbow", "wrist", "palm"))
        estimates.append(ArmEstimate(frame_ns(k), TrackingStatus.TRACKED, "", elbow=elbow, wrist=wrist, palm=palm))
    return estimates


def _estimated(arms: Iterable[TrueArm], progress: Progress) -> list[ArmEstimate]:
    """The points as the monocular tracker finds them in the arms' pictures."""
    footage = render_footage(hazel_film(), map(bare, arms), progress)
    return list(track_footage(footage, MonocularConfig(setting="live"), 0.0).estimates)


def _through_the_pipeline(command: str, estimates: Sequence[ArmEstimate], palms: Array, progress: Progress) -> Array:
    """The tool's error (N, 3) at every frame since engagement, base frame, mm."""
    remote = _config(command)
    path = follow_estimates(_counted(estimates, progress), remote, LATENCY_MS)
    tool = np.array([pose[:3, 3] for pose in path.poses])
    seen_ns = np.array([estimate.t_ns for estimate in estimates[STILL_FRAMES:]], dtype=np.float64)
    at_frames = np.column_stack([np.interp(seen_ns, path.times_ns, tool[:, k]) for k in range(3)])
    return _error_mm(at_frames - tool[0], palms[STILL_FRAMES:], remote)


def _counted(estimates: Iterable[ArmEstimate], progress: Progress) -> Iterator[ArmEstimate]:
    for estimate in estimates:
        progress()
        yield estimate


def _arriving(estimates: Sequence[ArmEstimate], palms: Array) -> Array:
    """The tool's error of the mapping alone, with a tool that reaches each target before the next sample comes."""
    remote = _config("incremental")
    mapping, base_T_tool = make_mapping(remote.mapping), transform(np.eye(3), np.zeros(3))
    positions: list[Array] = []
    for estimate in estimates[STILL_FRAMES:]:
        if estimate.palm is not None:
            if not positions:
                mapping.engage(estimate.palm, None, base_T_tool)
            mapping.read(base_T_tool)
            base_T_tool = mapping.target(estimate.palm, None)
        positions.append(base_T_tool[:3, 3])
    return _error_mm(np.array(positions), palms[STILL_FRAMES:], remote)


def _error_mm(moved: Array, palms: Array, remote: RemoteConfig) -> Array:
    """The tool's error (N, 3) against the hand's position, base frame, mm."""
    base_R_operator, scale = np.array(remote.mapping.base_R_operator), remote.mapping.scale
    error_mm: Array = MM * (moved - scale * (palms - palms[0]) @ base_R_operator.T)
    return error_mm


def _plot(runs: Mapping[str, Array]) -> bytes:
    """The distances by frame: beside each other by how the palm was known, in colours by how it commanded."""
    figure, axes = panels("Distance of the tool from the hand's position", 1, len(PALMS), sharey=True)
    for k, (name, error_mm) in enumerate(runs.items()):
        command, _, palm = name.rpartition(", ")
        panel, colour = axes[0, k % len(PALMS)], COLOURS[k // len(PALMS)]
        panel.plot(np.linalg.norm(error_mm, axis=1), label=command, color=colour, linewidth=1.2)
        describe_panel(panel, palm, "distance, mm")
    return png(figure, axes, "frame")
