"""The pose in the first picture, both links parallel to it (section 2.6): from given joints, or from the silhouette."""

import math

import numpy as np

from common.clock import NS_PER_S
from common.geometry import Array
from local_site.calibration.physical_camera import Lens
from local_site.calibration.rig import CameraCalibration
from local_site.tracking.config import MonocularConfig
from local_site.tracking.features.features import Features
from local_site.tracking.features.view_meter import ViewMeter
from local_site.tracking.foreground.dark_wall import DarkWall
from local_site.tracking.monocular.arm_model import MM, ArmPose, facing
from local_site.tracking.monocular.outline_fit import OutlineFit, OutlineFitter
from local_site.tracking.tracker import TrackingReason, View

MOST_UNEQUAL = 1.15


def starting_pose(lens: Lens, config: MonocularConfig, pixels: Array) -> ArmPose | str:
    """The pose for shoulder, elbow and wrist at pixels (3, 2) of a pinhole's picture, or a sentence why there is none.

    Each link's length gives a depth; the two have to agree, and their mean weighted by length is used.
    """
    slopes = (pixels - (lens.cx, lens.cy)) / (lens.fx, lens.fy)
    lengths = MM * np.array([config.upper_arm.length_mm, config.forearm.length_mm])
    seen = np.linalg.norm(np.diff(slopes, axis=0), axis=1)
    depths = lengths / seen
    if max(depths) > MOST_UNEQUAL * min(depths):
        seen_at = ", ".join(f"{depth:.2f} m" for depth in depths)
        return f"the links differ in distance in the first picture ({seen_at}): hold both parallel to the picture"
    joints = np.column_stack([slopes, np.ones(3)]) * float(lengths.sum() / seen.sum())
    upper_arm = facing(joints[1] - joints[0], 0.0)
    forearm = facing(joints[2] - joints[1], math.radians(config.start.palm_turn_deg))
    return ArmPose(joints[0], upper_arm, forearm, float(lengths[0]))


TRY_EVERY_NS = NS_PER_S
MAX_SIGMA_M = 0.032
# The fit without the prior that the links are nearly parallel to the picture must not be far from the one with it.
MAX_TILT, MAX_MOVE_M = math.radians(15.0), 0.025
# An arm's outline fits to a third of a pixel; other shapes and postures have residuals beyond this.
MAX_RMS_PX, MAX_RMS = 0.4, 0.022  # the larger of the two is allowed; the second is a fraction of half the arm's width
MIN_POINTS = 12


class SilhouetteStart:
    """Proposes the pose in a camera's picture from the bare arm's silhouette, at most once a second."""

    def __init__(self, camera: CameraCalibration, lens: Lens, config: MonocularConfig) -> None:
        """`lens` is the pinhole's to which the camera's frames are undistorted."""
        self._meter = ViewMeter(camera, DarkWall())
        self._fitter = OutlineFitter(lens, config)
        self._due_ns = 0
        self._problem = ""

    def pose(self, view: View, t_ns: int) -> ArmPose | str:
        """The pose in this picture, or a sentence why there is none; between attempts the last sentence again."""
        if t_ns < self._due_ns:
            return self._problem
        self._due_ns = t_ns + TRY_EVERY_NS
        self._meter.forget()
        features = self._meter.features(View(view.current), None)
        if isinstance(features, str):
            return self.refuse(features)
        if features.upper_arm is None:
            return self.refuse(TrackingReason.NO_UPPER_ARM)
        fit = self._fitter.fit(features)
        problem = problem_of(fit, features)
        return self.refuse(problem) if problem else fit.pose

    def refuse(self, reason: str) -> str:
        """The reason against the picture tried last, reported until the next attempt."""
        self._problem = f"no arm to start from yet: {reason}"
        return self._problem


def problem_of(fit: OutlineFit, features: Features) -> str:
    """Say why a pose is not a valid start, in a sentence with its cure; empty if it is."""
    if min(fit.points) < MIN_POINTS:
        return "too little of the arm's outline is visible to start: bring upper arm, forearm and hand into the picture"
    if fit.rms_px > max(MAX_RMS_PX, MAX_RMS * features.half_width):
        return (
            f"the silhouette is not that of an arm of these lengths and girths (off by {fit.rms_px:.1f} px): hold "
            "both links parallel to the picture, bare the arm, stretch the hand, thumb laid to it, or measure again"
        )
    if abs(fit.free_tilts).max() > MAX_TILT or fit.free_moves[1:].max() > MAX_MOVE_M:
        upper, lower = (abs(math.degrees(tilt)) for tilt in fit.free_tilts)
        return (
            f"the arm seems to be turned to or from the camera (upper arm by {upper:.0f} deg, forearm by {lower:.0f}): "
            "hold both links parallel to the picture"
        )
    if fit.sigmas[1:].max() > MAX_SIGMA_M:
        return (
            f"the silhouette determines the arm's position only to {1e3 * fit.sigmas[1:].max():.0f} mm: come nearer, "
            "show more of the upper arm, or bend the elbow by about a right angle"
        )
    return ""
