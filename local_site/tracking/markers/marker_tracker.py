"""The marker tracker: three bright markers on wrist, index and thumb in two to four views to their positions."""

from collections.abc import Sequence

import numpy as np

from common.geometry import Array
from common.messages.hand import TrackingStatus
from local_site.calibration.rig import Rig
from local_site.tracking.config import MarkersConfig
from local_site.tracking.markers.correspondence import Candidates, correspond
from local_site.tracking.markers.identity import NO_CANDIDATE, ROLES, MarkerIdentity, first_identity, next_identity
from local_site.tracking.markers.learned import Learning, MarkedHand, Memory, is_open
from local_site.tracking.markers.measuring import MarkerMeter, Sighting
from local_site.tracking.markers.quality import OUT_OF_SYNC, Quality
from local_site.tracking.markers.spots import NO_SPOTS, SpotFinder, Spots
from local_site.tracking.tracker import ArmEstimate, Overlay, Views

FORGET_AFTER = 60


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
            return _lost(views.t_ns, OUT_OF_SYNC)
        identity = self._identity(candidates, views.t_ns)
        sightings = [self._sighting(candidates, identity, role, spots) for role in range(len(ROLES))]
        if self._quality.out_of_sync(sightings):
            return _lost(views.t_ns, OUT_OF_SYNC, self._quality.epipolar_px(sightings, spots))
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
        return sighting if self._quality.is_sure(sighting) else None

    def _no_markers(self, t_ns: int, candidates: int, spots: Sequence[Spots]) -> ArmEstimate:
        """Bright spots that are not the markers of this hand; after FORGET_AFTER instants another hand is learned."""
        if candidates < len(ROLES) <= min(len(found) for found in spots):
            return _lost(t_ns, OUT_OF_SYNC)
        if self._hand is None:
            self._learning.forget()
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
        self._learning.add(points, np.array([np.nan if s is None else s.size for s in sightings]))
        self._hand = self._learning.hand()
        wanted = self._config.initial_pairs
        if self._hand is not None:
            self._learning.forget()
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
