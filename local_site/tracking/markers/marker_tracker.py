"""The marker tracker: three bright markers on wrist, index and thumb in two to four views to their positions."""

import math
from collections.abc import Sequence

import numpy as np

from common.geometry import Array
from common.messages.hand import TrackingStatus
from local_site.calibration.rig import Rig
from local_site.calibration.triangulation import epipolar_residuals, fundamentals
from local_site.tracking.config import MarkersConfig
from local_site.tracking.markers.correspondence import Candidates, correspond
from local_site.tracking.markers.identity import NO_CANDIDATE, ROLES, MarkerIdentity, first_identity, next_identity
from local_site.tracking.markers.learned import Learning, MarkedHand, Memory, is_open
from local_site.tracking.markers.measuring import MarkerMeter, Sighting
from local_site.tracking.markers.spots import NO_SPOTS, SpotFinder, Spots
from local_site.tracking.tracker import ArmEstimate, Overlay, TrackingReason, Views

FORGET_AFTER = 60
LEAST_RESIDUAL_PX = 0.3
GATE = 10.0
REFUSED = 6.0
DOUBTED = 2.5
MAX_SIGMA_M = 0.015


class Quality:
    """Doubts and refusals of the measured markers, by the residuals usual for this rig and its calibrated volume.

    `gate_px` is the largest reprojection error in px at which spots are taken for one marker.
    """

    def __init__(self, rig: Rig) -> None:
        self._rig = rig
        usual = float(np.mean([camera.reprojection_rms_px for camera in rig.cameras]))
        self._of_pairs = fundamentals(rig.matrices)
        self._usual_px = float(np.hypot(LEAST_RESIDUAL_PX, usual))
        self.gate_px = GATE * self._usual_px

    def out_of_sync(self, sightings: Sequence[Sighting | None]) -> bool:
        """Return whether the reprojection errors are too large for one instant and one calibration."""
        return self._residual_px(sightings) > REFUSED * self._usual_px

    def epipolar_px(self, sightings: Sequence[Sighting | None], spots: Sequence[Spots]) -> float | None:
        """The rms distance of the markers' spots from each other's epipolar lines, px; None without a marker."""
        seen = [sighting for sighting in sightings if sighting is not None]
        if not seen:
            return None
        pixels = np.full((len(seen), len(spots), 2), np.nan)
        for row, sighting in zip(pixels, seen, strict=True):
            for k, spot in enumerate(sighting.spots):
                if spot != NO_CANDIDATE:
                    row[k] = spots[k].pixels[spot]
        return math.sqrt(float(np.nanmean(np.square(epipolar_residuals(self._of_pairs, pixels)))))

    def remarks(
        self, sightings: Sequence[Sighting | None], identity: MarkerIdentity, spots: Sequence[Spots]
    ) -> list[str]:
        """Say why a result is less certain than usual, or incomplete, a sentence each."""
        remarks = [self._remark(*it) for it in zip(ROLES, sightings, identity.chosen, identity.doubtful, strict=True)]
        if self._residual_px(sightings) > DOUBTED * self._usual_px:
            remarks.append("the views fit badly: they may be out of sync")
        for k, camera in enumerate(self._rig.cameras):
            if len(spots[k]) and all(s is None or s.spots[k] == NO_CANDIDATE for s in sightings):
                remarks.append(f"{camera.name}: the spots of this camera do not fit those of the others")
        return [remark for remark in remarks if remark]

    def _remark(self, name: str, sighting: Sighting | None, chosen: int, doubtful: bool) -> str:
        if sighting is None:
            if chosen == NO_CANDIDATE:
                return f"the {name} marker is hidden"
            return f"the {name} marker cannot be distinguished from {'another spot' if doubtful else 'its background'}"
        if not sighting.is_whole:
            return f"the {name} marker is partly hidden"
        inside = self._rig.contains(sighting.fix.point)
        return "" if inside else f"the {name} marker is outside the calibrated volume"

    def _residual_px(self, sightings: Sequence[Sighting | None]) -> float:
        residuals = [s.residual_px for s in sightings if s is not None]
        return float(np.sqrt(np.mean(np.square(residuals)))) if residuals else 0.0


