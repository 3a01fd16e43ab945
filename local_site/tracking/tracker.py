"""What a tracker is: views of one instant in, the operator's arm with status and reason out."""

from collections.abc import Mapping
from dataclasses import dataclass, field
from typing import Protocol

import numpy as np
from numpy.typing import NDArray

from common.cameras.camera import Frame
from common.geometry import Array
from common.messages.hand import TrackingStatus


@dataclass(frozen=True, slots=True)
class View:
    """What one camera contributes to an instant.

    With `weight` 1 (synchronised cameras, or the camera whose exposure is the instant) `current` alone counts;
    otherwise the instant lies between the two exposures and the measurements are
    (1 - weight) * previous + weight * current.
    """

    current: Frame
    previous: Frame | None = None
    weight: float = 1.0


@dataclass(frozen=True, slots=True)
class Views:
    """One to n views of the same instant, in the order of the rig's cameras; `t_ns` is the common exposure time."""

    t_ns: int
    views: tuple[View, ...]


@dataclass(frozen=True, slots=True)
class Overlay:
    """What was seen in one view, for drawing: pixel coordinates, None where absent.

    `contour` is (N, 2); the medial lines are (2, 2) end points; joints and tips are (2,).
    """

    contour: NDArray[np.int32] | None = None
    forearm_line: Array | None = None
    upper_arm_line: Array | None = None
    elbow: Array | None = None
    wrist: Array | None = None
    index: Array | None = None
    thumb: Array | None = None


@dataclass(frozen=True, slots=True)
class ArmEstimate:
    """The arm at one instant: points (3,) in the operator frame in m, None where they could not be measured.

    `covariances` (3, 3) in m² are by the name of the point, for every point that is there. `hand_open` is this
    instant's observation, not yet debounced. `overlays` has an entry for each view. `residual_px` is the rms epipolar
    residual of what both views show, px, None where nothing was compared; also given where it made the arm refused.
    """

    t_ns: int
    status: TrackingStatus
    reason: str
    elbow: Array | None = None
    wrist: Array | None = None
    index: Array | None = None
    thumb: Array | None = None
    palm: Array | None = None
    thumb_inferred: bool = False
    hand_open: bool = False
    overlays: tuple[Overlay, ...] = ()
    covariances: Mapping[str, Array] = field(default_factory=dict)
    residual_px: float | None = None


class Tracker(Protocol):
    """Turns views of successive instants into arm estimates; causal, unsmoothed, never raises on an image."""

    def track(self, views: Views) -> ArmEstimate: ...
