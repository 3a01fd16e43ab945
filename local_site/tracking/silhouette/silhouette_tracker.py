"""The markerless tracker: silhouettes of a bare arm in two or more views to elbow, wrist, index and thumb."""

import math
from collections.abc import Sequence
from dataclasses import dataclass, replace

import numpy as np

from common.errors import CalibrationError
from common.geometry import Array
from common.messages.hand import TrackingStatus
from local_site.calibration.rig import Rig
from local_site.calibration.triangulation import project, triangulate
from local_site.tracking.config import SilhouetteConfig
from local_site.tracking.features.features import Features
from local_site.tracking.features.posture import Posture
from local_site.tracking.features.view_meter import ViewMeter
from local_site.tracking.foreground.dark_wall import DarkWall
from local_site.tracking.silhouette.hand_model.fit import MAX_VIEWS, MIN_VIEWS
from local_site.tracking.silhouette.hand_model.habits import LimbEvidence
from local_site.tracking.silhouette.hand_tracker import HandEstimate
from local_site.tracking.silhouette.hand_view import make_hand_view
from local_site.tracking.silhouette.joints import Joints, elbow_covariance, sleeve_end, solve_joints, wrist_covariance
from local_site.tracking.silhouette.limbs import Limbs, limbs_of
from local_site.tracking.silhouette.operator_profile import BodyLearning, OperatorProfile
from local_site.tracking.silhouette.quality import Tangency, doubts, objection
from local_site.tracking.tracker import ArmEstimate, Overlay, TrackingReason, Views, extrapolation

MAX_PREDICTED_SIGMA = 0.015
MAX_TANGENT_RESIDUAL, DOUBTED_TANGENT_RESIDUAL = 0.4, 0.12
ALONG_SIGMA, ACROSS_SIGMA = 0.006, 0.002


