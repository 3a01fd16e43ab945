"""The arm in the silhouettes of all views: features, limbs and joints, searched near the last instants' posture."""

from collections.abc import Sequence
from dataclasses import dataclass, replace
from typing import Protocol

import numpy as np

from common.geometry import Array
from local_site.calibration.rig import Rig
from local_site.calibration.triangulation import project, triangulate
from local_site.tracking.features.features import Features
from local_site.tracking.features.posture import Posture
from local_site.tracking.silhouette.hand_model.fit import MIN_VIEWS, HandView
from local_site.tracking.silhouette.hand_model.habits import LimbEvidence
from local_site.tracking.silhouette.hand_view import make_hand_view
from local_site.tracking.silhouette.joints import Body, Joints, sleeve_end, solve_joints
from local_site.tracking.silhouette.limbs import Limbs, limbs_of
from local_site.tracking.silhouette.quality import Tangency, objection
from local_site.tracking.tracker import Overlay, TrackingReason, View, Views, extrapolation

MAX_PREDICTED_SIGMA = 0.015
MAX_TANGENT_RESIDUAL = 0.4
ALONG_SIGMA, ACROSS_SIGMA = 0.006, 0.002


@dataclass(frozen=True, slots=True)
class SeenArm:
    """An arm at one instant: its joints, and the features of the views that saw it, by their number.

    `residual_px` is the epipolar residual between the silhouettes, None if they were not compared.
    """

    t_ns: int
    joints: Joints
    seen: tuple[int, ...]
    features: tuple[Features, ...]
    limbs: Limbs
    residual_px: float | None


@dataclass(frozen=True, slots=True)
class NoArm:
    """The reason why no arm was found, with the epipolar residual in px if it is that."""

    reason: str
    residual_px: float | None = None


class Meter(Protocol):
    """Measures the pictures of one camera."""

    def features(self, view: View, guess: Posture | None) -> Features | str: ...

    def overlay(self, view: Features, points: Sequence[Array]) -> Overlay: ...

    def forget(self) -> None: ...


class ArmFinder:
    """Finds elbow and wrist in the views; only the search regions come from the last instants."""

    def __init__(self, rig: Rig, meters: Sequence[Meter]) -> None:
        """`meters` measure the pictures of the rig's cameras, in their order."""
        self.projections = rig.matrices
        self._meters = tuple(meters)
        self._tangency = Tangency(self.projections)
        self._last: tuple[SeenArm, Array] | None = None
        self._before: tuple[SeenArm, Array] | None = None

    def find(self, views: Views, body: Body, hints: Sequence[Posture | None] = ()) -> SeenArm | NoArm:
        """The arm at the views' instant; `hints` say by view where to begin when no arm was kept."""
        if len(views.views) != len(self._meters) or len(self._meters) < MIN_VIEWS:
            return NoArm(f"{len(views.views)} views for {len(self._meters)} calibrated cameras")
        guesses = self._guesses(views.t_ns) if self._last is not None or not hints else hints
        measured = [m.features(v, g) for m, v, g in zip(self._meters, views.views, guesses, strict=True)]
        seen = tuple(k for k, found in enumerate(measured) if isinstance(found, Features))
        features = tuple(found for found in measured if isinstance(found, Features))
        if len(seen) < MIN_VIEWS:
            return NoArm("; ".join(found for found in measured if isinstance(found, str)))
        # Between two exposures the features are interpolated, but an outline cannot be.
        exposed = all(views.views[k].weight >= 1.0 for k in seen)
        residual_px = self._tangency.residual_px(seen, [f.silhouette for f in features]) if exposed else None
        if (residual_px or 0.0) > MAX_TANGENT_RESIDUAL * min(f.half_width for f in features):
            return NoArm(TrackingReason.OUT_OF_STEP, residual_px)
        limbs = limbs_of(self.matrices(seen), features)
        joints = solve_joints(limbs, features, body)
        problem = objection(joints)
        if joints is None or problem:
            return NoArm(problem or TrackingReason.NO_ARM, residual_px)
        return SeenArm(views.t_ns, joints, seen, features, limbs, residual_px)

    def matrices(self, seen: Sequence[int]) -> list[Array]:
        """The projections (3, 4) of some views."""
        return [self.projections[k] for k in seen]

    def hand_views(self, arm: SeenArm) -> dict[int, HandView]:
        """The hand's part of each silhouette, by the view's number."""
        hands = {
            k: make_hand_view(self.projections[k], features, arm.joints.wrist)
            for k, features in zip(arm.seen, arm.features, strict=True)
        }
        return {k: view for k, view in hands.items() if view is not None}

    def evidence(self, arm: SeenArm) -> LimbEvidence:
        """Return what the limbs show of the hand."""
        far_end = triangulate(self.matrices(arm.seen), [_farthest(f) for f in arm.features])
        along = arm.joints.wrist - arm.joints.elbow
        axis = along / max(float(np.linalg.norm(along)), 1e-6)
        # Before the hand is fitted, the wrist is less certain along the forearm's axis.
        wrist_covariance = ACROSS_SIGMA**2 * np.eye(3) + ALONG_SIGMA**2 * np.outer(axis, axis)
        return LimbEvidence(arm.joints.wrist, wrist_covariance, arm.joints.elbow, far_end)

    def sleeve(self, arm: SeenArm) -> Array | None:
        """Find where the sleeve ends (3,) in m; None where it is not seen."""
        return sleeve_end(self.matrices(arm.seen), arm.features)

    def overlays(self, arm: SeenArm, points: Sequence[Array]) -> tuple[Overlay, ...]:
        """Build what to draw over each view; points (3,) in m are elbow and wrist, and index and thumb where known."""
        seen = dict(zip(arm.seen, arm.features, strict=True))
        return tuple(meter.overlay(seen[k], points) if k in seen else Overlay() for k, meter in enumerate(self._meters))

    def keep(self, arm: SeenArm, wrist: Array) -> None:
        """Search near this arm from now on; its wrist (3,) in m may be known better by now."""
        self._before, self._last = self._last, (arm, wrist)

    def forget(self) -> None:
        """Search everywhere from now on."""
        self._last = self._before = None
        for meter in self._meters:
            meter.forget()

    def _guesses(self, t_ns: int) -> list[Posture | None]:
        """The expected posture in each view: the last joints extrapolated at constant velocity."""
        guesses: list[Posture | None] = [None] * len(self._meters)
        if self._last is None:
            return guesses
        (last, last_wrist), (before, wrist_before) = self._last, self._before or self._last
        factor = extrapolation(t_ns, last.t_ns, before.t_ns)
        predictable = max(last.joints.elbow_sigma, before.joints.elbow_sigma) < MAX_PREDICTED_SIGMA
        elbow = last.joints.elbow + (factor * (last.joints.elbow - before.joints.elbow) if predictable else 0.0)
        wrist = last_wrist + factor * (last_wrist - wrist_before)
        for k, view in zip(last.seen, last.features, strict=True):
            now, end, previous = (project(self.projections[k], p) for p in (elbow, wrist, last.joints.elbow))
            shoulder_end = view.guess.shoulder_end + now - previous
            guesses[k] = replace(
                view.guess, shoulder_end=shoulder_end, elbow=now, wrist=end, half_width=view.half_width
            )
        return guesses


def _farthest(view: Features) -> Array:
    """The outline's pixel (2,) farthest from the wrist."""
    contour = view.silhouette.contour if view.hand is None else view.hand
    pixel: Array = contour[int(np.argmax(np.sum((contour - view.guess.wrist) ** 2, axis=1)))] + view.hand_shift
    return pixel
