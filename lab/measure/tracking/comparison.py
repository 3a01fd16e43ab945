"""Our trackers of a bare arm and MediaPipe Hands on the same images: time, gaps, errors, covariance consistency."""

import math
import time
from collections.abc import Iterator, Mapping
from contextlib import ExitStack

import cv2
import numpy as np
from rich.console import Console, Group
from rich.table import Table

from common.errors import NotInstalledError
from common.messages.hand import TrackingStatus
from lab.films.film import TrackingFilm
from lab.films.listing import composed_films, right_arm_films
from lab.films.scenes import ANY_BARE_ARM, RECORDINGS, Instant, TrackingScene, recorded_scenes, simulated_scenes
from lab.measure.tracking.figures import NEES, RANK, SETTLED, Found, TrackingFigures, flat, judge
from lab.measure.tracking.mediapipe_hands import MediaPipeHands, install
from lab.measure.tracking.real_film import REAL, measure_real
from lab.stage.processes import UnavailableError
from local_site.samples.hand_sample import GestureConfig, OpenHand
from local_site.simulation.body import ArmTruth
from local_site.tracking.choice import TrackingConfig, make_tracker
from local_site.tracking.tracker import Views

SILHOUETTE, LEARNED = "silhouette", "learned"
OTHERS = (LEARNED, MediaPipeHands.name)
TABLE_WIDTH = 120
NEEDED = {
    SILHOUETTE: ("elbow", "wrist", "index"),
    LEARNED: ("elbow", "wrist", "index"),
    MediaPipeHands.name: ("wrist", "index"),
}
COLUMNS = {  # heading: figure (errors in mm, bias in the operator frame), decimals
    "frames": ("frames", 0),
    "mean": ("mean mm", 1),
    "relative": ("relative mm", 1),
    "p95": ("p95 mm", 1),
    "max": ("max mm", 1),
    "bias x": ("bias x mm", 1),
    "bias y": ("bias y mm", 1),
    "bias z": ("bias z mm", 1),
    "NEES (3)": (NEES, 2),
    "rank": (RANK, 2),
}
NAMES = ("elbow", "wrist", "index", "thumb")
SEED = 1


def filmed_scenes() -> list[TrackingScene]:
    """The films of a right arm: of the mesh, and of the recorded arm where the recordings are."""
    films = right_arm_films(SEED) + (composed_films(SEED) if RECORDINGS.exists() else [])
    return [filmed(film) for film in films]


def filmed(film: TrackingFilm) -> TrackingScene:
    """A film as a scene."""

    def instants() -> Iterator[Instant]:
        return (Instant(i.views, None if i.truth is None else i.truth.arm) for i in film.instants())

    return TrackingScene(f"film {film.name}", film.rig, instants, ANY_BARE_ARM)


class Contender:
    """A tracker by its method; NotInstalledError where its models are missing."""

    def __init__(self, method: str, scene: TrackingScene) -> None:
        self._tracker = make_tracker(scene.rig, TrackingConfig(method=method))
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
            is_tracked=estimate.status is TrackingStatus.TRACKED,
            toggles=self._hand.toggles,
        )


