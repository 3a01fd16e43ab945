"""The experiment "drift": the ROBONAUT report's incremental command beside the relative one, on the humanoid arm."""

from dataclasses import dataclass
from typing import Any

import numpy as np

from common.clock import NS_PER_MS, NS_PER_S
from common.config import load_config
from common.errors import InterruptionError
from common.geometry import Array, transform
from common.messages.hand import TrackingStatus
from farhand.experiments.charts import Line, Panel, common_range, figure
from farhand.experiments.filming import Progress
from farhand.experiments.following import FollowingArm
from farhand.experiments.report import Data, ExperimentReport
from farhand.loopback.casting import (
    ARM_FILES,
    HUMANOID,
    MONOCULAR,
    arm_settings,
)
from local_site.simulation.hazel import FRAMES_PER_S, HAZEL_S_FRAMES, Swing, true_points
from local_site.tracking.tracker import ArmEstimate
from remote_site.config import RemoteConfig
from remote_site.teleop.mapping import make_mapping

STILL_FRAMES, QUICK_FRAMES = 35, 60
LATENCY_NS = 10 * NS_PER_MS
WAYS = ("relative", "incremental")
ARRIVING = "incremental, an arm that arrives"
COLOURS = ((40, 140, 40), (40, 40, 215), (200, 120, 40))
MM = 1e3
TEXT = (
    "The palm of the arm of HAZEL-S, exactly as it is, commands the humanoid's. relative: the palm's way since "
    "engagement on top of the tool's place then. incremental: the way since the last sample on top of where the tool "
    "is measured to be, as in section 3 of the ROBONAUT report; at 30 frames a second the arm is still on its way when "
    "the next sample comes, and what it had left to go is lost. An arm that arrives before the next sample, as the "
    "report's could at a second per frame, loses nothing. What is sent is always the palm's place, not its motion."
)


@dataclass(frozen=True, slots=True)
class Followed:
    """The tool off the hand's place in the base's axes (N, 3), mm, at every frame since engagement."""

    off_mm: Array

    @property
    def figures(self) -> dict[str, Any]:
        """Mean, largest and last distance."""
        distance = np.linalg.norm(self.off_mm, axis=1)
        figures = {"mean": distance.mean(), "largest": distance.max(), "last": distance[-1]}
        return {"frames": len(distance), "off_mm": {name: round(float(value), 3) for name, value in figures.items()}}


def frames_of(quick: bool) -> int:
    """How many samples are sent, for a progress bar."""
    return len(WAYS) * (STILL_FRAMES + (QUICK_FRAMES if quick else HAZEL_S_FRAMES))


def drift_report(quick: bool, progress: Progress) -> ExperimentReport:
    """Run the experiment; always the same for the same installation."""
    frames = QUICK_FRAMES if quick else HAZEL_S_FRAMES
    runs = {way: _through_the_chain(way, frames, progress) for way in WAYS}
    runs[ARRIVING] = _arriving(frames)
    compared = {name: run.figures for name, run in runs.items()}
    return ExperimentReport(
        title="Incremental against relative command",
        text=TEXT,
        figures={"experiment": "drift", "quick": quick, "runs": compared},
        compared=compared,
        plots={"drift": _plot(runs)},
        data={"drift": _data(runs)},
    )


def describe(report: ExperimentReport) -> str:
    """How far the tool is off, a line for each way."""
    return "\n".join(
        f"{name}: {figures['off_mm']['mean']} mm on average, {figures['off_mm']['largest']} mm at most, "
        f"{figures['off_mm']['last']} mm at the end"
        for name, figures in report.compared.items()
    )


def _config(command: str) -> RemoteConfig:
    return load_config(RemoteConfig, ARM_FILES[HUMANOID], (*arm_settings(MONOCULAR), f"mapping.command={command}"))


def _through_the_chain(command: str, frames: int, progress: Progress) -> Followed:
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
        if not progress():
            raise InterruptionError("interrupted before the experiment was done; nothing was written")
    tool = np.array([pose[:3, 3] for pose in arm.path.poses])
    seen_ns = np.array(times_ns[STILL_FRAMES:], dtype=np.float64)
    at_frames = np.column_stack([np.interp(seen_ns, arm.path.times_ns, tool[:, k]) for k in range(3)])
    return _off(at_frames - tool[0], np.array(palms[STILL_FRAMES:]), remote)


def _arriving(frames: int) -> Followed:
    """The mapping alone, with a tool that is where it was sent before the next sample comes."""
    remote, swing = _config("incremental"), Swing()
    mapping = make_mapping(remote.mapping)
    palms = np.array([true_points(swing.arm(k))["palm"] for k in range(frames)])
    base_T_tool = transform(np.eye(3), np.zeros(3))
    mapping.engage(palms[0], None, base_T_tool)
    places = []
    for palm in palms:
        mapping.read(base_T_tool)
        base_T_tool = mapping.target(palm, None)
        places.append(base_T_tool[:3, 3])
    return _off(np.array(places), palms, remote)


def _off(moved: Array, palms: Array, remote: RemoteConfig) -> Followed:
    turn, scale = np.array(remote.mapping.base_R_operator), remote.mapping.scale
    return Followed(MM * (moved - scale * (palms - palms[0]) @ turn.T))


def _plot(runs: dict[str, Followed]) -> Any:
    frames = np.arange(len(runs[ARRIVING].off_mm), dtype=np.float64)
    distances = {name: np.linalg.norm(run.off_mm, axis=1) for name, run in runs.items()}
    lines = tuple(
        Line(name, colour, 1, frames, distance)
        for (name, distance), colour in zip(distances.items(), COLOURS, strict=True)
    )
    panel = Panel(
        title="tool off the hand's place",
        x_label="frame",
        y_label="mm",
        lines=lines,
        x_range=(0.0, float(len(frames))),
        y_range=common_range(list(distances.values()), 1.0),
    )
    return figure("Incremental against relative command", [[panel]])


def _data(runs: dict[str, Followed]) -> Data:
    columns = tuple(f"{name.replace(', ', '_').replace(' ', '_')}_{axis}_mm" for name in runs for axis in "xyz")
    rows = np.hstack([run.off_mm for run in runs.values()])
    return Data(("frame", *columns), np.column_stack([np.arange(len(rows)), rows]))
