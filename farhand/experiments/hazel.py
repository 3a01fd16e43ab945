"""The experiment "hazel": the ROBONAUT report's synthetic arm and finger rectangle, tracked by one camera."""

import math
from collections.abc import Iterable, Mapping
from typing import TYPE_CHECKING

import numpy as np
from msgspec.structs import asdict, replace

from common.geometry import Array
from farhand.experiments.hazel_figures import (
    MM,
    REPORT_C,
    REPORT_S,
    Footage,
    Tracked,
    arm_figures,
    errors_mm,
    finger_figures,
    lengths,
    motions,
    render_footage,
    track_footage,
    true_and_measured,
    with_occluder,
)
from farhand.experiments.report import CsvTable, ExperimentReport, Figures, Progress
from farhand.reports.plotting import MEASURED, TRUE, describe_panel, panels, png, widen
from local_site.simulation.hazel import (
    HAZEL_C_FRAMES,
    HAZEL_S_FRAMES,
    JOINTS,
    Swing,
    hazel_film,
    pointing_arm,
    pointing_film,
)
from local_site.simulation.textured_arm import Scenery
from local_site.tracking.config import ForearmConfig, MonocularConfig, UpperArmConfig

if TYPE_CHECKING:
    from matplotlib.axes import Axes

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
FIRST_FRAMES = 100
MIN_SPAN_MM, MIN_SPAN_DEG, MIN_SPAN_TIP_MM = 1.0, 1.0, 10.0
MOTIONS = (("shoulder moves", "along", "mm"), ("upper arm turns", "about", "deg"), ("forearm turns", "about", "deg"))
ERROR, MEAN = {**MEASURED, "label": "error"}, {"label": "mean", "color": "#6e6e6e", "linestyle": "--", "linewidth": 0.9}


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
    pointing = _pointing(QUICK_FRAMES if quick else HAZEL_C_FRAMES, progress)
    compared |= {"report, HAZEL-C": REPORT_C, "rectangle, live": finger_figures(pointing)}
    return ExperimentReport(
        title="One camera, a maximum-likelihood arm",
        text=TEXT,
        summary="\n".join(f"{name}: {_means(figures)}" for name, figures in compared.items()),
        figures={"experiment": "hazel", "quick": quick, "runs": compared},
        compared=compared,
        plots=hazel_plots(accurate, pointing),
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
    return render_footage(hazel_film(scenery), map(swing.arm, range(frames)), False, progress)


def _pointing(frames: int, progress: Progress) -> Tracked:
    """Render and track the arm of HAZEL-C."""
    scenery = Scenery(noise=3.0, light=(0.6, -0.5, -0.6), ambient=0.5, seed=HAZEL_C_SEED)
    footage = render_footage(pointing_film(scenery), map(pointing_arm, range(frames)), True, progress)
    return track_footage(footage, LIVE, CLICK_PX)


def _joint_table(tracked: Tracked) -> CsvTable:
    columns = tuple(f"{name}_{axis}_error_mm" for name in JOINTS for axis in "xyz")
    rows = np.hstack([errors_mm(tracked, name) for name in JOINTS])
    return CsvTable(("frame", *columns), np.column_stack([np.arange(len(rows)), rows]))


def _tip_table(tracked: Tracked) -> CsvTable:
    rows = [MM * p for p in true_and_measured(tracked, "finger_tip")]
    columns = tuple(f"{what}_{axis}_mm" for what in ("true", "measured") for axis in "xyz")
    return CsvTable(("frame", *columns), np.column_stack([np.arange(len(rows[0])), *rows]))


def hazel_plots(swing: Tracked, pointing: Tracked) -> Mapping[str, bytes]:
    """The plots of HAZEL-S (`swing`) and HAZEL-C (`pointing`) as PNG, by file name without extension.

    They correspond to figures 10, 11, 12, 15 and 16 of the report, in the camera's frame.
    """
    tip_errors = errors_mm(pointing, "finger_tip")
    tip_distances = {f"along {axis}": np.abs(tip_errors[:, k]) for k, axis in enumerate("xyz")}
    tip_distances["distance"] = lengths(tip_errors)
    return {
        "figure_10_motion": _motion_plot(swing),
        "figure_11_positions": _position_plot(swing),
        "figure_12_errors": _error_plot(
            "Position errors (figure 12)", {name: lengths(errors_mm(swing, name)) for name in JOINTS}
        ),
        "figure_15_finger_tip": _finger_plot(pointing),
        "figure_16_finger_errors": _error_plot("Errors of the finger tip (figure 16)", tip_distances),
    }


def _motion_plot(tracked: Tracked) -> bytes:
    true, measured = motions(tracked)
    figure, axes = panels("Motion from frame to frame (figure 10)", 3, 3, sharex=True)
    for k, panel in enumerate(axes.flat):
        what, preposition, unit = MOTIONS[k // 3]
        _compare(panel, true[:, k], measured[:, k], MIN_SPAN_MM if unit == "mm" else MIN_SPAN_DEG)
        describe_panel(panel, f"{what} {preposition} {'xyz'[k % 3]}", f"{unit} per frame")
    return png(figure, axes, "frame")


def _position_plot(tracked: Tracked) -> bytes:
    figure, axes = panels(f"Positions in the first {FIRST_FRAMES} frames (figure 11)", 3, 3, sharex=True)
    for name, row in zip(JOINTS, axes, strict=True):
        true, measured = (MM * p[:FIRST_FRAMES] for p in true_and_measured(tracked, name))
        for k, panel in enumerate(row):
            _compare(panel, true[:, k], measured[:, k], MIN_SPAN_MM)
            describe_panel(panel, f"{name}, {'xyz'[k]}", "mm")
    return png(figure, axes, "frame")


def _finger_plot(tracked: Tracked) -> bytes:
    true, measured = (MM * p for p in true_and_measured(tracked, "finger_tip"))
    figure, axes = panels("The finger tip on its rectangle (figure 15)", 2, sharex=True)
    for panel, k, title in zip(axes.flat, (1, 2), ("seen by the camera", "seen from above"), strict=True):
        panel.plot(true[:, 0], true[:, k], **TRUE)
        panel.plot(measured[:, 0], measured[:, k], **MEASURED)
        describe_panel(panel, title, f"{'xyz'[k]}, mm")
        widen(panel, MIN_SPAN_TIP_MM)
    axes[0, 0].invert_yaxis()  # the camera's y points down
    return png(figure, axes, "x, mm")


def _error_plot(title: str, errors: Mapping[str, Array]) -> bytes:
    figure, axes = panels(title, len(errors), sharex=True, sharey=True)
    for panel, (name, values) in zip(axes.flat, errors.items(), strict=True):
        mean = float(np.nanmean(values))
        panel.plot(values, **ERROR)
        panel.axhline(mean, **MEAN)
        describe_panel(panel, f"{name}: mean {mean:.2f} mm, largest {float(np.nanmax(values)):.2f} mm", "error, mm")
    axes[0, 0].set_ylim(0.0, max(axes[0, 0].get_ylim()[1], MIN_SPAN_MM))
    return png(figure, axes, "frame")


def _compare(panel: "Axes", true: Array, measured: Array, min_span: float) -> None:
    panel.plot(true, **TRUE)
    panel.plot(measured, **MEASURED)
    widen(panel, min_span)
