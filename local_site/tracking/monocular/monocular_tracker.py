"""The monocular tracker: one camera's pictures to elbow, wrist and palm (the ROBONAUT report of 2002)."""

import cv2
import numpy as np

from common.cameras.camera import Image
from common.errors import CalibrationError
from common.geometry import Array
from common.messages.hand import TrackingStatus
from local_site.calibration.physical_camera import decomposed
from local_site.calibration.rig import Rig
from local_site.calibration.undistortion import Undistorter
from local_site.kernels.pictures import as_grey
from local_site.tracking.config import MonocularConfig, Pixel
from local_site.tracking.monocular.arm_model import MM, ArmPose
from local_site.tracking.monocular.estimator import (
    EstimatorState,
    Judgement,
    MotionFit,
    Refusal,
    covariances,
    judged,
)
from local_site.tracking.monocular.frame_tracker import ArmFrameTracker
from local_site.tracking.monocular.start import SilhouetteStart, starting_pose
from local_site.tracking.tracker import ArmEstimate, Overlay, View, Views

NOT_GIVEN = (
    "the joints in the first picture are not given: click them, set tracking.monocular.start, or --joints; "
    "or --joints silhouette for a bare arm before a dark background"
)
LOST_LONG = 30
NO_TIPS = "index and thumb are not measured by this tracker"


