"""Why a tracker doubts or refuses a measurement: one sentence for each reason, with the cure where there is one."""

from collections.abc import Iterable
from enum import StrEnum


class TrackingReason(StrEnum):
    """A reason by name; its value is the sentence for people."""

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
    THUMB_INFERRED = "the thumb is not seen in outline by two cameras; its position follows from the hand's shape"
    LEARNING = "learning the arm: hold it bent, thumb and index apart"


def sentence(reasons: Iterable[str]) -> str:
    """Reasons as one text."""
    return "; ".join(reasons)
