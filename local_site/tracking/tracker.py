"""The trackers' interface: views of one instant in, the operator's arm with status and reason out."""

from collections.abc import Callable, Mapping
from dataclasses import dataclass, field
from enum import StrEnum
from typing import Generic, Protocol, TypeVar

import numpy as np
from numpy.typing import NDArray

from common.cameras.camera import Frame
from common.geometry import Array
from common.messages.hand import TrackingStatus

MAX_PREDICTION_NS = 200_000_000
FRAMES_KEPT = 2

Measured = TypeVar("Measured")


@dataclass(frozen=True, slots=True)
class View:
    """One camera's frames for an instant.

    With `weight` 1 (synchronised cameras, or the camera whose exposure is the instant) only `current` is used;
    otherwise the instant lies between the two exposures and the measurements are interpolated as
    (1 - weight) * previous + weight * current.
    """

    current: Frame
    previous: Frame | None = None
    weight: float = 1.0


@dataclass(frozen=True, slots=True)
class Views:
    """One to n views of the same instant, in the order of the rig's cameras; `t_ns` is their common capture time."""

    t_ns: int
    views: tuple[View, ...]


@dataclass(frozen=True, slots=True)
class Overlay:
    """The findings in one view, for drawing: pixel coordinates, None where absent.

    `contour` is (N, 2); the medial lines are (2, 2) end points; joints and tips are (2,).
    """

    contour: NDArray[np.int32] | None = None
    forearm_line: Array | None = None
    upper_arm_line: Array | None = None
    elbow: Array | None = None
    wrist: Array | None = None
    index: Array | None = None
    thumb: Array | None = None


class TrackingReason(StrEnum):
    """The reasons to doubt or refuse a measurement: a sentence each, with the cure where there is one."""

    NO_ARM = "the lines of the views do not meet in an arm"
    OUT_OF_STEP = "the views do not fit together: out of sync, exchanged, or moved since calibration"
    LEFT_OPEN = "the views do not determine elbow or wrist: bend the arm and hold it across the view"
    NO_UPPER_ARM = "too little of the upper arm is visible to locate the elbow"
    NEARLY_STRAIGHT = "the elbow is nearly straight, so that its position follows from the wrist"
    FOLDED = "the arm is folded, so that forearm and upper arm hide each other"
    FORESHORTENED = "the forearm points at a camera and looks short"
    PARALLEL_TO_BASELINE = "the forearm is nearly parallel to the line between the cameras"
    OUTSIDE_VOLUME = "the wrist is outside the calibrated volume"
    HAND_UNCLEAR = "the outline does not look like a hand held like a gripper, or open"
    OTHER_ARM = (
        "the hand looks like one of the other arm: the pictures are mirrored and exchanged, or right_arm is set wrongly"
    )
    OTHER_BODY = "the arm does not fit the operator's profile and is learned again: hold it bent, thumb and index apart"
    NO_HAND = "no hand is seen: hold it up before all cameras"
    DARK = "the picture is dark: light the arm, take the cap off the camera, or hold the hand up before it"
    HANDS_DIFFER = (
        "a hand is seen, but two views do not agree on it: hold it where all cameras see it; if they do, "
        "the cameras are exchanged, have moved, or are not those of the rig file"
    )
    OTHER_HAND = "only a hand is seen that is not the operator's: hold up yours"
    OTHER_SIDE = "this looks like the other hand, or the pictures are mirrored; see right_arm of the tracker"
    LEARNING_ROOM = "learning the room: keep the arm out of the pictures for a second"
    FIST = "the hand is closed, so that index and thumb hide their tips: open it to turn the tool"
    THUMB_INFERRED = "the thumb is not seen in outline by two cameras; its position follows from the hand's shape"
    LEARNING = "learning the arm: hold it bent, thumb and index apart"


@dataclass(frozen=True, slots=True)
class ArmEstimate:
    """The arm at one instant: points (3,) in the operator frame in m, None where they could not be measured.

    `covariances` (3, 3) in m² are by the name of the point, for every measured point. `hand_open` is this instant's
    observation, not yet debounced: the fingers are stretched. Those of a flat hand may be `fingers_together`, side by
    side, which a tracker that sees no fingers leaves out. `overlays` has an entry for each view. `residual_px` is the
    rms epipolar residual between views in px, None if nothing was compared; it is also given if it is the reason for a
    loss.
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
    fingers_together: bool = False
    overlays: tuple[Overlay, ...] = ()
    covariances: Mapping[str, Array] = field(default_factory=dict)
    residual_px: float | None = None


class Tracker(Protocol):
    """Turns views of successive instants into arm estimates; causal, unsmoothed, never raises on an image."""

    def track(self, views: Views) -> ArmEstimate: ...


class FrameCache(Generic[Measured]):
    """Measures each frame of one camera once, and interpolates between two exposures."""

    def __init__(self, blend: Callable[[Measured, Measured, float], Measured]) -> None:
        """`blend` interpolates two measurements by the weight of the second."""
        self._blend = blend
        self._known: dict[tuple[int, int], Measured | str] = {}

    def at(self, view: View, measure: Callable[[Frame], Measured | str]) -> Measured | str:
        """The measurement at the view's instant, or a sentence with the reason why there is none."""
        now = self._once(view.current, measure)
        frames = (view.current,) if view.previous is None else (view.current, view.previous)
        before = now
        if view.previous is not None and view.weight < 1.0 and not isinstance(now, str):
            before = self._once(view.previous, measure)
        # What this instant and the last one used is all that the next may ask for.
        asked = [key for key in map(_key, frames) if key in self._known]
        others = [key for key in self._known if key not in asked]
        self._known = {key: self._known[key] for key in [*others, *reversed(asked)][-FRAMES_KEPT:]}
        if isinstance(now, str) or isinstance(before, str):
            return now if isinstance(now, str) else before
        return now if view.previous is None or view.weight >= 1.0 else self._blend(before, now, view.weight)

    def _once(self, frame: Frame, measure: Callable[[Frame], Measured | str]) -> Measured | str:
        known = self._known.get(_key(frame))
        if known is None:
            known = self._known[_key(frame)] = measure(frame)
        return known


def _key(frame: Frame) -> tuple[int, int]:
    return frame.seq, frame.capture_ns


def extrapolation(t_ns: int, last_ns: int, before_ns: int) -> float:
    """Time since the last instant in units of the interval before it; 0 if either exceeds MAX_PREDICTION_NS."""
    ahead, interval = t_ns - last_ns, last_ns - before_ns
    return ahead / interval if 0 < ahead <= MAX_PREDICTION_NS and 0 < interval <= MAX_PREDICTION_NS else 0.0
