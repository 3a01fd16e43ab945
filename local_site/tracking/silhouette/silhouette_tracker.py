"""The markerless tracker: silhouettes of a bare arm before two or more cameras to elbow, wrist, index and thumb."""

import math
from collections.abc import Sequence
from dataclasses import dataclass, replace

import numpy as np

from common.geometry import Array
from common.messages import TrackingStatus
from local_site.calibration.rig import Rig
from local_site.calibration.triangulation import project
from local_site.tracking.silhouette.config import SilhouetteConfig
from local_site.tracking.silhouette.features import Features
from local_site.tracking.silhouette.fingers import Fingers, carried, find_fingers
from local_site.tracking.silhouette.joints import Body, Joints, sleeve_end, solve_joints
from local_site.tracking.silhouette.opening import HandShape, hand_reach, typical_shape
from local_site.tracking.silhouette.posture import Posture
from local_site.tracking.silhouette.quality import doubts, objection
from local_site.tracking.silhouette.view import ViewMeter
from local_site.tracking.tracker import ArmEstimate, Overlay, Views

MAX_PREDICTION_NS = 200_000_000
MAX_PREDICTED_SIGMA = 0.015


@dataclass(frozen=True, slots=True)
class _Moment:
    """A successful measurement: time, joints, fingers, and the features of each view."""

    t_ns: int
    joints: Joints
    fingers: Fingers
    features: tuple[Features, ...]