class MonocularTracker:
    """Tracks a textured arm from a known pose in the first picture, frame by frame.

    `camera` is the number of its camera in the rig; `pose` is the last estimate in that camera's frame, None while the
    arm is lost. After a loss it searches alternately at the last pose and at the start; nothing is extrapolated. With a
    start by silhouette it also restarts after LOST_LONG lost pictures.
    Raises CalibrationError if the rig has no such camera.
    """

    def __init__(self, rig: Rig, config: MonocularConfig | None = None) -> None:
        self._config = config or MonocularConfig()
        if self._config.camera >= len(rig.cameras):
            raise CalibrationError(f"there is no camera {self._config.camera}: the rig has {len(rig.cameras)}, from 0")
        self.camera, self._cameras = self._config.camera, len(rig.cameras)
        self._calibrated = rig.cameras[self.camera]
        self._undistorter = Undistorter(self._calibrated.lens, cv2.BORDER_CONSTANT)
        camera = decomposed(self._calibrated.matrix)
        if camera is None:
            raise CalibrationError("the camera's projection is mirrored; calibrate again")
        self._camera = camera
        start = self._config.start
        given = np.array([start.shoulder_px, start.elbow_px, start.wrist_px])
        self._by_silhouette: SilhouetteStart | None = None
        if start.by == "silhouette":
            self._by_silhouette = SilhouetteStart(self._calibrated, camera.lens, self._config)
        self._joints_px: Array | None = given if start.is_given else None
        self._forget()

    def start_at(self, shoulder_px: Pixel, elbow_px: Pixel, wrist_px: Pixel) -> None:
        """Restart from the joints in the camera's next picture, px of its own; everything learned is discarded."""
        self._joints_px, self._by_silhouette = np.array([shoulder_px, elbow_px, wrist_px]), None
        self._forget()

    def _forget(self) -> None:
        self._tracker = ArmFrameTracker(self._camera.lens, self._config)
        self._start: EstimatorState | None = None
        self._lost_for = 0
        self.pose: ArmPose | None = None

    def track(self, views: Views) -> ArmEstimate:
        """The arm at the views' instant; a frame that cannot be tracked gives the reason."""
        if len(views.views) != self._cameras:
            return self._lost(views.t_ns, f"{len(views.views)} views for {self._cameras} calibrated cameras")
        view = views.views[self.camera]
        image = self._undistorter.undistorted(as_grey(view.current.image))
        if self._start is None or (self._by_silhouette is not None and self._lost_for >= LOST_LONG):
            problem = self._begin(view, image, views.t_ns)
            if problem and self._start is None:
                return self._lost(views.t_ns, problem)
        fit = self._fit(image)
        judgement = judged(fit)
        if fit is None or judgement.spread is None:
            self._lost_for += 1
            return self._lost(views.t_ns, judgement.reason)
        if judgement.status is TrackingStatus.TRACKED:
            self._tracker.keep(image, fit)
        else:
            self._tracker.move_to(fit.state)
        self._lost_for = 0
        return self._found(views.t_ns, fit.state.pose, judgement, judgement.spread)

    def _begin(self, view: View, image: Image, t_ns: int) -> str:
        """Start in this picture; the reason if it cannot, or an empty string."""
        if self._by_silhouette is not None:
            return self._begin_by(self._by_silhouette, view, image, t_ns)
        if self._joints_px is None:
            return NOT_GIVEN
        pose = starting_pose(self._camera.lens, self._config, self._calibrated.undistort_pixels(self._joints_px))
        if isinstance(pose, str):
            return pose
        if not self._tracker.begin(image, pose):
            return Refusal.OUT_OF_VIEW
        self._start = self._tracker.last
        return ""

    def _begin_by(self, silhouette: SilhouetteStart, view: View, image: Image, t_ns: int) -> str:
        """Start from the silhouette's pose, if the estimator accepts it; otherwise the reason."""
        pose = silhouette.pose(view, t_ns)
        if isinstance(pose, str):
            return pose
        tracker = ArmFrameTracker(self._camera.lens, self._config)
        begun = tracker.begin(image, pose)
        state = tracker.last
        judgement = judged(tracker.fit(image, state) if begun and state is not None else None)
        if judgement.spread is None:
            return silhouette.refuse(judgement.reason)
        self._tracker, self._start, self._lost_for = tracker, state, 0
        return ""

    def _fit(self, image: Image) -> MotionFit | None:
        """Fit from the predicted state; after a loss alternately from the last state and from the start."""
        if self._lost_for and self._start is not None and self._tracker.last is not None:
            self._tracker.rest_at(self._tracker.last)
            tried = self._start if self._lost_for % 2 else self._tracker.last
            return self._tracker.fit(image, tried)
        expected = self._tracker.expected()
        return None if expected is None else self._tracker.fit(image, expected)

    def _lost(self, t_ns: int, reason: str) -> ArmEstimate:
        self.pose = None
        return ArmEstimate(t_ns, TrackingStatus.LOST, reason, overlays=(Overlay(),) * self._cameras)

    def _found(self, t_ns: int, pose: ArmPose, judgement: Judgement, spread: Array) -> ArmEstimate:
        forearm = self._config.forearm
        wrist = np.array([0.0, 0.0, MM * forearm.length_mm])
        palm = wrist + np.array([0.0, 0.0, MM * forearm.palm_point_mm])
        turn = self._camera.camera_R_operator
        self.pose = pose
        in_camera = covariances(pose, spread, {"wrist": wrist, "palm": palm})
        joints = (pose.shoulder, pose.elbow, pose.on_forearm(wrist))
        shoulder_px, elbow_px, wrist_px = self._calibrated.distort_pixels(
            np.array([self._camera.lens.matrix @ p / p[2] for p in joints])[:, :2]
        )
        upper, lower = np.array([shoulder_px, elbow_px]), np.array([elbow_px, wrist_px])
        overlays = [Overlay()] * self._cameras
        overlays[self.camera] = Overlay(forearm_line=lower, upper_arm_line=upper, elbow=elbow_px, wrist=wrist_px)
        return ArmEstimate(
            t_ns,
            judgement.status,
            "; ".join(filter(None, (judgement.reason, NO_TIPS))),
            elbow=self._in_operator(pose.elbow),
            wrist=self._in_operator(pose.on_forearm(wrist)),
            palm=self._in_operator(pose.on_forearm(palm)),
            covariances={name: turn.T @ matrix @ turn for name, matrix in in_camera.items()},
            overlays=tuple(overlays),
        )

    def _in_operator(self, in_camera: Array) -> Array:
        point: Array = self._camera.camera_R_operator.T @ (in_camera - self._camera.translation)
        return point
