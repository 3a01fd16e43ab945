"""The markerless tracker: silhouettes of a bare arm before two or more cameras to elbow, wrist, index and thumb."""

import math
from collections.abc import Sequence
from dataclasses import dataclass, replace

import numpy as np

from common.errors import CalibrationError
from common.geometry import Array
from common.messages.hand import TrackingStatus
from local_site.calibration.rig import Rig
from local_site.calibration.triangulation import project, triangulate
from local_site.tracking.reasons import TrackingReason, sentence
from local_site.tracking.silhouette.config import SilhouetteConfig
from local_site.tracking.silhouette.features import Features
from local_site.tracking.silhouette.hand_model.fit import MAX_VIEWS, MIN_VIEWS, HandView
from local_site.tracking.silhouette.hand_tracker import HandEstimate, HandTracker, LimbEvidence
from local_site.tracking.silhouette.hand_view import make_hand_view
from local_site.tracking.silhouette.handedness import looks_like_the_other_arm
from local_site.tracking.silhouette.joints import Body, Joints, sleeve_end, solve_joints
from local_site.tracking.silhouette.limbs import Limbs, limbs_of
from local_site.tracking.silhouette.operator_profile import OperatorProfile, make_profile
from local_site.tracking.silhouette.overlay import overlay_of
from local_site.tracking.silhouette.posture import Posture
from local_site.tracking.silhouette.quality import doubts, objection
from local_site.tracking.silhouette.tangency import Tangency
from local_site.tracking.silhouette.uncertainty import elbow_covariance, wrist_covariance
from local_site.tracking.silhouette.view import ViewMeter
from local_site.tracking.tracker import ArmEstimate, Overlay, Views

