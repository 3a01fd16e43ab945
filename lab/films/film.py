"""A film: a calibrated rig, and instants with colour pictures and the truth."""

from collections.abc import Callable, Iterator
from dataclasses import dataclass

from common.geometry import Array
from local_site.calibration.rig import Rig
from local_site.simulation.body import ArmTruth
from local_site.tracking.tracker import Views


@dataclass(frozen=True, slots=True)
class HandTruth:
    """The arm of one instant: its points, the hand's frame, which hand it is, and the posture by name.

    `operator_R_hand` (3, 3) has its columns along the hand: x distal, z dorsal, y = z cross x, which is the thumb's
    side of a right hand and the other side of a left one; None where it is not known.
    """

    arm: ArmTruth
    operator_R_hand: Array | None
    right: bool
    posture: str


@dataclass(frozen=True, slots=True)
class FilmInstant:
    """The pictures (H, W, 3) BGR of one instant, and what they show; None while the operator's arm is absent."""

    views: Views
    truth: HandTruth | None


@dataclass(frozen=True, slots=True)
class TrackingFilm:
    """A run of instants before a calibrated rig; every call of `instants` starts again."""

    name: str
    rig: Rig
    fps: float
    instants: Callable[[], Iterator[FilmInstant]]
