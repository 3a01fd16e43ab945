"""The tracker by networks: they say where the arm is in every view, and one fit says where its points are in space."""

from collections.abc import Sequence
from dataclasses import dataclass
from functools import partial

import numpy as np

from common.clock import NS_PER_S
from common.geometry import Array
from common.messages.hand import TrackingStatus
from local_site.calibration.rig import Rig
from local_site.tracking.config import EyeConfig
from local_site.tracking.eye.arm_points import ELBOW, INDEX_TIP, POINTS, THUMB_TIP, WRIST
from local_site.tracking.eye.fitted_points import Expected, FittedPoints, Lengths, fit_points
from local_site.tracking.eye.hand_search import HandSearch
from local_site.tracking.eye.networks import EyeNetworks
from local_site.tracking.eye.view_sight import ViewEye, ViewSight, blended
from local_site.tracking.features.view_meter import views_problem
from local_site.tracking.tracker import ArmEstimate, FrameCache, Overlay, TrackingReason, Views

MIN_VIEWS = 2
START_SIGMA_M, START_LOOKS = 0.12, 3
STEP_M, ACCELERATION_M_S2 = 0.006, 40.0  # how far a point is from where it was expected
LONGEST_S = 0.2  # of a loss of pictures or a jump of the clock, after which the hand is searched
BARE, MOST_SPREAD_M = 0.9, 0.020  # of a hand to begin with: two views are that sure, and where its points are
NOT_BARE, OTHER_SIDE = 0.25, 0.08
MOST_STARTS, BEGUN_MISFIT, MOST_MISFIT = 4, 1.0, 3.0
OUT_OF_STEP = 0.7  # of the misfit over some instants: views that fit have 0.1 to 0.3, of exchanged cameras 1 to 2
MOST_SIGMA_M, MOST_ELBOW_SIGMA_M = 0.03, 0.05
MEMORY = 0.1  # weight of the newest instant in what is judged over some
PATIENCE = 5  # instants in which nothing like a hand is seen, after which it is lost
BIAS_M, ELBOW_BIAS_M = 0.006, 0.025  # by which a network errs in all pictures of a hand alike
UNCLEAR_M = 0.04  # of a hand that may be none: so unsure a point stops the arm
POINT_NAMES = {"wrist": WRIST, "index": INDEX_TIP, "thumb": THUMB_TIP}


@dataclass(frozen=True, slots=True)
class _LastArm:
    t_ns: int
    points: Array
    velocity: Array
    sigma_m: Array


