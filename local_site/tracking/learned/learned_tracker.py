"""The tracker for ordinary rooms: hand landmarks in two or more views, sharpened by the arm's outlines."""

import math

import numpy as np

from common.errors import CalibrationError
from common.geometry import Array
from common.messages.hand import TrackingStatus
from local_site.calibration.rig import Rig
from local_site.calibration.triangulation import focal_length
from local_site.tracking.config import LearnedConfig
from local_site.tracking.learned.arm_length import ArmLength
from local_site.tracking.learned.arm_outlines import ArmOutlines
from local_site.tracking.learned.followed_hand import FittedHand, FollowedHand
from local_site.tracking.landmarks.hand_finder import HandFinder
from local_site.tracking.landmarks.hand_pairing import SeenHand
from local_site.tracking.landmarks.models import view_hands
from local_site.tracking.landmarks.side_evidence import SideEvidence
from local_site.tracking.silhouette.arm_finder import NoArm, SeenArm
from local_site.tracking.silhouette.hand_model.fit import MAX_VIEWS, NO_VIEW, HandView
from local_site.tracking.silhouette.joints import elbow_covariance
from local_site.tracking.silhouette.operator_profile import OperatorProfile
from local_site.tracking.silhouette.quality import doubts
from local_site.tracking.tracker import ArmEstimate, Overlay, TrackingReason, Views

# Of the crop's side: what landmarks miss by in one picture, more where the view may have seen the hand's mirror image.
LANDMARK_SIGMA, DOUBTFUL_SIGMA = 0.04, 0.06
SURE_SIDE, DOUBTFUL_SIDE = 0.8, 0.5


class LearnedTracker:
    """Tracks a bare arm before any background.

    The landmarks give the hand, its side and a start; the outlines of hand and arm sharpen it where they agree with
    them. Raises CalibrationError for a rig of more than four cameras, ModelError without the models.
    """

    def __init__(
        self, rig: Rig, config: LearnedConfig | None = None, profile: OperatorProfile | None = None
    ) -> None:
        """`profile` is what an earlier run has learned of the operator."""
        if len(rig.cameras) > MAX_VIEWS:
            raise CalibrationError(f"the tracker takes {MAX_VIEWS} cameras at most, the rig has {len(rig.cameras)}")
        self._rig, self._config = rig, config or LearnedConfig()
        self._finder = HandFinder(rig, view_hands(rig, self._config.right_arm))
        self._outlines = ArmOutlines(rig)
        self._side = SideEvidence()
        self._length = ArmLength(self._config.initial_pairs)
        self._hand = FollowedHand(self._config.right_arm)

    @property
    def profile(self) -> OperatorProfile | None:
        """What has been learned of the operator in all runs, None until this one has learned the arm and the hand."""
        return None

    def track(self, views: Views) -> ArmEstimate:
        """The arm at the views' instant; a frame that cannot be tracked gives the reason."""
        if len(views.views) != len(self._rig.cameras) or len(views.views) < 2:
            return self._lost(views.t_ns, f"{len(views.views)} views for {len(self._rig.cameras)} calibrated cameras")
        seen = self._finder.find(views, self._is_operators)
        if isinstance(seen, str):
            return self._lost(views.t_ns, seen)
        self._side.add(seen.right)
        if not self._side.supports(self._config.right_arm):
            self._finder.forget()
            self._side.forget()
            return self._lost(views.t_ns, TrackingReason.OTHER_SIDE, seen.residual_px)
        arm = self._outlines.find(views, self._length.body, seen, starting=not self._length.is_known)
        hand = self._fit(seen, arm)
        if hand is None:
            return self._lost(views.t_ns, TrackingReason.HAND_UNCLEAR, seen.residual_px)
        return self._found(views.t_ns, seen, arm, hand)

    def _is_operators(self, seen: SeenHand) -> bool:
        return True

    def _fit(self, seen: SeenHand, arm: SeenArm | NoArm) -> FittedHand | None:
        finder = self._outlines.finder
        outlines = finder.hand_views(arm) if isinstance(arm, SeenArm) else {}
        views = [
            self._with_landmarks(outlines.get(k), matrix, seen, k)
            for k, matrix in enumerate(self._rig.matrices)
            if k in outlines or k in seen.views
        ]
        return self._hand.track(views, seen.points, finder.evidence(arm) if isinstance(arm, SeenArm) else None)

    def _found(self, t_ns: int, seen: SeenHand, arm: SeenArm | NoArm, hand: FittedHand) -> ArmEstimate:
        wrist = hand.fit.pose.wrist
        points = {"wrist": wrist, "index": hand.index.point, "thumb": hand.thumb.point}
        covariances = {
            "wrist": hand.wrist_covariance, "index": hand.index.covariance, "thumb": hand.thumb.covariance
        }
        status, reason = self._judge(arm, hand)
        if isinstance(arm, SeenArm):
            self._outlines.finder.keep(arm, wrist)
            points["elbow"], covariances["elbow"] = arm.joints.elbow, elbow_covariance(arm.joints, arm.limbs)
        return ArmEstimate(t_ns, status, reason, **points, thumb_inferred=False, hand_open=hand.hand_open, covariances=covariances, residual_px=seen.residual_px)

    def _judge(self, arm: SeenArm | NoArm, hand: FittedHand) -> tuple[TrackingStatus, str]:
        if isinstance(arm, SeenArm) and not self._length.is_known:
            reasons = doubts(self._rig, arm.limbs, arm.features, arm.joints)
            if not reasons:
                sleeve, elbow = self._outlines.finder.sleeve(arm), arm.joints.elbow
                to_sleeve_m = math.nan if sleeve is None else float(np.linalg.norm(sleeve - elbow))
                self._length.add(float(np.linalg.norm(hand.fit.pose.wrist - elbow)), to_sleeve_m)
        if not self._length.is_known:
            return TrackingStatus.INITIALISING, f"{TrackingReason.LEARNING} ({self._length.seen} of {self._length.needed} pairs)"
        return TrackingStatus.TRACKED, ""

    def _lost(self, t_ns: int, reason: str, residual_px: float | None = None) -> ArmEstimate:
        self._hand.forget()
        self._outlines.forget()
        return ArmEstimate(t_ns, TrackingStatus.LOST, reason, residual_px=residual_px)

    def _with_landmarks(self, outline: HandView | None, matrix: Array, seen: SeenHand, k: int) -> HandView:
        view = outline or NO_VIEW._replace(projection=matrix, focal_px=focal_length(matrix))
        if k not in seen.views:
            return view
        hand = seen.views[k]
        side = hand.right if self._config.right_arm else 1.0 - hand.right
        if side < DOUBTFUL_SIDE:
            return view
        sigma = LANDMARK_SIGMA if side > SURE_SIDE else DOUBTFUL_SIGMA
        return view._replace(landmarks=seen.pixels[k], landmark_sigma=sigma * hand.crop.side_px)
