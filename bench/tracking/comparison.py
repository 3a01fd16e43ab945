"""The silhouette tracker and MediaPipe Hands on the same images: time, gaps, errors, covariance consistency."""

import math
import time
from collections.abc import Mapping
from contextlib import ExitStack

import cv2
import numpy as np
from rich.console import Console, Group
from rich.table import Table

from bench.processes import UnavailableError
from bench.tracking.figures import NEES, RANK, SETTLED, Found, TrackingFigures, flat, judge
from bench.tracking.mediapipe_hands import MediaPipeHands, install
from bench.tracking.scenes import RECORDINGS, TrackingScene, recorded_scenes, simulated_scenes
from local_site.samples.hand_sample import GestureConfig, OpenHand
from local_site.simulation.body import ArmTruth
from local_site.tracking.silhouette.silhouette_tracker import SilhouetteTracker
from local_site.tracking.tracker import Views

NAMES = ("elbow", "wrist", "index", "thumb")
OURS = "silhouette"
TABLE_WIDTH = 120
NEEDED = ("elbow", "wrist", "index")
COLUMNS = {  # heading: figure (errors in mm, bias in the operator frame), decimals
    "frames": ("frames", 0),
    "mean": ("mean mm", 1),
    "p95": ("p95 mm", 1),
    "max": ("max mm", 1),
    "bias x": ("bias x mm", 1),
    "bias y": ("bias y mm", 1),
    "bias z": ("bias z mm", 1),
    "NEES (3)": (NEES, 2),
    "rank": (RANK, 2),
}


class SilhouetteContender:
    """Our tracker, timed, and a counter of the hand's openings that takes its estimates."""

    def __init__(self, scene: TrackingScene) -> None:
        self._tracker = SilhouetteTracker(scene.rig)
        self._hand = OpenHand()

    def track(self, views: Views) -> Found:
        """Track the next pair of images; the counter's time is not included."""
        wall, processor = time.perf_counter(), time.process_time()
        estimate = self._tracker.track(views)
        wall_ms, processor_ms = 1e3 * (time.perf_counter() - wall), 1e3 * (time.process_time() - processor)
        self._hand = self._hand.observe(estimate, GestureConfig())
        by_name = {name: getattr(estimate, name) for name in NAMES}
        return Found(
            points={name: point for name, point in by_name.items() if point is not None},
            wall_ms=wall_ms,
            processor_ms=processor_ms,
            covariances=estimate.covariances,
            thumb_inferred=estimate.thumb_inferred,
            toggles=self._hand.toggles,
        )


