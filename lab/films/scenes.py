"""Scenes to measure trackers on: the simulated operator's motions and bodies, and recordings of an arm with truth."""

import json
from collections.abc import Callable, Iterator
from contextlib import closing
from dataclasses import dataclass
from itertools import zip_longest
from pathlib import Path

import numpy as np

from common.cameras.camera import Frame
from common.cameras.sources import open_camera
from common.clock import NS_PER_S
from common.errors import CameraError
from farhand.tracking.recorded_pairs import RecordedPairs
from local_site.calibration.control_points import read_control_points
from local_site.calibration.rig import Rig
from local_site.calibration.solve import solve_rig
from local_site.simulation.body import ArmTruth
from local_site.simulation.cameras import exact_rig
from local_site.simulation.config import (
    BodyConfig,
    MotionConfig,
    MotionName,
    PictureConfig,
    SimulationConfig,
    StereoConfig,
)
from local_site.simulation.operator import SimulatedOperator
from local_site.tracking.tracker import View, Views

RECORDINGS = Path(__file__).resolve().parents[2] / "../shared/data/recordings"
ANY_BARE_ARM: tuple[str, ...] = ("silhouette", "learned")
STILL_S = 0.5
SECONDS: dict[MotionName, float] = {
    "hold": 1.0,
    "figure_of_eight": 6.5,
    "rotate_x": 6.0,
    "rotate_y": 6.0,
    "rotate_z": 6.0,
    "pick_and_place": 13.5,
    "reach_and_adjust": 10.0,
    "toggles": 6.5,
}
THIN = BodyConfig(forearm_girth=0.20, upper_arm_girth=0.22, elbow_girth=0.20, wrist_girth=0.14, belly_offset=0.004)
STRONG = BodyConfig(forearm_girth=0.32, upper_arm_girth=0.36, elbow_girth=0.28, wrist_girth=0.185, belly_offset=0.018)
CLOSE = StereoConfig(focal_px=950.0)
FAR = StereoConfig(focal_px=460.0)
BLURRED = PictureConfig(shutter_ms=15.0)


@dataclass(frozen=True, slots=True)
class Instant:
    """One pair of pictures and what is to be found in it; None while the arm is not there."""

    views: Views
    truth: ArmTruth | None


@dataclass(frozen=True, slots=True)
class TrackingScene:
    """A run of instants before a calibrated rig, for trackers of these methods; `instants` starts again each time."""

    name: str
    rig: Rig
    instants: Callable[[], Iterator[Instant]]
    methods: tuple[str, ...] = ("silhouette",)


def simulated_scenes() -> list[TrackingScene]:
    """Every motion of an average arm, and other arms before closer, farther and slower cameras."""
    average = [simulated(name, SimulationConfig(motion=_motion(name)), seconds) for name, seconds in SECONDS.items()]
    carry: MotionName = "pick_and_place"
    thin = SimulationConfig(body=THIN, stereo=CLOSE, motion=_motion(carry))
    strong = SimulationConfig(body=STRONG, stereo=FAR, picture=BLURRED, motion=_motion(carry))
    return [
        *average,
        simulated(f"{carry}, thin arm, 1.6 mm per px", thin, SECONDS[carry]),
        simulated(f"{carry}, strong arm, 3.3 mm per px, blurred", strong, SECONDS[carry]),
    ]


def simulated(name: str, config: SimulationConfig, seconds: float) -> TrackingScene:
    """The simulated operator for `seconds`, as exactly calibrated cameras see him."""

    def instants() -> Iterator[Instant]:
        operator = SimulatedOperator(config)
        for k in range(round(seconds * config.fps)):
            t_s = k / config.fps
            t_ns = round(t_s * NS_PER_S)
            views = Views(t_ns, tuple(View(Frame(image, t_ns, k)) for image in operator.render(t_s)))
            yield Instant(views, operator.truth(t_s))

    return TrackingScene(f"simulated {name}", exact_rig(config.stereo), instants)


def _motion(name: MotionName) -> MotionConfig:
    return MotionConfig(name=name, still_s=STILL_S)


def recorded_scenes(folder: Path) -> list[TrackingScene]:
    """The recordings of a folder, each calibrated from its own control points."""
    return [recorded(points.parent) for points in sorted(folder.glob("*/control_points.csv"))]


def recorded(folder: Path) -> TrackingScene:
    """A recording: left.avi, right.avi, control_points.csv and truth.jsonl; CameraError when pairs and truth differ."""
    rig = solve_rig(read_control_points(folder / "control_points.csv"), created="for measuring")
    truths = []  # m in the operator frame
    for line in (folder / "truth.jsonl").read_bytes().splitlines():
        truth = json.loads(line)
        elbow, wrist, index, thumb = (np.array(truth[name]) for name in ("elbow", "wrist", "index", "thumb"))
        truths.append(ArmTruth(elbow, wrist, index, thumb, truth["hand_open"]))

    def instants() -> Iterator[Instant]:
        with (
            closing(open_camera(str(folder / "left.avi"), "left")) as left,
            closing(open_camera(str(folder / "right.avi"), "right")) as right,
        ):
            for views, truth in zip_longest(RecordedPairs(left, right), truths):
                if views is None or truth is None:
                    raise CameraError(f"{folder} does not have as many pairs as its {len(truths)} lines of truth")
                yield Instant(views, truth)

    return TrackingScene(folder.name, rig, instants, ANY_BARE_ARM)