class SilhouetteTracker:
    """Tracks an arm from its silhouettes (thesis chapter 3).

    Each view is measured on its own; only the places where to look come from the last instants, so nothing is smoothed
    and a loss is over as soon as both views show the arm again. The body's lengths are learned from the first pairs.
    """

    def __init__(self, rig: Rig, config: SilhouetteConfig | None = None) -> None:
        self._rig = rig
        self._config = config or SilhouetteConfig()
        self._projections = rig.matrices
        self._meters = tuple(ViewMeter(camera.name) for camera in rig.cameras)
        self._body = Body(None, self._config.elbow_dorsal_offset)
        self._shape: HandShape | None = None
        self._learned: list[_Moment] = []
        self._last: _Moment | None = None
        self._before: _Moment | None = None

    def track(self, views: Views) -> ArmEstimate:
        """The arm at the views' instant; a frame that cannot be tracked says why."""
        if len(views.views) != len(self._meters) or len(self._meters) < 2:
            return self._lost(views.t_ns, f"{len(views.views)} views for {len(self._meters)} calibrated cameras")
        guesses = self._guesses(views.t_ns)
        measured = [m.features(v, g) for m, v, g in zip(self._meters, views.views, guesses, strict=True)]
        failures = [found for found in measured if isinstance(found, str)]
        features = tuple(found for found in measured if not isinstance(found, str))
        if failures:
            return self._lost(views.t_ns, "; ".join(failures))
        joints = solve_joints(self._projections, features, self._body)
        problem = objection(joints)
        if joints is None or problem:
            return self._lost(views.t_ns, problem)
        return self._found(views.t_ns, joints, features)

    def _found(self, t_ns: int, joints: Joints, features: tuple[Features, ...]) -> ArmEstimate:
        forearm = float(np.linalg.norm(joints.wrist - joints.elbow))
        shape = self._shape or typical_shape(forearm, self._config.right_arm)
        fingers = find_fingers(self._projections, features, joints.wrist, shape, self._expected_fingers(joints))
        moment = _Moment(t_ns, joints, fingers, features)
        status, reason = self._judge(moment)
        self._before, self._last = self._last, moment
        return ArmEstimate(
            t_ns=t_ns,
            status=status,
            reason=reason,
            elbow=joints.elbow,
            wrist=joints.wrist,
            index=fingers.index,
            thumb=fingers.thumb,
            thumb_inferred=fingers.thumb_inferred,
            hand_open=fingers.hand_open,
            overlays=tuple(self._overlay(k, moment) for k in range(len(features))),
        )

    def _judge(self, moment: _Moment) -> tuple[TrackingStatus, str]:
        """Learn while initialising; afterwards say how far the result can be trusted."""
        reasons = doubts(self._rig, moment.features, moment.joints, moment.fingers)
        if self._body.forearm_length is None:
            return self._learn(moment, reasons)
        if reasons:
            return TrackingStatus.DEGRADED, "; ".join(reasons)
        return TrackingStatus.TRACKED, "" if moment.fingers.thumb is not None else "the thumb is not seen in both views"

    def _learn(self, moment: _Moment, reasons: Sequence[str]) -> tuple[TrackingStatus, str]:
        """Take the median lengths of the first good pairs, thesis equation 3.26."""
        wanted = self._config.initial_pairs
        if reasons or moment.fingers.thumb is None:
            why = "; ".join(reasons) or "hold thumb and index apart, so that both views show them"
            return TrackingStatus.INITIALISING, why
        self._learned.append(moment)
        if len(self._learned) < wanted:
            return TrackingStatus.INITIALISING, f"learning the arm: {len(self._learned)} of {wanted} pairs"
        lengths = [_median(values) for values in zip(*map(self._lengths, self._learned), strict=True)]
        sleeve = lengths[1] if math.isfinite(lengths[1]) else None
        self._body = replace(self._body, forearm_length=lengths[0], sleeve_distance=sleeve)
        reach = lengths[5] if math.isfinite(lengths[5]) else None
        self._shape = HandShape(lengths[2], lengths[3], lengths[4], reach, right_arm=self._config.right_arm)
        self._learned.clear()
        return TrackingStatus.INITIALISING, f"learned the arm from {wanted} pairs"

    def _lengths(self, moment: _Moment) -> tuple[float, ...]:
        """Forearm, elbow to sleeve end, wrist to index, wrist to thumb, index to thumb, reach in m; NaN if not seen."""
        missing = np.full(3, np.nan)
        elbow, wrist = moment.joints.elbow, moment.joints.wrist
        index = moment.fingers.index if moment.fingers.index is not None else missing
        thumb = moment.fingers.thumb if moment.fingers.thumb is not None else missing
        reach = hand_reach(self._projections, moment.features, wrist)
        sleeve = sleeve_end(self._projections, moment.features)
        spans = (
            wrist - elbow,
            (sleeve if sleeve is not None else missing) - elbow,
            index - wrist,
            thumb - wrist,
            index - thumb,
        )
        return *(float(np.linalg.norm(span)) for span in spans), reach if reach is not None else math.nan

    def _lost(self, t_ns: int, reason: str) -> ArmEstimate:
        self._last = self._before = None
        self._learned.clear()
        for meter in self._meters:
            meter.forget()
        return ArmEstimate(t_ns=t_ns, status=TrackingStatus.LOST, reason=reason)

    def _velocity_factor(self, t_ns: int) -> float:
        """Time since the last instant in units of the interval before it; 0 where there is nothing to go by."""
        if self._last is None or self._before is None:
            return 0.0
        ahead, interval = t_ns - self._last.t_ns, self._last.t_ns - self._before.t_ns
        return ahead / interval if 0 < ahead <= MAX_PREDICTION_NS and 0 < interval <= MAX_PREDICTION_NS else 0.0

    def _guesses(self, t_ns: int) -> list[Posture | None]:
        """Where each view should look: the last joints moved on at constant velocity."""
        if self._last is None:
            return [None] * len(self._meters)
        factor = self._velocity_factor(t_ns)
        last, before = self._last.joints, (self._before or self._last).joints
        sure = max(last.elbow_sigma, before.elbow_sigma) < MAX_PREDICTED_SIGMA
        elbow = last.elbow + (factor * (last.elbow - before.elbow) if sure else 0.0)
        wrist = last.wrist + factor * (last.wrist - before.wrist)
        return [
            _moved(f.guess, project(m, elbow), project(m, wrist), project(m, last.elbow), f.half_width)
            for m, f in zip(self._projections, self._last.features, strict=True)
        ]

    def _expected_fingers(self, joints: Joints) -> Fingers:
        """The last fingers, carried along with the wrist; an open hand says nothing of where the thumb will be."""
        if self._last is None:
            return Fingers(None, None)
        expected = carried(self._last.fingers, joints.wrist - self._last.joints.wrist)
        return replace(expected, thumb=None) if self._last.fingers.hand_open else expected

    def _overlay(self, view: int, moment: _Moment) -> Overlay:
        f, projection = moment.features[view], self._projections[view]
        upper = f.upper_arm

        def pixel(point: Array | None) -> Array | None:
            return None if point is None else project(projection, point)

        return Overlay(
            contour=f.silhouette.contour.astype(np.int32),
            forearm_line=np.array([f.forearm.at(0.0), f.guess.wrist]),
            upper_arm_line=None if upper is None else np.array([upper.at(0.0), f.guess.shoulder_end]),
            elbow=pixel(moment.joints.elbow),
            wrist=pixel(moment.joints.wrist),
            index=pixel(moment.fingers.index),
            thumb=pixel(moment.fingers.thumb),
        )


def _median(values: Sequence[float]) -> float:
    """The median of the finite values, NaN without any."""
    finite = [value for value in values if math.isfinite(value)]
    return float(np.median(finite)) if finite else math.nan


def _moved(guess: Posture, elbow: Array, wrist: Array, last_elbow: Array, half_width: float) -> Posture:
    shoulder_end = guess.shoulder_end + elbow - last_elbow
    return replace(guess, shoulder_end=shoulder_end, elbow=elbow, wrist=wrist, half_width=half_width)
