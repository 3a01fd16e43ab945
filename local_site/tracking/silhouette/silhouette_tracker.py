"""The markerless tracker: silhouettes of a bare arm in two or more views to elbow, wrist, index and thumb."""

import math

import numpy as np

from common.errors import CalibrationError
from common.messages.hand import TrackingStatus
from local_site.calibration.rig import Rig
from local_site.tracking.config import SilhouetteConfig
from local_site.tracking.features.view_meter import ViewMeter
from local_site.tracking.foreground.dark_wall import DarkWall
from local_site.tracking.silhouette.arm_finder import ArmFinder, NoArm, SeenArm
from local_site.tracking.silhouette.hand_model.fit import MAX_VIEWS, MIN_VIEWS
from local_site.tracking.silhouette.hand_tracker import HandEstimate
from local_site.tracking.silhouette.joints import elbow_covariance, wrist_covariance
from local_site.tracking.silhouette.operator_profile import BodyLearning, OperatorProfile
from local_site.tracking.silhouette.quality import doubts
from local_site.tracking.tracker import ArmEstimate, TrackingReason, Views

DOUBTED_TANGENT_RESIDUAL = 0.12


class SilhouetteTracker:
    """Tracks an arm from its silhouettes (thesis chapter 3).

    Each view is measured on its own; only the search regions come from the last instants, so nothing is smoothed and a
    loss ends as soon as two views show the arm again. The body's lengths are learned from the first pairs.
    Raises CalibrationError for a rig of more than four cameras.
    """

    def __init__(
        self, rig: Rig, config: SilhouetteConfig | None = None, profile: OperatorProfile | None = None
    ) -> None:
        """`profile` is what an earlier run has learned of the operator."""
        if len(rig.cameras) > MAX_VIEWS:
            raise CalibrationError(f"the tracker takes {MAX_VIEWS} cameras at most, the rig has {len(rig.cameras)}")
        self._rig = rig
        self._finder = ArmFinder(rig, [ViewMeter(camera, DarkWall()) for camera in rig.cameras])
        self._learning = BodyLearning(config or SilhouetteConfig(), profile)

    @property
    def profile(self) -> OperatorProfile | None:
        """The operator as learned in all runs, None until this one has learned the arm and the hand."""
        return self._learning.profile

    def track(self, views: Views) -> ArmEstimate:
        """The arm at the views' instant; a frame that cannot be tracked gives the reason."""
        arm = self._finder.find(views, self._learning.body)
        return self._lost(views.t_ns, arm) if isinstance(arm, NoArm) else self._found(arm, self._track_hand(arm))

    def _track_hand(self, arm: SeenArm) -> HandEstimate | None:
        views = tuple(self._finder.hand_views(arm).values())
        if len(views) < MIN_VIEWS:
            self._learning.hand.forget()
            return None
        return self._learning.track_hand(views, self._finder.evidence(arm))

    def _found(self, arm: SeenArm, hand: HandEstimate | None) -> ArmEstimate:
        status, reason = self._judge(arm, hand)
        joints, wrist = arm.joints, arm.joints.wrist if hand is None else hand.wrist
        self._finder.keep(arm, wrist)
        points = {"elbow": joints.elbow, "wrist": wrist}
        covariances = {"elbow": elbow_covariance(joints, arm.limbs), "wrist": wrist_covariance(joints)}
        if hand is not None:
            points |= {"index": hand.index.point, "thumb": hand.thumb.point}
            covariances |= {"index": hand.index.covariance, "thumb": hand.thumb.covariance}
        return ArmEstimate(
            arm.t_ns,
            status,
            reason,
            **points,
            thumb_inferred=_thumb_inferred(hand),
            hand_open=hand is not None and hand.hand_open,
            fingers_together=hand is not None and hand.fingers_together,
            overlays=self._finder.overlays(arm, list(points.values())),
            covariances=covariances,
            residual_px=arm.residual_px,
        )

    def _judge(self, arm: SeenArm, hand: HandEstimate | None) -> tuple[TrackingStatus, str]:
        """Learn while initialising; afterwards the doubts about the result."""
        reasons = doubts(self._rig, arm.limbs, arm.features, arm.joints)
        if hand is None:
            reasons.append(TrackingReason.HAND_UNCLEAR)
        if (arm.residual_px or 0.0) > DOUBTED_TANGENT_RESIDUAL * min(f.half_width for f in arm.features):
            reasons.append(TrackingReason.OUT_OF_STEP)
        if self._learning.body.forearm_length is None:
            sleeve, elbow = self._finder.sleeve(arm), arm.joints.elbow
            to_sleeve_m = math.nan if sleeve is None else float(np.linalg.norm(sleeve - elbow))
            wrist = arm.joints.wrist if hand is None else hand.wrist
            return self._learning.learn(float(np.linalg.norm(wrist - elbow)), to_sleeve_m, reasons)
        if reasons:
            return TrackingStatus.DEGRADED, "; ".join(reasons)
        return TrackingStatus.TRACKED, TrackingReason.THUMB_INFERRED if _thumb_inferred(hand) else ""

    def _lost(self, t_ns: int, arm: NoArm) -> ArmEstimate:
        self._finder.forget()
        self._learning.hand.forget()
        return ArmEstimate(t_ns, TrackingStatus.LOST, arm.reason, residual_px=arm.residual_px)


def _thumb_inferred(hand: HandEstimate | None) -> bool:
    return hand is not None and hand.thumb.views < MIN_VIEWS
