"""The experiment "robonaut": an arm grasps and moves a flask before one camera, and the humanoid does the same."""

from collections.abc import Mapping
from dataclasses import dataclass

from common.cameras.camera import Image
from common.config.loading import load_config
from common.geometry import Array
from farhand.loopback.scenario import ARM_FILES, HUMANOID, MONOCULAR, arm_settings
from farhand.reports.plate import plate
from lab.experiments.report import CsvTable, ExperimentReport, Figures, Progress
from lab.experiments.robonaut.commanded import (
    CommandedHumanoid,
    command_humanoid,
    commanded_figures,
    commanded_table,
)
from lab.experiments.robonaut.figures.frames import frames_shown, overlays_plate
from lab.experiments.robonaut.figures.plots import motion_plot
from lab.experiments.robonaut.footage import Footage, Shot, Tracked, render_footage, track_footage
from lab.experiments.robonaut.grasping import GRASPING, HANDLING_FRAMES, MOVING, Handling, grasping_film
from local_site.simulation.textured_arm import Scenery
from local_site.tracking.config import MonocularConfig
from remote_site.config import RemoteConfig
from remote_site.simulation.cell import build_cell
from remote_site.video.cell_cameras import CellRenderer

STILL_FRAMES, QUICK_FRAMES = 35, 45
CLICK_PX = 1.0  # an operator clicks on whole pixels
LIVE = MonocularConfig(setting="live")
VIEWS = ("coronal", "sagittal")
SIZE_PX, TILE_PX = (480, 480), 320
TEXT = (
    "An arm grasps a flask (HAZEL-A) and moves one (HAZEL-B) before a bookshelf and one camera, as in the third "
    "experiment of the report Teleoperating ROBONAUT (2002). The palm that the monocular tracker estimates goes "
    "through the whole chain, from smoothing and sample to the guard, to the kinematic humanoid. The report's "
    "sequences show a person and are not available: these are simulated, so that the true palm is known. The "
    "report's ROBONAUT is NASA's; this is a humanoid of its own. Reached is where the humanoid's palm is when the "
    "next sample arrives."
)


@dataclass(frozen=True, slots=True)
class HandlingSequence:
    """One of the report's sequences: its motion, its scenery, its figures, and the frames they show, from 1."""

    handling: Handling
    scenery: Scenery
    figures: tuple[int, int, int]
    shown: tuple[int, ...]


@dataclass(frozen=True, slots=True)
class SequenceRun:
    """A sequence from its pictures to the humanoid, all of the same frames."""

    footage: Footage
    tracked: Tracked
    commanded: CommandedHumanoid


SEQUENCES: Mapping[str, HandlingSequence] = {
    "hazel_a": HandlingSequence(GRASPING, Scenery(noise=3.0, seed=21), (17, 18, 21), (1, 40, 80, 116, 160, 200)),
    "hazel_b": HandlingSequence(MOVING, Scenery(noise=3.0, seed=22), (19, 20, 22), (1, 45, 90, 160, 180, 200)),
}


class HumanoidViews:
    """Renders the humanoid in any posture of its arm, from the front and from its right, as in the report's figure 8.

    CameraError with the cure where EGL is missing.
    """

    def __init__(self, remote: RemoteConfig) -> None:
        self._cell = build_cell(remote.simulation, remote.robot, dressed=True)
        self._at_rest = self._cell.start().qpos.copy()
        self._renderer = CellRenderer(self._cell, *SIZE_PX)

    def plate(self, postures: Mapping[int, Array]) -> bytes:
        """The PNG of postures (n,) in rad by number of frame: the coronal views above the sagittal ones."""
        tiles = [(f"frame {k}, {view}", self._picture(view, q)) for view in VIEWS for k, q in postures.items()]
        return plate(tiles, len(postures), TILE_PX)

    def close(self) -> None:
        """Release what the graphics hold; further calls do nothing."""
        self._renderer.close()

    def _picture(self, view: str, q: Array) -> Image:
        qpos = self._at_rest.copy()
        qpos[self._cell.arm] = q
        return self._renderer.render(self._renderer.view_id(view), qpos)


def frame_count(quick: bool) -> int:
    """Count the pictures that are rendered, for a progress bar."""
    return len(SEQUENCES) * (STILL_FRAMES + _frames(quick) + 1)


def robonaut_report(quick: bool, progress: Progress) -> ExperimentReport:
    """Run the experiment; always the same for the same installation. CameraError, before any work, without EGL."""
    remote = load_config(RemoteConfig, ARM_FILES[HUMANOID], arm_settings(MONOCULAR))
    views = HumanoidViews(remote)
    try:
        runs = {name: _run(sequence, remote, _frames(quick), progress) for name, sequence in SEQUENCES.items()}
        plots = {
            name: plot for key, run in runs.items() for name, plot in _plots(key, SEQUENCES[key], run, views).items()
        }
    finally:
        views.close()
    compared = {_title(name): commanded_figures(run.tracked, run.commanded) for name, run in runs.items()}
    return ExperimentReport(
        title="One camera commands a humanoid",
        text=TEXT,
        summary="\n".join(f"{name}: {_in_words(figures)}" for name, figures in compared.items()),
        figures={"experiment": "robonaut", "quick": quick, "runs": compared},
        compared=compared,
        plots=plots,
        data={name: _table(run) for name, run in runs.items()},
    )


def _frames(quick: bool) -> int:
    return QUICK_FRAMES if quick else HANDLING_FRAMES


def _title(name: str) -> str:
    return name.upper().replace("_", "-")


def _run(sequence: HandlingSequence, remote: RemoteConfig, frames: int, progress: Progress) -> SequenceRun:
    """Film the arm at rest, then its motion and a frame more; track all of it, and command the humanoid."""
    handling = sequence.handling
    numbers = [max(k - STILL_FRAMES, 0) for k in range(STILL_FRAMES + frames + 1)]
    shots = (Shot(handling.arm(k), handling.limb_poses(k)) for k in numbers)
    filmed = render_footage(grasping_film(sequence.scenery), shots, progress)
    tracked = track_footage(filmed, LIVE, CLICK_PX)
    moving = slice(STILL_FRAMES, -1)
    footage = Footage(filmed.pictures[moving], filmed.true_arms[moving])
    return SequenceRun(footage, tracked.cut(moving), command_humanoid(tracked, STILL_FRAMES, remote))


def _plots(name: str, sequence: HandlingSequence, run: SequenceRun, views: HumanoidViews) -> dict[str, bytes]:
    """The three figures of a sequence, by file name without extension."""
    frames, motion, humanoid = sequence.figures
    shown = frames_shown(sequence.shown, len(run.footage.pictures))
    return {
        f"figure_{frames}_{name}_frames": overlays_plate(run.footage, run.tracked, shown, LIVE),
        f"figure_{motion}_{name}_motion": motion_plot(
            run.tracked, f"{_title(name)}: motion from frame to frame (figure {motion})"
        ),
        f"figure_{humanoid}_{name}_humanoid": views.plate({k: run.commanded.postures[k - 1] for k in shown}),
    }


def _table(run: SequenceRun) -> CsvTable:
    return commanded_table(run.tracked, run.commanded)


def _in_words(figures: Figures) -> str:
    estimated, reached = figures["estimated_off_true_palm_mm"], figures["reached_off_commanded_palm_mm"]
    return (
        f"palm estimated {estimated['mean']} mm off the true one (p95 {estimated['p95']}, largest "
        f"{estimated['largest']}), reached {reached['mean']} mm off the commanded one (p95 {reached['p95']}, largest "
        f"{reached['largest']}), {figures['lost']} frames lost"
    )
