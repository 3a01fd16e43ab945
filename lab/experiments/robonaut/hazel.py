"""The experiment "hazel": the ROBONAUT report's synthetic arm and finger rectangle, tracked by one camera."""

import math
from collections.abc import Iterable, Mapping

import numpy as np
from msgspec.structs import asdict, replace

from lab.experiments.report import CsvTable, ExperimentReport, Figures, Progress
from lab.experiments.robonaut.errors import (
    MM,
    REPORT_C,
    REPORT_S,
    arm_figures,
    errors_mm,
    finger_figures,
    lengths,
    true_and_measured,
)
from lab.experiments.robonaut.figures.frames import frames_plate, frames_shown, overlays_plate
from lab.experiments.robonaut.figures.plots import error_plot, finger_plot, motion_plot, position_plot
from lab.experiments.robonaut.footage import (
    Footage,
    Shot,
    Tracked,
    bare,
    render_footage,
    track_footage,
    with_occluder,
)
from local_site.simulation.hazel import (
    HAZEL_C_FRAMES,
    HAZEL_S_FRAMES,
    JOINTS,
    Swing,
    TrueArm,
    hazel_film,
    pointing_arm,
    pointing_film,
)
from local_site.simulation.textured_arm import Scenery
from local_site.tracking.config import ForearmConfig, MonocularConfig, UpperArmConfig

QUICK_FRAMES = 40
HAZEL_C_SEED = 11
OCCLUDER_PX = (330, 250, 365, 285)  # left, top, right, bottom
OCCLUDED_FRAMES = range(20, 110)
OCCLUDER_LEVEL = 90  # grey
CLICK_PX = 1.0  # an operator clicks on whole pixels
SWINGS: Mapping[str, Swing] = {
    "turned by 149 deg in the picture": Swing(in_plane=math.radians(149.0)),
    "3 x speed": Swing(speed=3.0),
}
LIVE, ACCURATE = MonocularConfig(setting="live"), MonocularConfig(setting="accurate")
ALONG_THE_LIMB = ("length_mm", "palm_length_mm", "palm_point_mm")
TEXT = (
    "A textured arm swings in front of one camera, as in HAZEL-S of the report Teleoperating ROBONAUT (2002), and a "
    "finger follows a known rectangle, as in HAZEL-C. The tracker knows neither skin, light, background nor noise; it "
    "is given lengths, girths and the joints in the first picture, in HAZEL-C as clicks on whole pixels. The report's "
    "own figures are listed for comparison; they are of its own pictures, which are not available."
)
FRAMES_S, FRAMES_C = (1, 25, 75, 230, 320, 360), (1, 60, 120, 180, 300, 354)  # shown in the report's figures 9 and 13


def frame_count(quick: bool) -> int:
    """The number of frames that `hazel_report` renders, for a progress bar."""
    swings = 2 + len(SWINGS)  # the undisturbed swing, which most runs reuse, and the noisy one
    return QUICK_FRAMES * (swings + 1) if quick else HAZEL_S_FRAMES * swings + HAZEL_C_FRAMES


def hazel_report(quick: bool, progress: Progress) -> ExperimentReport:
    """Run the experiment, on few frames if `quick`; deterministic for one installation."""
    frames = QUICK_FRAMES if quick else HAZEL_S_FRAMES
    swing = _swing(Swing(), frames, Scenery(), progress)
    accurate, live = track_footage(swing, ACCURATE, 0.0), track_footage(swing, LIVE, 0.0)
    compared = {"report, HAZEL-S": REPORT_S, "accurate": arm_figures(accurate), "live": arm_figures(live)}
    for name, tracked in _disturbed_runs(swing, frames, progress):
        compared[f"live, {name}"] = arm_figures(tracked)
    finger = _pointing(QUICK_FRAMES if quick else HAZEL_C_FRAMES, progress)
    pointing = track_footage(finger, LIVE, CLICK_PX)
    compared |= {"report, HAZEL-C": REPORT_C, "rectangle, live": finger_figures(pointing)}
    return ExperimentReport(
        title="One camera, a maximum-likelihood arm",
        text=TEXT,
        summary="\n".join(f"{name}: {_means(figures)}" for name, figures in compared.items()),
        figures={"experiment": "hazel", "quick": quick, "runs": compared},
        compared=compared,
        plots=_swing_plots(swing, accurate) | _finger_plots(finger, pointing),
        data={
            "hazel_s_accurate": _joint_table(accurate),
            "hazel_s_live": _joint_table(live),
            "hazel_c": _tip_table(pointing),
        },
    )


