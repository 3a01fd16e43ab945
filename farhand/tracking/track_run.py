"""`farhand track`: checks its settings and where the results go, opens rig and cameras, shows progress."""

from collections.abc import Callable, Iterator, Sequence
from contextlib import ExitStack, closing, contextmanager
from dataclasses import dataclass, field
from datetime import UTC, datetime
from importlib.metadata import version
from pathlib import Path
from typing import Any

import msgspec
from rich.console import Console
from rich.progress import BarColumn, MofNCompleteColumn, Progress, SpinnerColumn, TextColumn, TimeRemainingColumn

from common.cameras.shown_source import shown_source
from common.cameras.sources import recorded_fps
from common.config.loading import apply_setting, load_config
from common.errors import ConfigError
from farhand.tracking.recorded_pairs import refuse_odd_rate, refuse_other_rates, stated_pairs
from farhand.tracking.results.outputs import TrackOutputs
from farhand.tracking.results.report.origin import origin_rows
from farhand.tracking.summary import Summary
from farhand.tracking.track import track_recording
from local_site.acquisition.rig_cameras import of_one_camera, open_rig_cameras
from local_site.calibration.rig_file import load_rig
from local_site.config import LocalConfig
from local_site.runtime.warm_up import warm_up
from local_site.tracking.choice import TrackingConfig
from local_site.tracking.registry import tracker_names

JOINTS = ("shoulder", "elbow", "wrist")
START, SILHOUETTE = "tracking.monocular.start", "silhouette"


@dataclass(frozen=True, slots=True)
class TrackSources:
    """The sources to track: the rig's file, a device, URL, video file or folder of images for each camera, and how.

    `also` is a third and a fourth camera, in the rig's order; `site` the configuration of the local site. Without
    `right`, `left` is the one camera that the configuration of the monocular tracker names.
    """

    rig: Path
    left: str
    right: str | None
    fps: float | None
    site: LocalConfig = field(default_factory=LocalConfig)
    also: tuple[str, ...] = ()


def run_track(sources: TrackSources, outputs: TrackOutputs, should_stop: Callable[[], bool] = lambda: False) -> Summary:
    """Track every instant of the sources until asked to stop, and sum it up.

    Before any work, FarhandError names what cannot be opened, or that matplotlib is missing; ConfigError what cannot be
    written, or what was not recorded together.
    """
    given = [source for source in (sources.left, sources.right, *sources.also) if source is not None]
    refuse_odd_rate(sources.fps)
    outputs.check([sources.rig, *given])
    rig, site = load_rig(sources.rig, "--rig"), sources.site
    if sources.right is None:
        rig, tracking = of_one_camera(rig, site.tracking)
        site = msgspec.structs.replace(site, tracking=tracking)
    with ExitStack() as opened:
        cameras = open_rig_cameras(rig, given, sources.fps)
        left, *others = (opened.enter_context(closing(camera)) for camera in cameras)
        if sources.fps is None:
            refuse_other_rates(cameras)
        fps = recorded_fps(left) or sources.fps
        outputs.check_rate(fps)
        prepare_tracker(site.tracking)
        stated = stated_pairs(cameras)
        show = opened.enter_context(_shown_progress(stated))
        named = [(camera.name, shown_source(source)) for camera, source in zip(rig.cameras, given, strict=True)]
        origin = origin_rows(sources.rig, named, site, fps, version("farhand"), datetime.now(UTC))
        results = outputs.results(fps, origin)
        summary = track_recording(rig, left, others, results, show, site, should_stop)
        summary.stated = stated
        return summary


@contextmanager
def _shown_progress(total: int | None) -> Iterator[Callable[[int], None]]:
    """A bar to the expected number of pairs, which gives way to more; without a number, one that only moves."""
    columns = SpinnerColumn(), TextColumn("tracking"), BarColumn(), MofNCompleteColumn(), TimeRemainingColumn()
    with Progress(*columns, console=Console(stderr=True)) as progress:
        task = progress.add_task("tracking", total=total)
        yield lambda pairs: progress.update(task, completed=pairs, total=total and max(total, pairs))


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


def refuse_other_tracker(tracker: str, settings: Sequence[str]) -> None:
    """ConfigError if the settings name a tracker that there is not, or another than --tracker or --monocular does."""
    method = _given_tracking(settings).get("method", tracker)
    if method == tracker:
        return
    load_config(LocalConfig, None, [f"tracking.method={method}"])
    raise ConfigError(
        f"--set tracking.method={method}: an option asks for the tracker {tracker}; leave one of them out"
    )


def unused_settings(tracking: TrackingConfig, settings: Sequence[str]) -> Iterator[str]:
    """A sentence for each setting that a track does not use, though a person may expect it to.

    Of tables of other trackers only `settings`, those of the command line, count: a file may hold the tables of all.
    """
    if tracking.profile_dir:
        yield "tracking.profile_dir is not used here: a track learns hand and forearm anew, and keeps no profile"
    used, given = tracking.method, _given_tracking(settings)
    for other in tracker_names():
        for key in given.get(other, {}) if other != used else ():
            cure = f"give tracking.{used}.{key}" if hasattr(getattr(tracking, used, None), key) else "leave it out"
            yield f"tracking.{other}.{key} belongs to the tracker {other}, but {used} is in use: {cure}"


def _given_tracking(settings: Sequence[str]) -> dict[str, Any]:
    """The table `tracking` of settings, unchecked."""
    table: dict[str, Any] = {}
    for setting in settings:
        apply_setting(table, setting)
    tracking = table.get("tracking", {})
    return tracking if isinstance(tracking, dict) else {}
