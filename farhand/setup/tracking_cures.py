"""What a person can do about the reasons that a tracker gives."""

import re
from collections.abc import Mapping

from local_site.tracking.tracker import TrackingReason

COUNTS = re.compile(r" \([^)]*\d[^)]*\)")

CURES: Mapping[TrackingReason, str] = {
    TrackingReason.NO_ARM: "let one arm alone be in both pictures, and nothing else that is bright",
    TrackingReason.OUT_OF_STEP: "calibrate again if a camera was touched; check that left is left",
    TrackingReason.LEFT_OPEN: "hold the forearm across the views, the elbow at a right angle",
    TrackingReason.NO_UPPER_ARM: "roll the sleeve up above the elbow, and let both cameras see some of the upper arm",
    TrackingReason.NEARLY_STRAIGHT: "bend the elbow",
    TrackingReason.FOLDED: "open the elbow to about a right angle",
    TrackingReason.FORESHORTENED: "turn so that the forearm lies across the views, or place the cameras otherwise",
    TrackingReason.PARALLEL_TO_BASELINE: "point the forearm away from the cameras, or raise one of them",
    TrackingReason.OUTSIDE_VOLUME: "work where the board was shown, or calibrate again with the board shown there",
    TrackingReason.HAND_UNCLEAR: "hold thumb and index apart, the other fingers closed, the hand across the views",
    TrackingReason.OTHER_ARM: "answer which arm is tracked again; check that left is left and no picture is mirrored",
    TrackingReason.OTHER_SIDE: "answer which arm is tracked again; check that left is left and no picture is mirrored",
    TrackingReason.THUMB_INFERRED: "turn the hand so that both cameras see the thumb",
}
OTHERWISE = "let the bent arm alone be seen by both cameras, well lit, before something dark and plain"


def without_counts(reason: str) -> str:
    """A reason without the numbers in brackets, so that the same reasons count as one."""
    return COUNTS.sub("", reason)


def cure_of(reason: str) -> str:
    """What to do about a reason; empty where its own sentence says it, after a colon."""
    known = next((cure for which, cure in CURES.items() if which in reason), None)
    if known is not None:
        return known
    return "" if ": " in reason else OTHERWISE