@dataclass(frozen=True, slots=True)
class _Moment:
    """A successful measurement: time, joints, hand, and the features of the views that saw the arm, by their number."""

    t_ns: int
    joints: Joints
    hand: HandEstimate | None
    seen: tuple[int, ...]
    features: tuple[Features, ...]
    limbs: Limbs
    residual_px: float | None

    @property
    def wrist(self) -> Array:
        """The wrist (3,) in m, from the hand where there is one."""
        return self.joints.wrist if self.hand is None else self.hand.wrist


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
        self._projections = rig.matrices
        self._meters = tuple(ViewMeter(camera, DarkWall()) for camera in rig.cameras)
        self._tangency = Tangency(self._projections)
        self._learning = BodyLearning(config or SilhouetteConfig(), profile)
        self._last: _Moment | None = None
        self._before: _Moment | None = None

    @property
    def profile(self) -> OperatorProfile | None:
        """What has been learned of the operator in all runs, None until this one has learned the arm and the hand."""
        return self._learning.profile

    def track(self, views: Views) -> ArmEstimate:
        """The arm at the views' instant; a frame that cannot be tracked gives the reason."""
        if len(views.views) != len(self._meters) or len(self._meters) < MIN_VIEWS:
            return self._lost(views.t_ns, f"{len(views.views)} views for {len(self._meters)} calibrated cameras")
        guesses = self._guesses(views.t_ns)
        measured = [m.features(v, g) for m, v, g in zip(self._meters, views.views, guesses, strict=True)]
        seen = tuple(k for k, found in enumerate(measured) if isinstance(found, Features))
        features = tuple(found for found in measured if isinstance(found, Features))
        if len(seen) < MIN_VIEWS:
            return self._lost(views.t_ns, "; ".join(found for found in measured if isinstance(found, str)))
        # Between two exposures the features are interpolated, but an outline cannot be.
        exposed = all(views.views[k].weight >= 1.0 for k in seen)
        residual_px = self._tangency.residual_px(seen, [f.silhouette for f in features]) if exposed else None
        if (residual_px or 0.0) > MAX_TANGENT_RESIDUAL * min(f.half_width for f in features):
            return self._lost(views.t_ns, TrackingReason.OUT_OF_STEP, residual_px)
        limbs = limbs_of(self._matrices(seen), features)
        joints = solve_joints(limbs, features, self._learning.body)
        problem = objection(joints)
        if joints is None or problem:
            return self._lost(views.t_ns, problem or TrackingReason.NO_ARM, residual_px)
        hand = self._track_hand(seen, features, joints)
        return self._found(_Moment(views.t_ns, joints, hand, seen, features, limbs, residual_px))

    def _matrices(self, seen: Sequence[int]) -> list[Array]:
        return [self._projections[k] for k in seen]

    def _track_hand(self, seen: Sequence[int], features: Sequence[Features], joints: Joints) -> HandEstimate | None:
        matrices = self._matrices(seen)
        hands = [make_hand_view(m, f, joints.wrist) for m, f in zip(matrices, features, strict=True)]
        views = [view for view in hands if view is not None]
        if len(views) < MIN_VIEWS:
            self._learning.hand.forget()
            return None
        far_end = triangulate(matrices, [_farthest(f) for f in features])
        arm = joints.wrist - joints.elbow
        axis = arm / max(float(np.linalg.norm(arm)), 1e-6)
        # Before the hand is fitted, the wrist is less certain along the forearm's axis.
        wrist_covariance = ACROSS_SIGMA**2 * np.eye(3) + ALONG_SIGMA**2 * np.outer(axis, axis)
        return self._learning.track_hand(views, LimbEvidence(joints.wrist, wrist_covariance, joints.elbow, far_end))

    def _found(self, moment: _Moment) -> ArmEstimate:
        status, reason = self._judge(moment)
        self._before, self._last = self._last, moment
        joints, hand = moment.joints, moment.hand
        points = {"elbow": joints.elbow, "wrist": moment.wrist}
        covariances = {"elbow": elbow_covariance(joints, moment.limbs), "wrist": wrist_covariance(joints)}
        if hand is not None:
            points |= {"index": hand.index.point, "thumb": hand.thumb.point}
            covariances |= {"index": hand.index.covariance, "thumb": hand.thumb.covariance}
        seen = dict(zip(moment.seen, moment.features, strict=True))
        return ArmEstimate(
            moment.t_ns,
            status,
            reason,
            **points,
            thumb_inferred=_thumb_inferred(moment),
            hand_open=hand is not None and hand.hand_open,
            overlays=tuple(
                meter.overlay(seen[k], list(points.values())) if k in seen else Overlay()
                for k, meter in enumerate(self._meters)
            ),
            covariances=covariances,
            residual_px=moment.residual_px,
        )

    def _judge(self, moment: _Moment) -> tuple[TrackingStatus, str]:
        """Learn while initialising; afterwards the doubts about the result."""
        reasons = doubts(self._rig, moment.limbs, moment.features, moment.joints)
        if moment.hand is None:
            reasons.append(TrackingReason.HAND_UNCLEAR)
        if (moment.residual_px or 0.0) > DOUBTED_TANGENT_RESIDUAL * min(f.half_width for f in moment.features):
            reasons.append(TrackingReason.OUT_OF_STEP)
        if self._learning.body.forearm_length is None:
            sleeve = sleeve_end(self._matrices(moment.seen), moment.features)
            elbow = moment.joints.elbow
            to_sleeve_m = math.nan if sleeve is None else float(np.linalg.norm(sleeve - elbow))
            return self._learning.learn(float(np.linalg.norm(moment.wrist - elbow)), to_sleeve_m, reasons)
        if reasons:
            return TrackingStatus.DEGRADED, "; ".join(reasons)
        return TrackingStatus.TRACKED, TrackingReason.THUMB_INFERRED if _thumb_inferred(moment) else ""

    def _lost(self, t_ns: int, reason: str, residual_px: float | None = None) -> ArmEstimate:
        self._last = self._before = None
        self._learning.hand.forget()
        for meter in self._meters:
            meter.forget()
        return ArmEstimate(t_ns, TrackingStatus.LOST, reason, residual_px=residual_px)

    def _guesses(self, t_ns: int) -> list[Posture | None]:
        """The expected posture in each view: the last joints extrapolated at constant velocity."""
        guesses: list[Posture | None] = [None] * len(self._meters)
        last, before = self._last, self._before or self._last
        if last is None or before is None:
            return guesses
        factor = extrapolation(t_ns, last.t_ns, before.t_ns)
        predictable = max(last.joints.elbow_sigma, before.joints.elbow_sigma) < MAX_PREDICTED_SIGMA
        elbow = last.joints.elbow + (factor * (last.joints.elbow - before.joints.elbow) if predictable else 0.0)
        wrist = last.wrist + factor * (last.wrist - before.wrist)
        for k, view in zip(last.seen, last.features, strict=True):
            now, end, previous = (project(self._projections[k], p) for p in (elbow, wrist, last.joints.elbow))
            shoulder_end = view.guess.shoulder_end + now - previous
            guesses[k] = replace(
                view.guess, shoulder_end=shoulder_end, elbow=now, wrist=end, half_width=view.half_width
            )
        return guesses


def _thumb_inferred(moment: _Moment) -> bool:
    return moment.hand is not None and moment.hand.thumb.views < MIN_VIEWS


def _farthest(view: Features) -> Array:
    """The outline's pixel (2,) farthest from the wrist."""
    contour = view.silhouette.contour if view.hand is None else view.hand
    pixel: Array = contour[int(np.argmax(np.sum((contour - view.guess.wrist) ** 2, axis=1)))] + view.hand_shift
    return pixel