MAX_PREDICTION_NS = 200_000_000
MAX_PREDICTED_SIGMA = 0.015
MAX_TANGENT_RESIDUAL, DOUBTED_TANGENT_RESIDUAL = 0.4, 0.12
TRIALS = 2  # times the pairs to learn from, in which a profile's hand must be found, or it is another body's
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

    Each view is measured on its own; only the places where to look come from the last instants, so nothing is smoothed
    and a loss is over as soon as two views show the arm again. The body's lengths are learned from the first pairs.
    Raises CalibrationError for a rig of more than four cameras.
    """

    def __init__(
        self, rig: Rig, config: SilhouetteConfig | None = None, profile: OperatorProfile | None = None
    ) -> None:
        """`profile` is what an earlier run has learned of the operator."""
        if len(rig.cameras) > MAX_VIEWS:
            raise CalibrationError(f"the tracker takes {MAX_VIEWS} cameras at most, the rig has {len(rig.cameras)}")
        self._rig = rig
        self._config = config or SilhouetteConfig()
        self._projections = rig.matrices
        self._meters = tuple(ViewMeter(camera) for camera in rig.cameras)
        self._tangency = Tangency(self._projections)
        self._body = Body()
        self._profile = profile
        self._hand = self._new_hand()
        self._lesson = TrackingReason.LEARNING
        self._shown: tuple[Sequence[HandView], LimbEvidence] | None = None
        self._lengths: list[tuple[float, float]] = []
        self._trials = 0
        self._last: _Moment | None = None
        self._before: _Moment | None = None

    @property
    def profile(self) -> OperatorProfile | None:
        """What has been learned of the operator in all runs, None until this one has learned the arm and the hand."""
        length, hand = self._body.forearm_length, self._hand.learned
        if length is None or hand is None:
            return None
        return make_profile(*hand, length, self._pairs)

    @property
    def _pairs(self) -> int:
        return self._config.initial_pairs + (0 if self._profile is None else self._profile.pairs)

    def _new_hand(self) -> HandTracker:
        known, config = self._profile, self._config
        if known is None:
            return HandTracker(config.initial_pairs, config.right_arm)
        return HandTracker(config.initial_pairs, config.right_arm, known.habits, known.scale)

    def track(self, views: Views) -> ArmEstimate:
        """The arm at the views' instant; a frame that cannot be tracked says why."""
        if len(views.views) != len(self._meters) or len(self._meters) < MIN_VIEWS:
            return self._lost(views.t_ns, f"{len(views.views)} views for {len(self._meters)} calibrated cameras")
        guesses = self._guesses(views.t_ns)
        measured = [m.features(v, g) for m, v, g in zip(self._meters, views.views, guesses, strict=True)]
        seen = tuple(k for k, found in enumerate(measured) if isinstance(found, Features))
        features = tuple(found for found in measured if isinstance(found, Features))
        if len(seen) < MIN_VIEWS:
            return self._lost(views.t_ns, sentence(found for found in measured if isinstance(found, str)))
        # Between two exposures the features are interpolated, but an outline cannot be.
        exposed = all(views.views[k].weight >= 1.0 for k in seen)
        residual_px = self._tangency.residual_px(seen, [f.silhouette for f in features]) if exposed else None
        if (residual_px or 0.0) > MAX_TANGENT_RESIDUAL * min(f.half_width for f in features):
            return self._lost(views.t_ns, TrackingReason.OUT_OF_STEP, residual_px)
        limbs = limbs_of(self._matrices(seen), features)
        joints = solve_joints(limbs, features, self._body)
        problem = objection(joints)
        if joints is None or problem:
            return self._lost(views.t_ns, problem or TrackingReason.NO_ARM, residual_px)
        hand = self._track_hand(seen, features, joints)
        return self._found(_Moment(views.t_ns, joints, hand, seen, features, limbs, residual_px))

    def _matrices(self, seen: Sequence[int]) -> list[Array]:
        return [self._projections[k] for k in seen]

    def _track_hand(self, seen: Sequence[int], features: Sequence[Features], joints: Joints) -> HandEstimate | None:
        matrices = self._matrices(seen)
        pairs = [(make_hand_view(m, f, joints.wrist), f) for m, f in zip(matrices, features, strict=True)]
        views = [view for view, _ in pairs if view is not None]
        if len(views) < MIN_VIEWS:
            self._hand.forget()
            return None
        ends = [_farthest(f) for f in features]
        arm = LimbEvidence(joints.wrist, _wrist_prior(joints), joints.elbow, triangulate(matrices, ends))
        self._shown = views, arm
        return self._hand.track(views, arm)

    def _found(self, moment: _Moment) -> ArmEstimate:
        status, reason = self._judge(moment)
        self._before, self._last = self._last, moment
        hand = moment.hand
        covariances = {
            "elbow": elbow_covariance(moment.joints, moment.limbs),
            "wrist": wrist_covariance(moment.joints),
        }
        if hand is not None:
            covariances |= {"index": hand.index.covariance, "thumb": hand.thumb.covariance}
        return ArmEstimate(
            t_ns=moment.t_ns,
            status=status,
            reason=reason,
            elbow=moment.joints.elbow,
            wrist=moment.wrist,
            index=None if hand is None else hand.index.point,
            thumb=None if hand is None else hand.thumb.point,
            thumb_inferred=hand is not None and hand.thumb.views < MIN_VIEWS,
            hand_open=hand is not None and hand.hand_open,
            overlays=self._overlays(moment),
            covariances=covariances,
            residual_px=moment.residual_px,
        )

    def _judge(self, moment: _Moment) -> tuple[TrackingStatus, str]:
        """Learn while initialising; afterwards say how far the result can be trusted."""
        reasons = doubts(self._rig, moment.limbs, moment.features, moment.joints)
        if moment.hand is None:
            reasons.append(TrackingReason.HAND_UNCLEAR)
        if (moment.residual_px or 0.0) > DOUBTED_TANGENT_RESIDUAL * min(f.half_width for f in moment.features):
            reasons.append(TrackingReason.OUT_OF_STEP)
        if self._body.forearm_length is None:
            return self._learn(moment, reasons)
        if reasons:
            return TrackingStatus.DEGRADED, sentence(reasons)
        inferred = moment.hand is not None and moment.hand.thumb.views < MIN_VIEWS
        return TrackingStatus.TRACKED, TrackingReason.THUMB_INFERRED if inferred else ""

    def _learn(self, moment: _Moment, reasons: Sequence[TrackingReason]) -> tuple[TrackingStatus, str]:
        """Take the median lengths of the first good pairs, thesis equation 3.26."""
        if self._profile is not None and not set(reasons) - {TrackingReason.HAND_UNCLEAR}:
            self._trials += 1
            if self._trials > TRIALS * self._config.initial_pairs:
                return self._learn_without_profile()
        if reasons:
            return TrackingStatus.INITIALISING, sentence(reasons)
        sleeve = sleeve_end(self._matrices(moment.seen), moment.features)
        elbow = moment.joints.elbow
        to_sleeve = math.nan if sleeve is None else float(np.linalg.norm(sleeve - elbow))
        self._lengths.append((float(np.linalg.norm(moment.wrist - elbow)), to_sleeve))
        count = f"{len(self._lengths)} of {self._config.initial_pairs} pairs"
        if len(self._lengths) < self._config.initial_pairs:
            return TrackingStatus.INITIALISING, f"{self._lesson} ({count})"
        forearm, upper = (_median(values) for values in zip(*self._lengths, strict=True))
        if self._shown is not None and looks_like_the_other_arm(*self._shown, self._config.right_arm):
            return self._learn_anew(TrackingReason.OTHER_ARM)
        if self._profile is not None and not self._profile.is_of(forearm):
            return self._learn_without_profile()
        if self._profile is not None:
            forearm = self._profile.length_with(forearm, self._config.initial_pairs)
        self._body = Body(forearm, upper if math.isfinite(upper) else None)
        return TrackingStatus.INITIALISING, f"{self._lesson} ({count})"

    def _learn_without_profile(self) -> tuple[TrackingStatus, str]:
        self._profile = None
        return self._learn_anew(TrackingReason.OTHER_BODY)

    def _learn_anew(self, why: TrackingReason) -> tuple[TrackingStatus, str]:
        self._lengths.clear()
        self._lesson = why
        self._hand = self._new_hand()
        return TrackingStatus.INITIALISING, why

    def _lost(self, t_ns: int, reason: str, residual_px: float | None = None) -> ArmEstimate:
        self._last = self._before = None
        self._hand.forget()
        for meter in self._meters:
            meter.forget()
        return ArmEstimate(t_ns=t_ns, status=TrackingStatus.LOST, reason=reason, residual_px=residual_px)

    def _velocity_factor(self, t_ns: int) -> float:
        """Time since the last instant in units of the interval before it; 0 where there is nothing to go by."""
        if self._last is None or self._before is None:
            return 0.0
        ahead, interval = t_ns - self._last.t_ns, self._last.t_ns - self._before.t_ns
        return ahead / interval if 0 < ahead <= MAX_PREDICTION_NS and 0 < interval <= MAX_PREDICTION_NS else 0.0

    def _guesses(self, t_ns: int) -> list[Posture | None]:
        """Where each view should look: the last joints moved on at constant velocity."""
        guesses: list[Posture | None] = [None] * len(self._meters)
        if self._last is None:
            return guesses
        factor, last = self._velocity_factor(t_ns), self._last
        before = self._before or last
        sure = max(last.joints.elbow_sigma, before.joints.elbow_sigma) < MAX_PREDICTED_SIGMA
        elbow = last.joints.elbow + (factor * (last.joints.elbow - before.joints.elbow) if sure else 0.0)
        wrist = last.wrist + factor * (last.wrist - before.wrist)
        for k, f in zip(last.seen, last.features, strict=True):
            m = self._projections[k]
            moved = project(m, elbow), project(m, wrist), project(m, last.joints.elbow)
            guesses[k] = _moved(f.guess, *moved, f.half_width)
        return guesses

    def _overlays(self, moment: _Moment) -> tuple[Overlay, ...]:
        seen = dict(zip(moment.seen, moment.features, strict=True))
        hand = moment.hand
        points = (moment.joints.elbow, moment.wrist, *(() if hand is None else (hand.index.point, hand.thumb.point)))
        return tuple(
            overlay_of(camera, seen[k], points) if k in seen else Overlay()
            for k, camera in enumerate(self._rig.cameras)
        )


def _wrist_prior(joints: Joints) -> Array:
    """What the limbs say of the wrist before the hand is fitted: it lies on the forearm's axis, less sure along it."""
    arm = joints.wrist - joints.elbow
    axis = arm / max(float(np.linalg.norm(arm)), 1e-6)
    result: Array = ACROSS_SIGMA**2 * np.eye(3) + ALONG_SIGMA**2 * np.outer(axis, axis)
    return result


def _farthest(view: Features) -> Array:
    """The outline's pixel (2,) farthest from the wrist."""
    contour = view.silhouette.contour if view.hand is None else view.hand
    pixel: Array = contour[int(np.argmax(np.sum((contour - view.guess.wrist) ** 2, axis=1)))] + view.hand_shift
    return pixel


def _median(values: Sequence[float]) -> float:
    """The median of the finite values, NaN without any."""
    finite = [value for value in values if math.isfinite(value)]
    return float(np.median(finite)) if finite else math.nan


def _moved(guess: Posture, elbow: Array, wrist: Array, last_elbow: Array, half_width: float) -> Posture:
    shoulder_end = guess.shoulder_end + elbow - last_elbow
    return replace(guess, shoulder_end=shoulder_end, elbow=elbow, wrist=wrist, half_width=half_width)
