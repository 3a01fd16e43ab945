"""The experiment "hazel": the ROBONAUT report's synthetic arm and finger rectangle, tracked by one camera."""

import math
from collections.abc import Iterable, Mapping

import msgspec
import numpy as np

from farhand.experiments.hazel_figures import (
    FINGER_REACH_M,
    JOINTS,
    MM,
    REPORT_C,
    REPORT_S,
    Figures,
    arm_figures,
    finger_figures,
    joint_errors,
)
from farhand.experiments.hazel_filming import Footage, Progress, Tracked, joints, occluded, shoot, watch
from farhand.experiments.hazel_plots import hazel_plots
from farhand.experiments.report import Data, ExperimentReport
from local_site.simulation.hazel import (
    HAZEL_C_FRAMES,
    HAZEL_S_FRAMES,
    Swing,
    TrueArm,
    hazel_film,
    pointing_arm,
    pointing_film,
)
from local_site.simulation.textured_arm import Scenery
from local_site.tracking.config import ForearmConfig, MonocularConfig, UpperArmConfig

QUICK_FRAMES = 40
SEED_C = 11
OCCLUDER_PX, OCCLUDED, OCCLUDER_LEVEL = (330, 250, 365, 285), range(20, 110), 90
CLICK_PX = 1.0
WAYS: Mapping[str, Swing] = {
    "turned by 149 deg in the picture": Swing(in_plane=math.radians(149.0)),
    "3 x speed": Swing(speed=3.0),
}
LIVE, ACCURATE = MonocularConfig(setting="live"), MonocularConfig(setting="accurate")
TEXT = (
    "A textured arm swings before one camera, as in HAZEL-S of the report Teleoperating ROBONAUT (2002), and a finger "
    "follows a known rectangle, as in HAZEL-C. Skin, light, background and noise are unknown to the tracker; lengths, "
    "girths and the joints in the first picture are given to it, in HAZEL-C as clicks on whole pixels. The report's "
    "figures stand beside; they are of its own pictures, which are not at hand."
)


def frames_of(quick: bool) -> int:
    """How many pictures are rendered, for a progress bar."""
    return sum(QUICK_FRAMES if quick else n for n in (*[HAZEL_S_FRAMES] * (2 + len(WAYS)), HAZEL_C_FRAMES))


def hazel_report(quick: bool, progress: Progress) -> ExperimentReport:
    """Run the experiment; always the same for the same installation."""
    frames = QUICK_FRAMES if quick else HAZEL_S_FRAMES
    swing = _swing(Swing(), frames, Scenery(), progress)
    accurate, live = watch(swing, ACCURATE, 0.0), watch(swing, LIVE, 0.0)
    compared = {"report, HAZEL-S": REPORT_S, "accurate": arm_figures(accurate), "live": arm_figures(live)}
    for name, tracked in _disturbed(swing, frames, progress):
        compared[f"live, {name}"] = arm_figures(tracked)
    pointing = _pointing(QUICK_FRAMES if quick else HAZEL_C_FRAMES, progress)
    compared |= {"report, HAZEL-C": REPORT_C, "rectangle, live": finger_figures(pointing)}
    return ExperimentReport(
        title="One camera, a maximum-likelihood arm",
        text=TEXT,
        figures={"experiment": "hazel", "quick": quick, "runs": compared},
        compared=compared,
        plots=hazel_plots(accurate, pointing),
        data={"hazel_s_accurate": _joint_data(accurate), "hazel_s_live": _joint_data(live), "hazel_c": _tip(pointing)},
    )


def describe(report: ExperimentReport) -> str:
    """The mean errors in words, a line for each run."""
    lines = []
    for name, figures in report.compared.items():
        means = [f"{k.removesuffix('_mm')} {v['mean']} mm" for k, v in figures.items() if k.endswith("_mm") and _has(v)]
        lines.append(f"{name}: {', '.join(means)}")
    return "\n".join(lines)


def resized(config: MonocularConfig, factor: float) -> MonocularConfig:
    """The configuration of an arm with all its girths wrong by a factor."""
    upper, forearm = config.upper_arm, config.forearm
    thick = ("palm_width_mm", "palm_thickness_mm")
    return msgspec.structs.replace(
        config,
        upper_arm=UpperArmConfig(
            length_mm=upper.length_mm,
            shoulder_girth_mm=factor * upper.shoulder_girth_mm,
            biceps_girth_mm=factor * upper.biceps_girth_mm,
            elbow_girth_mm=factor * upper.elbow_girth_mm,
        ),
        forearm=ForearmConfig(
            length_mm=forearm.length_mm,
            elbow_girth_mm=factor * forearm.elbow_girth_mm,
            belly_girth_mm=factor * forearm.belly_girth_mm,
            wrist_girth_mm=factor * forearm.wrist_girth_mm,
            **{name: factor * getattr(forearm, name) for name in thick},
        ),
    )


def _disturbed(swing: Footage, frames: int, progress: Progress) -> Iterable[tuple[str, Tracked]]:
    """The same arm with a wrong shape, with noise, turned, faster, and behind something small."""
    yield "radius - 5 %", watch(swing, resized(LIVE, 0.95), 0.0)
    yield "radius + 5 %", watch(swing, resized(LIVE, 1.05), 0.0)
    yield "grey noise 6", watch(_swing(Swing(), frames, Scenery(noise=6.0), progress), LIVE, 0.0)
    for name, way in WAYS.items():
        yield name, watch(_swing(way, frames, Scenery(), progress), LIVE, 0.0)
    yield "small occluder", watch(occluded(swing, OCCLUDER_PX, OCCLUDED, OCCLUDER_LEVEL), LIVE, 0.0)


def _swing(way: Swing, frames: int, scenery: Scenery, progress: Progress) -> Footage:
    return shoot(hazel_film(scenery), map(way.arm, range(frames)), False, progress)


def _pointing(frames: int, progress: Progress) -> Tracked:
    scenery = Scenery(noise=3.0, light=(0.6, -0.5, -0.6), ambient=0.5, seed=SEED_C)
    arms: Iterable[TrueArm] = map(pointing_arm, range(frames))
    return watch(shoot(pointing_film(scenery), arms, True, progress), LIVE, CLICK_PX)


def _joint_data(tracked: Tracked) -> Data:
    columns = tuple(f"{name}_{axis}_error_mm" for name in JOINTS for axis in "xyz")
    rows = np.hstack([joint_errors(tracked, name) for name in JOINTS])
    return Data(("frame", *columns), np.column_stack([np.arange(len(rows)), rows]))


def _tip(tracked: Tracked) -> Data:
    rows = [MM * joints(arms, "", FINGER_REACH_M) for arms in (tracked.arms, tracked.poses)]
    columns = tuple(f"{what}_{axis}_mm" for what in ("true", "measured") for axis in "xyz")
    return Data(("frame", *columns), np.column_stack([np.arange(len(rows[0])), *rows]))


def _has(figures: Figures | float) -> bool:
    return isinstance(figures, Mapping) and "mean" in figures