class EyeTracker:
    """Tracks a bare arm before any background, from two views on."""

    def __init__(self, rig: Rig, config: EyeConfig | None = None) -> None:
        self._rig, config = rig, config or EyeConfig()
        networks = EyeNetworks()
        self._needed = config.initial_pairs
        self._eyes = [ViewEye(camera, networks, right_arm=config.right_arm) for camera in rig.cameras]
        self._frames: list[FrameCache[ViewSight]] = [FrameCache(blended) for _ in rig.cameras]
        self._search = HandSearch(rig, networks)
        self._lengths = Lengths.unknown()
        self._last: _LastArm | None = None
        self._pairs = self._unseen = self._turn = 0
        self._side, self._misfit = 0.5, 0.0

    def track(self, views: Views) -> ArmEstimate:
        """The arm at the views' instant; a frame that cannot be tracked gives the reason."""
        problem = views_problem(self._rig, views, MIN_VIEWS)
        if problem:
            return self._lost(views, problem)
        if self._last is not None and abs(views.t_ns - self._last.t_ns) > LONGEST_S * NS_PER_S:
            self._forget()
        sights, fit = self._follow(views, self._last) if self._last is not None else self._begin(views)
        if isinstance(fit, TrackingReason):
            return self._lost(views, fit)
        self._judge(sights, fit)
        self._unseen = self._unseen + 1 if self._is_doubtful(sights, fit) else 0
        if self._unseen > PATIENCE or not np.isfinite(fit.points).all():
            return self._lost(views, TrackingReason.NO_HAND)
        if self._pairs >= self._needed and (self._side < OTHER_SIDE or self._misfit > OUT_OF_STEP):
            is_other = self._side < OTHER_SIDE
            return self._lost(views, TrackingReason.OTHER_SIDE if is_other else TrackingReason.OUT_OF_STEP)
        self._keep(views.t_ns, fit)
        return self._estimate(views.t_ns, sights, fit)

    def _judge(self, sights: Sequence[ViewSight], fit: FittedPoints) -> None:
        """Average how much the hand looks like one of the operator's side, and how well the views fit together."""
        side, share = float(np.mean([sight.side for sight in sights])), 1.0 if self._last is None else MEMORY
        self._side += share * (side - self._side)
        self._misfit += share * (fit.misfit - self._misfit)

    def _begin(self, views: Views) -> tuple[list[ViewSight], FittedPoints | TrackingReason]:
        """Search for a hand, and look at it more and more closely; at one of those that were found in each instant."""
        found = self._search.starts([view.current.image for view in views.views])
        starts = ([points for points in found if self._rig.contains(points[WRIST])] or found)[:MOST_STARTS]
        if not starts:
            return [], TrackingReason.NO_HAND
        self._turn += 1
        points = starts[self._turn % len(starts)]
        for _ in range(START_LOOKS):
            sights = [eye.look(view.current, points) for eye, view in zip(self._eyes, views.views, strict=True)]
            fit = self._fitted(sights, Expected(points, np.full(POINTS, START_SIGMA_M)))
            points = fit.points
        return sights, self._refusal(sights, fit) or fit

    def _refusal(self, sights: Sequence[ViewSight], fit: FittedPoints) -> TrackingReason | None:
        """Return why this is not the operator's hand; None if two views are sure of it. Others may not show it."""
        surest = sorted(sights, key=lambda sight: -sight.bare)[:MIN_VIEWS]
        side = float(np.mean([sight.side for sight in surest]))
        spread_m = float(np.sqrt(np.median(np.trace(fit.covariances[WRIST:], axis1=1, axis2=2))))
        is_hand = surest[-1].bare > BARE and spread_m < MOST_SPREAD_M and fit.misfit < BEGUN_MISFIT
        if not is_hand or not side > OTHER_SIDE:
            return TrackingReason.OTHER_SIDE if is_hand else TrackingReason.NO_HAND
        return None if self._rig.contains(fit.points[WRIST]) else TrackingReason.OUTSIDE_VOLUME

    def _follow(self, views: Views, last: _LastArm) -> tuple[list[ViewSight], FittedPoints]:
        ahead_s = (views.t_ns - last.t_ns) / NS_PER_S
        points = last.points + ahead_s * last.velocity
        sights = []
        self._turn = (self._turn + 1) % len(self._eyes)
        for k, (eye, frames, view) in enumerate(zip(self._eyes, self._frames, views.views, strict=True)):
            look = partial(eye.look, points=points, whole_arm=k == self._turn)
            sight = frames.at(view, look)
            if not isinstance(sight, str):  # looking gives no such reason
                sights.append(sight)
        step_m = STEP_M + 0.5 * ACCELERATION_M_S2 * ahead_s**2
        return sights, self._fitted(sights, Expected(points, np.hypot(last.sigma_m, step_m)))

    def _fitted(self, sights: Sequence[ViewSight], expected: Expected) -> FittedPoints:
        seen = [sight.of(matrix) for sight, matrix in zip(sights, self._rig.matrices, strict=True)]
        return fit_points(seen, expected, self._lengths)

    def _is_doubtful(self, sights: Sequence[ViewSight], fit: FittedPoints) -> bool:
        return float(np.mean([sight.bare for sight in sights])) < NOT_BARE or fit.misfit > MOST_MISFIT

    def _keep(self, t_ns: int, fit: FittedPoints) -> None:
        velocity = np.zeros((POINTS, 3))
        if self._last is not None and t_ns > self._last.t_ns:
            velocity = (fit.points - self._last.points) * NS_PER_S / (t_ns - self._last.t_ns)
        sigma_m = np.sqrt(np.trace(fit.covariances, axis1=1, axis2=2) / 3.0)
        self._last = _LastArm(t_ns, fit.points, velocity, sigma_m)
        if not self._unseen:
            self._pairs += 1
            self._lengths = self._lengths.learned(fit.length_m, fit.length_sigma_m)

    def _estimate(self, t_ns: int, sights: Sequence[ViewSight], fit: FittedPoints) -> ArmEstimate:
        points = {name: fit.points[k] for name, k in POINT_NAMES.items()}
        bias_m = UNCLEAR_M if self._unseen else BIAS_M
        covariances = {name: fit.covariances[k] + bias_m**2 * np.eye(3) for name, k in POINT_NAMES.items()}
        reasons = [TrackingReason.HAND_UNCLEAR] if _sigma(covariances["wrist"]) > MOST_SIGMA_M else []
        if not self._rig.contains(points["wrist"]):
            reasons.append(TrackingReason.OUTSIDE_VOLUME)
        if _sigma(fit.covariances[ELBOW]) < MOST_ELBOW_SIGMA_M:
            points["elbow"] = fit.points[ELBOW]
            covariances["elbow"] = fit.covariances[ELBOW] + ELBOW_BIAS_M**2 * np.eye(3)
        status = TrackingStatus.DEGRADED if reasons else TrackingStatus.TRACKED
        if not reasons and self._pairs < self._needed:
            status, reasons = TrackingStatus.INITIALISING, [TrackingReason.LEARNING]
        return ArmEstimate(
            t_ns,
            status,
            "; ".join(reasons),
            **points,
            overlays=self._overlays(sights, points),
            covariances=covariances,
        )

    def _overlays(self, sights: Sequence[ViewSight], points: dict[str, Array]) -> tuple[Overlay, ...]:
        overlays = []
        for eye, sight in zip(self._eyes, sights, strict=True):
            at = {name: eye.in_picture(point) for name, point in points.items()}
            overlays.append(Overlay(contour=sight.contour, **at))
        return tuple(overlays)

    def _forget(self) -> None:
        self._last, self._unseen, self._side, self._misfit = None, 0, 0.5, 0.0
        self._pairs, self._lengths = 0, Lengths.unknown()  # the next hand may be another person's

    def _lost(self, views: Views, reason: str) -> ArmEstimate:
        self._forget()
        return ArmEstimate(views.t_ns, TrackingStatus.LOST, reason)


def _sigma(covariance: Array) -> float:
    """The greatest standard deviation in m of a covariance (3, 3)."""
    return float(np.sqrt(np.linalg.eigvalsh(covariance)[-1]))
