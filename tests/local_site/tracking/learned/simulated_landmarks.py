"""The landmarks of the rendered arm's hand, as a faultless network would see them, and a tracker that is shown them."""

from collections.abc import Sequence as Several
from dataclasses import dataclass
from functools import cache

import numpy as np
import pytest

from common.geometry import Array
from local_site.calibration.rig import Rig
from local_site.simulation.config import BodyConfig, MotionConfig
from local_site.simulation.hand import U_SHAPE, FingerPosture, Hand
from local_site.simulation.motion import Motion
from local_site.tracking.config import LearnedConfig
from local_site.tracking.landmarks.hand_pairing import HandPairing, SeenHand
from local_site.tracking.learned import learned_tracker
from local_site.tracking.learned.learned_tracker import LearnedTracker
from local_site.tracking.silhouette.hand_model.landmark_equations import CREASE
from local_site.tracking.silhouette.operator_profile import OperatorProfile
from local_site.tracking.tracker import ArmEstimate, Views
from tests.local_site.tracking.landmarks.scripted_hands import ScriptedHands, scripted_views, show
from tests.local_site.tracking.landmarks.seen_hands import seen_by_all
from tests.local_site.tracking.rendered_arm import MOVING, Sequence, rig_of

JOINTS = 20
MIDDLE_KNUCKLE = 4


def simulated_landmarks(
    sequence: Sequence, k: int, motion: MotionConfig = MOVING, rest: FingerPosture = U_SHAPE
) -> Array:
    """The landmarks (21, 3) in m of the average simulated hand at the k-th instant, held as at `rest` while closed."""
    body = BodyConfig()
    pose = _course(motion).pose(sequence.times_s[k])
    joints = Hand(body.hand_scale, rest).balls(pose.openness)[:JOINTS]
    fingers, thumb = joints[: JOINTS - 4], joints[JOINTS - 4 :]
    local = np.vstack([CREASE * fingers[MIDDLE_KNUCKLE], thumb, fingers])
    landmarks: Array = pose.wrist + local @ pose.operator_R_hand.T
    return landmarks


@cache
def _course(motion: MotionConfig) -> Motion:
    """Where the average arm is at each time, which it does not remember."""
    return Motion(motion, BodyConfig(), 1)


def seen_hand(rig: Rig, landmarks: Array) -> SeenHand:
    """The hand of which all views show these landmarks (21, 3) in m."""
    seen = HandPairing(rig).meet(dict(enumerate(seen_by_all(rig, landmarks))))
    assert seen is not None
    return seen


@dataclass(frozen=True)
class ShownTracker:
    """A tracker, and the views that show it hands."""

    tracker: LearnedTracker
    views: Several[ScriptedHands]
    rig: Rig

    def track(self, views: Views, *landmarks: Array, right: float = 0.95) -> ArmEstimate:
        """The estimate of pictures in which every view sees these hands, each (21, 3) in m."""
        show(self.views, *[seen_by_all(self.rig, hand, right) for hand in landmarks])
        return self.tracker.track(views)


def shown_tracker(
    patch: pytest.MonkeyPatch,
    projections: Several[Array],
    config: LearnedConfig | None = None,
    profile: OperatorProfile | None = None,
) -> ShownTracker:
    """A tracker whose networks are replaced by what the test shows."""
    rig = rig_of(projections)
    views = scripted_views(rig, config is None or config.right_arm)
    patch.setattr(learned_tracker, "view_hands", lambda *_: views)
    return ShownTracker(LearnedTracker(rig, config, profile), views, rig)
