"""The track command: opens rig and cameras, shows progress, tells what was found."""

from contextlib import ExitStack, closing
from dataclasses import dataclass, field
from pathlib import Path

import numpy as np
from rich.console import Console
from rich.progress import MofNCompleteColumn, Progress, SpinnerColumn, TextColumn

from common.messages import TrackingStatus
from farhand.preparing import prepare_tracker
from farhand.track import POINTS, Summary, track_recording
from local_site.calibration.rig import load_rig
from local_site.rig_cameras import open_rig_cameras
from local_site.tracking.choice import TrackingConfig


@dataclass(frozen=True, slots=True)
class TrackSources:
    """What to track: the rig's file, a device, URL, video file or folder of images for each camera, and how.

    `also` is a third and a fourth camera, in the rig's order.
    """

    rig: Path
    left: str
    right: str
    fps: float | None
    tracking: TrackingConfig = field(default_factory=TrackingConfig)
    also: tuple[str, ...] = ()


def run_track(sources: TrackSources, out: Path, annotate_dir: Path | None) -> str:
    """Track everything the sources give, and sum it up in words; FarhandError names what cannot be opened."""
    rig = load_rig(sources.rig)
    prepare_tracker(sources.tracking)
    columns = (SpinnerColumn(), TextColumn("tracking"), MofNCompleteColumn())
    with ExitStack() as opened:
        cameras = open_rig_cameras(rig, (sources.left, sources.right, *sources.also), sources.fps)
        left, right, *also = (opened.enter_context(closing(camera)) for camera in cameras)
        progress = opened.enter_context(Progress(*columns, console=Console(stderr=True)))
        task = progress.add_task("tracking", total=None)

        def show(pairs: int) -> None:
            progress.update(task, completed=pairs)

        done = track_recording(rig, left, right, out, annotate_dir, show, sources.tracking, also)
    return describe(done, out)


def describe(summary: Summary, out: Path) -> str:
    """What a recording gave, in three lines, and one more if the calibration has drifted."""
    found = ", ".join(f"{name} {summary.found[name]}" for name in POINTS)
    statuses = ", ".join(f"{count} {status.value}" for status, count in summary.statuses.items() if count)
    median, p95 = np.percentile(summary.ms, [50, 95])
    warning = f"\nwarning: {summary.drift}" if summary.drift else ""
    if not summary.statuses[TrackingStatus.TRACKED] + summary.statuses[TrackingStatus.DEGRADED]:
        warning += f"\nwarning: nothing was tracked; most often: {summary.reasons.most_common(1)[0][0]}"
    return (
        f"{summary.pairs} pairs: {statuses}\n"
        f"points found: {found}; gripper toggles: {summary.gripper_toggles}\n"
        f"{median:.1f} ms per pair (p95 {p95:.1f}); written to {out}{warning}"
    )