class Comparison:
    """Runs both trackers on each scene; once MediaPipe is unavailable it is skipped, with the reason shown."""

    def __init__(self, console: Console, resources: ExitStack) -> None:
        """`resources` ends MediaPipe's process."""
        self._console = console
        self._skip_reason = ""
        self._mediapipe: MediaPipeHands | None = None
        self._wall_ms: dict[str, list[float]] = {OURS: [], MediaPipeHands.name: []}
        try:
            self._mediapipe = resources.enter_context(MediaPipeHands(install()))
        except UnavailableError as error:
            self._skip_mediapipe(error)

    def measure(self, scene: TrackingScene) -> dict[str, float]:
        """The figures of one scene by name; prints them as a table too."""
        found, truth = self._run(scene)
        needed = {OURS: NEEDED, MediaPipeHands.name: MediaPipeHands.needed}
        figures = {name: judge(pairs, truth, needed[name]) for name, pairs in found.items()}
        notes = (f"{MediaPipeHands.name} skipped: {self._skip_reason}",) if self._skip_reason else ()
        self._console.print(as_table(scene.name, figures, notes))
        return {
            f"{scene.name}, {name}, {figure}": value
            for name, tracker_figures in figures.items()
            for figure, value in flat(tracker_figures).items()
        }

    def totals(self) -> dict[str, float]:
        """Over all pairs of the run: each tracker's time, and MediaPipe's as a multiple of ours."""
        result = {"MediaPipe measured": float(not self._skip_reason)}
        for name, times in self._wall_ms.items():
            if times:
                result |= {
                    f"{name}, median ms per pair": _percentile(times, 50),
                    f"{name}, p95 ms per pair": _percentile(times, 95),
                }
        if not self._skip_reason:
            ours, theirs = self._wall_ms.values()
            result["MediaPipe's median time by ours"] = _percentile(theirs, 50) / _percentile(ours, 50)
        return result

    def _run(self, scene: TrackingScene) -> tuple[Mapping[str, list[Found]], list[ArmTruth]]:
        """Run both trackers alternately, pair by pair, so that other load on the machine affects both alike."""
        silhouette = SilhouetteContender(scene)
        ours: list[Found] = []
        theirs: list[Found] = []
        truth = []
        for instant in scene.instants():
            ours.append(silhouette.track(instant.views))
            theirs += self._ask_mediapipe(scene, instant.views)
            truth.append(instant.truth)
        complete = {OURS: ours} | ({MediaPipeHands.name: theirs} if len(theirs) == len(ours) else {})
        for name, found in complete.items():
            self._wall_ms[name] += [f.wall_ms for f in found[SETTLED:]]
        return complete, truth

    def _ask_mediapipe(self, scene: TrackingScene, views: Views) -> list[Found]:
        if self._mediapipe is None:
            return []
        try:
            return [self._mediapipe.track(scene.name, scene.rig, views)]
        except UnavailableError as error:
            self._skip_mediapipe(error)
            return []

    def _skip_mediapipe(self, why: UnavailableError) -> None:
        self._mediapipe, self._skip_reason = None, str(why)


def _percentile(times_ms: list[float], percent: float) -> float:
    return float(np.percentile(times_ms, percent))


def measure() -> dict[str, float]:
    """The figures of every scene and over all pairs, by name; prints a table after each scene."""
    cv2.setNumThreads(1)
    console = Console(width=max(Console().width, TABLE_WIDTH))
    scenes = simulated_scenes()
    if RECORDINGS.exists():
        scenes = [*recorded_scenes(RECORDINGS), *scenes]
    else:
        console.print(f"recordings skipped: {RECORDINGS.name} of the shared data are not beside this checkout")
    figures: dict[str, float] = {}
    with ExitStack() as resources:
        comparison = Comparison(console, resources)
        for scene in scenes:
            figures |= comparison.measure(scene)
        totals = comparison.totals()
    console.print("\n".join(f"{figure}: {value:.1f}" for figure, value in totals.items()))
    return totals | figures


def as_table(scene: str, by_tracker: Mapping[str, TrackingFigures], notes: tuple[str, ...]) -> Group:
    """A scene's figures to print: errors in mm by tracker and point, then a line for each tracker, and notes."""
    table = Table(title=f"{scene} (errors and bias in mm)", title_justify="left")
    table.add_column("tracker")
    table.add_column("point")
    for column in COLUMNS:
        table.add_column(column, justify="right")
    for name, figures in by_tracker.items():
        for point, values in figures.points.items():
            rounded = ((values[figure], decimals) for figure, decimals in COLUMNS.values())
            texts = ("-" if math.isnan(value) else f"{value:.{decimals}f}" for value, decimals in rounded)
            table.add_row(name, point, *texts)
        table.add_section()
    return Group(table, *(f"{name}: {_in_words(figures.whole)}" for name, figures in by_tracker.items()), *notes, "")


def _in_words(whole: Mapping[str, float]) -> str:
    wall = f"median {whole['median ms per pair']:.1f}, p95 {whole['p95 ms per pair']:.1f} ms a pair"
    gaps = f"{whole['frames without result']:.0f} of {whole['frames']:.0f} frames without result"
    toggles = f"; {whole['toggles']:.0f} toggles of {whole['true toggles']:.0f}" if "toggles" in whole else ""
    return f"{wall} (processor {whole['median processor ms per pair']:.1f}); {gaps}{toggles}"
