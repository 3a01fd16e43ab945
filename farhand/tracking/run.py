"""`farhand track`: opens rig and cameras, shows progress, sums up what was found."""

from collections.abc import Callable
from contextlib import ExitStack, closing
from dataclasses import dataclass, field
from pathlib import Path

import msgspec
import numpy as np
from rich.console import Console
from rich.progress import MofNCompleteColumn, Progress, SpinnerColumn, TextColumn

from common.errors import ConfigError
from common.messages.hand import TrackingStatus
from farhand.outputs import check_file, check_folder
from farhand.tracking.recorded_pairs import refuse_other_rates
from farhand.tracking.track import POINTS, Summary, track_recording
from local_site.acquisition.rig_cameras import of_one_camera, open_rig_cameras
from local_site.calibration.rig_file import load_rig
from local_site.config import LocalConfig
from local_site.runtime.warm_up import warm_up
from local_site.tracking.choice import TrackingConfig

JOINTS = ("shoulder", "elbow", "wrist")
START, SILHOUETTE = "tracking.monocular.start", "silhouette"


@dataclass(frozen=True, slots=True)
class TrackSources:
    """What to track: the rig's file, a device, URL, video file or folder of images for each camera, and how.

    `also` is a third and a fourth camera, in the rig's order; `site` the configuration of the local site. Without
    `right`, `left` is the one camera that the configuration of the monocular tracker names.
    """

    rig: Path
    left: str
    right: str | None
    fps: float | None
    site: LocalConfig = field(default_factory=LocalConfig)
    also: tuple[str, ...] = ()


def run_track(
    sources: TrackSources, out: Path, annotate_dir: Path | None, should_stop: Callable[[], bool] = lambda: False
) -> str:
    """Track every instant of the sources until asked to stop, and sum it up in words.

    FarhandError names what cannot be opened; ConfigError what cannot be written, or what was not recorded together.
    """
    given = [source for source in (sources.left, sources.right, *sources.also) if source is not None]
    check_file("--out", out, [sources.rig, *given])
    check_folder("--annotate", annotate_dir, given)
    rig, site = load_rig(sources.rig), sources.site
    if sources.right is None:
        rig, tracking = of_one_camera(rig, site.tracking)
        site = msgspec.structs.replace(site, tracking=tracking)
    columns = (SpinnerColumn(), TextColumn("tracking"), MofNCompleteColumn())
    with ExitStack() as opened:
        cameras = open_rig_cameras(rig, given, sources.fps)
        left, *others = (opened.enter_context(closing(camera)) for camera in cameras)
        if sources.fps is None:
            refuse_other_rates(cameras)
        prepare_tracker(site.tracking)
        progress = opened.enter_context(Progress(*columns, console=Console(stderr=True)))
        task = progress.add_task("tracking", total=None)

        def show(pairs: int) -> None:
            progress.update(task, completed=pairs)

        done = track_recording(rig, left, others, out, annotate_dir, show, site, should_stop)
    return describe(done, out)


def prepare_tracker(tracking: TrackingConfig) -> None:
    """Compile the tracker, or load the code compiled earlier, with a message for the person who waits."""
    with Console(stderr=True).status("preparing the tracker (up to a minute the first time)"):
        warm_up(tracking)


def joint_settings(text: str) -> list[str]:
    """The settings of the monocular tracker's start for 'x,y x,y x,y', or for SILHOUETTE; ConfigError else."""
    if text == SILHOUETTE:
        return [f"{START}.by={SILHOUETTE}"]
    pairs = [pair.split(",") for pair in text.split()]
    try:
        pixels = [(float(x), float(y)) for x, y in pairs]
    except ValueError:
        pixels = []
    if len(pixels) != len(JOINTS):
        raise ConfigError(
            "--joints must be the pixels of shoulder, elbow and wrist as 'x,y x,y x,y', or the word silhouette, "
            f"not {text!r}"
        )
    given = [f"{START}.{joint}_px=[{x}, {y}]" for joint, (x, y) in zip(JOINTS, pixels, strict=True)]
    return [f"{START}.by=joints", *given]


def describe(summary: Summary, out: Path) -> str:
    """What was found in a recording, in three lines, and a line for each warning."""
    if not summary.pairs:
        return "no pair was tracked"
    found = ", ".join(f"{name} {summary.found[name]}" for name in POINTS)
    statuses = ", ".join(f"{count} {status.value}" for status, count in summary.statuses.items() if count)
    median, p95 = np.percentile(summary.ms, [50, 95])
    lines = [
        f"{summary.pairs} pairs: {statuses}",
        f"points found: {found}; gripper toggles: {summary.gripper_toggles}",
        f"{median:.1f} ms per pair (p95 {p95:.1f}); written to {out}",
    ]
    warnings = [sentence for sentence in (summary.left_out, summary.drift) if sentence]
    if not summary.statuses[TrackingStatus.TRACKED] + summary.statuses[TrackingStatus.DEGRADED]:
        warnings.append(f"nothing was tracked; most often: {summary.reasons.most_common(1)[0][0]}")
    return "\n".join([*lines, *(f"warning: {sentence}" for sentence in warnings)])