def _scale_girths(config: MonocularConfig, factor: float) -> MonocularConfig:
    """Multiply all girths, and the palm's width and thickness, by a factor; lengths along the limb stay."""

    def scaled(part: UpperArmConfig | ForearmConfig) -> dict[str, float]:
        return {name: mm if name in ALONG_THE_LIMB else factor * mm for name, mm in asdict(part).items()}

    upper_arm, forearm = UpperArmConfig(**scaled(config.upper_arm)), ForearmConfig(**scaled(config.forearm))
    return replace(config, upper_arm=upper_arm, forearm=forearm)


def _means(figures: Figures) -> str:
    """The mean of every error in mm, as one line."""
    spreads_mm = {name: value for name, value in figures.items() if name.endswith("_mm") and isinstance(value, dict)}
    means = (f"{name.removesuffix('_mm')} {value['mean']} mm" for name, value in spreads_mm.items() if value)
    return ", ".join(means)


def _disturbed_runs(swing: Footage, frames: int, progress: Progress) -> Iterable[tuple[str, Tracked]]:
    """Track the swing with wrong girths, and swings with noise, turned, faster, and behind a small occluder."""
    yield "radius - 5 %", track_footage(swing, _scale_girths(LIVE, 0.95), 0.0)
    yield "radius + 5 %", track_footage(swing, _scale_girths(LIVE, 1.05), 0.0)
    yield "grey noise 6", track_footage(_swing(Swing(), frames, Scenery(noise=6.0), progress), LIVE, 0.0)
    for name, other in SWINGS.items():
        yield name, track_footage(_swing(other, frames, Scenery(), progress), LIVE, 0.0)
    yield "small occluder", track_footage(with_occluder(swing, OCCLUDER_PX, OCCLUDED_FRAMES, OCCLUDER_LEVEL), LIVE, 0.0)


def _swing(swing: Swing, frames: int, scenery: Scenery, progress: Progress) -> Footage:
    """Render the arm of HAZEL-S."""
    return render_footage(hazel_film(scenery), (bare(swing.arm(k)) for k in range(frames)), progress)


def _pointing(frames: int, progress: Progress) -> Footage:
    """Render the arm of HAZEL-C."""
    scenery = Scenery(noise=3.0, light=(0.6, -0.5, -0.6), ambient=0.5, seed=HAZEL_C_SEED)
    return render_footage(pointing_film(scenery), (_with_finger(pointing_arm(k)) for k in range(frames)), progress)


def _with_finger(arm: TrueArm) -> Shot:
    """The stretched finger moves rigidly with the forearm."""
    upper_arm, forearm = arm.limb_poses()
    return Shot(arm, (upper_arm, forearm, forearm))


def _joint_table(tracked: Tracked) -> CsvTable:
    columns = tuple(f"{name}_{axis}_error_mm" for name in JOINTS for axis in "xyz")
    rows = np.hstack([errors_mm(tracked, name) for name in JOINTS])
    return CsvTable(("frame", *columns), np.column_stack([np.arange(len(rows)), rows]))


def _tip_table(tracked: Tracked) -> CsvTable:
    rows = [MM * p for p in true_and_measured(tracked, "finger_tip")]
    columns = tuple(f"{what}_{axis}_mm" for what in ("true", "measured") for axis in "xyz")
    return CsvTable(("frame", *columns), np.column_stack([np.arange(len(rows[0])), *rows]))


def _swing_plots(footage: Footage, tracked: Tracked) -> dict[str, bytes]:
    """The report's figures 9 to 12, by file name without extension."""
    errors = {name: lengths(errors_mm(tracked, name)) for name in JOINTS}
    return {
        "figure_9_hazel_s_frames": frames_plate(footage, frames_shown(FRAMES_S, len(footage.pictures))),
        "figure_10_motion": motion_plot(tracked, "Motion from frame to frame (figure 10)"),
        "figure_11_positions": position_plot(tracked),
        "figure_12_errors": error_plot("Position errors (figure 12)", errors),
    }


def _finger_plots(footage: Footage, tracked: Tracked) -> dict[str, bytes]:
    """The report's figures 13 to 16, by file name without extension."""
    off_mm = errors_mm(tracked, "finger_tip")
    distances = {f"along {axis}": np.abs(off_mm[:, k]) for k, axis in enumerate("xyz")} | {"distance": lengths(off_mm)}
    shown = frames_shown(FRAMES_C, len(footage.pictures))
    return {
        "figure_13_hazel_c_frames": overlays_plate(footage, tracked, shown, LIVE),
        "figure_14_hazel_c_motion": motion_plot(tracked, "HAZEL-C: motion from frame to frame (figure 14)"),
        "figure_15_finger_tip": finger_plot(tracked),
        "figure_16_finger_errors": error_plot("Errors of the finger tip (figure 16)", distances),
    }
