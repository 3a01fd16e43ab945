"""When to doubt or refuse the measured markers."""

import math
from collections.abc import Sequence

import numpy as np

from common.geometry import Array
from local_site.calibration.rig import Rig
from local_site.calibration.triangulation import epipolar_residuals, fundamentals
from local_site.tracking.markers.identity import NO_CANDIDATE, ROLES, MarkerIdentity
from local_site.tracking.markers.measuring import Sighting
from local_site.tracking.markers.spots import Spots

LEAST_RESIDUAL_PX = 0.3
GATE = 10.0
REFUSED = 6.0
DOUBTED = 2.5
MAX_SIGMA_M = 0.015
OUT_OF_SYNC = "the views do not fit together: they are out of sync, or a camera has moved since calibration"


class Quality:
    """Judges by the residuals usual for this rig, and by its calibrated volume."""

    def __init__(self, rig: Rig) -> None:
        self._rig = rig
        usual = float(np.mean([camera.reprojection_rms_px for camera in rig.cameras]))
        self._of_pairs = fundamentals(rig.matrices)
        self._usual_px = float(np.hypot(LEAST_RESIDUAL_PX, usual))

    @property
    def gate_px(self) -> float:
        """The largest reprojection error in px at which spots are taken for one marker."""
        return GATE * self._usual_px

    def is_sure(self, sighting: Sighting) -> bool:
        """Whether a marker's position is certain enough to be reported."""
        return sighting.sigma_m <= MAX_SIGMA_M

    def out_of_sync(self, sightings: Sequence[Sighting | None]) -> bool:
        """Whether the reprojection errors are too large for one instant and one calibration."""
        return self._residual_px(sightings) > REFUSED * self._usual_px

    def epipolar_px(self, sightings: Sequence[Sighting | None], spots: Sequence[Spots]) -> float | None:
        """The rms distance of the markers' spots from each other's epipolar lines, px; None without a marker."""
        seen = [_pixels(sighting, spots) for sighting in sightings if sighting is not None]
        if not seen:
            return None
        return math.sqrt(float(np.nanmean(np.square(epipolar_residuals(self._of_pairs, np.array(seen))))))

    def remarks(
        self, sightings: Sequence[Sighting | None], identity: MarkerIdentity, spots: Sequence[Spots]
    ) -> list[str]:
        """Why a result is less certain than usual, or incomplete, a sentence each."""
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


def _pixels(sighting: Sighting, spots: Sequence[Spots]) -> Array:
    """Where each view shows a marker (V, 2), NaN where it does not."""
    unseen = np.full(2, np.nan)
    return np.array(
        [unseen if k == NO_CANDIDATE else view.pixels[k] for k, view in zip(sighting.spots, spots, strict=True)]
    )