class Comparison:
    """Runs the trackers on each scene; one that is unavailable is skipped from then on, with the reason shown."""

    def __init__(self, console: Console, resources: ExitStack) -> None:
        """`resources` ends MediaPipe's process."""
        self._console = console
        self._skipped: dict[str, str] = {}
        self._mediapipe: MediaPipeHands | None = None
        self._wall_ms: dict[str, list[float]] = {SILHOUETTE: [], LEARNED: [], MediaPipeHands.name: []}
        try:
            self._mediapipe = resources.enter_context(MediaPipeHands(install()))
        except UnavailableError as error:
            self._skip_mediapipe(error)

    def measure(self, scene: TrackingScene) -> dict[str, float]:
        """The figures of one scene by name; prints them as a table too."""
        found, truth = self._run(scene)
        figures = {name: judge(pairs, truth, NEEDED[name]) for name, pairs in found.items()}
        notes = tuple(f"{name} skipped: {reason}" for name, reason in self._skipped.items())
        self._console.print(as_table(scene.name, figures, notes))
        return {
            f"{scene.name}, {name}, {figure}": value
            for name, tracker_figures in figures.items()
            for figure, value in flat(tracker_figures).items()
        }

    def totals(self) -> dict[str, float]:
        """Over all pairs of the run: each tracker's time, and MediaPipe's as a multiple of the silhouette tracker's."""
        result = {f"{name.split()[0]} measured": float(name not in self._skipped) for name in OTHERS}
        for name, times in self._wall_ms.items():
            if times:
                result |= {
                    f"{name}, median ms per pair": _percentile(times, 50),
                    f"{name}, p95 ms per pair": _percentile(times, 95),
                }
        if MediaPipeHands.name not in self._skipped:
            ours, theirs = self._wall_ms[SILHOUETTE], self._wall_ms[MediaPipeHands.name]
            result["MediaPipe's median time by ours"] = _percentile(theirs, 50) / _percentile(ours, 50)
        return result

    def _run(self, scene: TrackingScene) -> tuple[Mapping[str, list[Found]], list[ArmTruth]]:
        """Run all trackers in turn, pair by pair, so that other load on the machine affects them alike.

        What was found of each pair that shows the arm, and the truth of these pairs.
        """
        contenders = self._contenders(scene)
        found: dict[str, list[Found]] = {name: [] for name in (*contenders, MediaPipeHands.name)}
        truth = []
        for instant in scene.instants():
            here = {name: contender.track(instant.views) for name, contender in contenders.items()}
            here |= self._ask_mediapipe(scene, instant.views)
            if instant.truth is not None:
                truth.append(instant.truth)
                for name, each in here.items():
                    found[name].append(each)
        complete = {name: pairs for name, pairs in found.items() if len(pairs) == len(truth)}
        for name, pairs in complete.items():
            self._wall_ms[name] += [pair.wall_ms for pair in pairs[SETTLED:]]
        return complete, truth

    def _contenders(self, scene: TrackingScene) -> dict[str, Contender]:
        contenders: dict[str, Contender] = {}
        for method in scene.methods:
            try:
                contenders[method] = Contender(method, scene)
            except NotInstalledError as error:
                self._skipped[method] = str(error)
        return contenders

    def _ask_mediapipe(self, scene: TrackingScene, views: Views) -> dict[str, Found]:
        if self._mediapipe is None:
            return {}
        try:
            return {MediaPipeHands.name: self._mediapipe.track(scene.name, scene.rig, views)}
        except UnavailableError as error:
            self._skip_mediapipe(error)
            return {}

    def _skip_mediapipe(self, why: UnavailableError) -> None:
        self._mediapipe, self._skipped[MediaPipeHands.name] = None, str(why)


def _percentile(times_ms: list[float], percent: float) -> float:
    return float(np.percentile(times_ms, percent))


def measure() -> dict[str, float]:
    """The figures of every scene and over all pairs, by name; prints a table after each scene."""
    cv2.setNumThreads(1)
    console = Console(width=max(Console().width, TABLE_WIDTH))
    scenes = [*simulated_scenes(), *filmed_scenes()]
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
    figures |= _real_film(console)
    console.print("\n".join(f"{figure}: {value:.1f}" for figure, value in totals.items()))
    return totals | figures


def _real_film(console: Console) -> dict[str, float]:
    """The figures of the real film by name; prints them, or why there are none."""
    if not REAL.exists():
        console.print(f"real film skipped: {REAL.name} of the shared data is not beside this checkout")
        return {}
    try:
        figures = measure_real()
    except NotInstalledError as error:
        console.print(f"real film skipped: {error}")
        return {}
    console.print("real film, learned", *(f"{figure}: {value:.1f}" for figure, value in figures.items()), sep="\n")
    return {f"real film, learned, {figure}": value for figure, value in figures.items()}


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
    rotation = ""
    if "rotation mean deg" in whole:
        rotation = f"; rotation {whole['rotation mean deg']:.1f} deg, p95 {whole['rotation p95 deg']:.1f}"
    return f"{wall} (processor {whole['median processor ms per pair']:.1f}); {gaps}{toggles}{rotation}"