class MarkerTracker:
    """Tracks three bright markers against a dark hand (thesis section 5.2, after its reference [2, 3]).

    Every instant is measured on its own; only the assignment uses the last instants and the distances between the
    markers, which are learned at the start. The points are the markers' centres. The elbow is not measured.
    """

    def __init__(self, rig: Rig, config: MarkersConfig | None = None) -> None:
        self._config = config or MarkersConfig()
        self._projections = rig.matrices
        self._finders = tuple(SpotFinder(camera, self._config.min_contrast) for camera in rig.cameras)
        self._meter = MarkerMeter(rig)
        self._quality = Quality(rig)
        self._memory = Memory()
        self._learning = Learning(self._config.initial_pairs)
        self._hand: MarkedHand | None = None
        self._strange = 0
        self._open = False

    def track(self, views: Views) -> ArmEstimate:
        """The markers at the views' instant; a frame that cannot be tracked gives the reason."""
        if len(views.views) != len(self._finders) or len(self._finders) < 2:
            return _lost(views.t_ns, f"{len(views.views)} views for {len(self._finders)} calibrated cameras")
        searched = [finder.spots(view) for finder, view in zip(self._finders, views.views, strict=True)]
        silent = [found for found in searched if isinstance(found, str)]
        spots = [NO_SPOTS if isinstance(found, str) else found for found in searched]
        if len(spots) - len(silent) < 2:
            return _lost(views.t_ns, "; ".join(silent))
        candidates = correspond(self._projections, spots, self._quality.gate_px)
        if not len(candidates):
            return _lost(views.t_ns, TrackingReason.OUT_OF_STEP)
        identity = self._identity(candidates, views.t_ns)
        sightings = [self._sighting(candidates, identity, role, spots) for role in range(len(ROLES))]
        if self._quality.out_of_sync(sightings):
            return _lost(views.t_ns, TrackingReason.OUT_OF_STEP, self._quality.epipolar_px(sightings, spots))
        if not any(sightings):
            return self._no_markers(views.t_ns, len(candidates), spots)
        self._strange = 0
        return self._found(views.t_ns, sightings, [*silent, *self._quality.remarks(sightings, identity, spots)], spots)

    def _identity(self, candidates: Candidates, t_ns: int) -> MarkerIdentity:
        if self._hand is None:
            return first_identity(candidates, self._quality.gate_px)
        return next_identity(candidates, self._hand.spans, self._memory.expected(t_ns), self._quality.gate_px)

    def _sighting(
        self, candidates: Candidates, identity: MarkerIdentity, role: int, spots: Sequence[Spots]
    ) -> Sighting | None:
        which = int(identity.chosen[role])
        if which == NO_CANDIDATE or identity.doubtful[role]:
            return None
        size = None if self._hand is None else float(self._hand.sizes[role])
        sighting = self._meter.measure(candidates, which, spots, size)
        return sighting if np.sqrt(np.linalg.eigvalsh(sighting.fix.covariance)[-1]) <= MAX_SIGMA_M else None

    def _no_markers(self, t_ns: int, candidates: int, spots: Sequence[Spots]) -> ArmEstimate:
        """Bright spots that are not the markers of this hand; after FORGET_AFTER instants another hand is learned."""
        if candidates < len(ROLES) <= min(len(found) for found in spots):
            return _lost(t_ns, TrackingReason.OUT_OF_STEP)
        if self._hand is None:
            self._learning = Learning(self._config.initial_pairs)
            reason = "show wrist, index and thumb marker to all cameras, thumb and index in a U"
            return ArmEstimate(t_ns, TrackingStatus.INITIALISING, reason)
        self._strange = self._strange + 1 if candidates >= len(ROLES) else 0
        if self._strange >= FORGET_AFTER:
            self._hand, self._strange, self._open = None, 0, False
        return _lost(t_ns, "the bright spots do not have the distances of the learned markers")

    def _found(
        self, t_ns: int, sightings: list[Sighting | None], remarks: list[str], spots: Sequence[Spots]
    ) -> ArmEstimate:
        points = _points(sightings)
        self._memory.keep(t_ns, points)
        status, reason = TrackingStatus.DEGRADED if remarks else TrackingStatus.TRACKED, "; ".join(remarks)
        if self._hand is None:
            status, reason = TrackingStatus.INITIALISING, self._learn(points, sightings, reason)
        else:
            whole = _points([s if s is not None and s.is_whole else None for s in sightings])
            self._open = is_open(whole, self._hand.spans, self._config.open_ratio, self._open)
        wrist, index, thumb = (None if s is None else s.fix.point for s in sightings)
        return ArmEstimate(
            t_ns=t_ns,
            status=status,
            reason=reason,
            wrist=wrist,
            index=index,
            thumb=thumb,
            hand_open=self._open,
            overlays=tuple(_overlay(view, k, sightings) for k, view in enumerate(spots)),
            covariances={name: s.fix.covariance for name, s in zip(ROLES, sightings, strict=True) if s is not None},
            residual_px=self._quality.epipolar_px(sightings, spots),
        )

    def _learn(self, points: Array, sightings: Sequence[Sighting | None], doubts: str) -> str:
        """Learn from one instant of a hand that is not known yet; returns the progress as a sentence."""
        if doubts:
            return doubts
        self._hand = self._learning.learn(points, np.array([np.nan if s is None else s.size for s in sightings]))
        wanted = self._config.initial_pairs
        if self._hand is not None:
            self._learning = Learning(wanted)
            return f"learned the markers from {wanted} pairs"
        if self._learning.count < wanted:
            return f"learning the markers: {self._learning.count} of {wanted} pairs"
        return "hold the hand in its U shape, so that the distances of the markers can be learned"


def _lost(t_ns: int, reason: str, residual_px: float | None = None) -> ArmEstimate:
    return ArmEstimate(t_ns, TrackingStatus.LOST, reason, residual_px=residual_px)


def _points(sightings: Sequence[Sighting | None]) -> Array:
    """The markers (3, 3) in m, NaN where there is none."""
    return np.array([np.full(3, np.nan) if s is None else s.fix.point for s in sightings])


def _overlay(spots: Spots, view: int, sightings: Sequence[Sighting | None]) -> Overlay:
    """The spots of one view that were taken for markers."""
    wrist, index, thumb = (
        None if s is None or s.spots[view] == NO_CANDIDATE else spots.in_picture[s.spots[view]] for s in sightings
    )
    return Overlay(wrist=wrist, index=index, thumb=thumb)
