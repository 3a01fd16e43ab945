"""Which arm a hand belongs to: in exchanged and mirrored pictures a right arm looks like a left one."""

from collections.abc import Sequence
from dataclasses import replace

import numpy as np

from common.geometry import Array
from local_site.tracking.silhouette.hand_model.fit import HandView, Prior
from local_site.tracking.silhouette.hand_model.habits import Habits, prior_information
from local_site.tracking.silhouette.hand_model.placement import Person
from local_site.tracking.silhouette.hand_model.search import Effort, search_hand
from local_site.tracking.silhouette.hand_model.skeleton import TYPICAL_FOREARM
from local_site.tracking.silhouette.hand_tracker import LimbEvidence

EFFORT = Effort(rolls=12, kept=4)
CLEARLY = 1.2


def looks_like_the_other_arm(views: Sequence[HandView], arm: LimbEvidence, right_arm: bool) -> bool:
    """Whether an average hand of the other arm explains the outlines clearly better than one of this arm.

    Both are searched for with the same effort. Thumb and index alone lie alike on both arms: it is the curled
    fingers on the palm's side that tell.
    """
    to_elbow = arm.elbow - arm.wrist
    length = max(float(np.linalg.norm(to_elbow)), 1e-6)
    own = Person(length / TYPICAL_FOREARM, right_arm, to_elbow / length)
    return _cost(views, arm, own) > CLEARLY * _cost(views, arm, replace(own, right_arm=not right_arm))


def _cost(views: Sequence[HandView], arm: LimbEvidence, person: Person) -> float:
    """What a hand of this person leaves unexplained."""
    usual = Habits().closed
    information: Array = prior_information(arm.wrist_covariance, usual.information, turn_known=False)
    return search_hand(views, arm.far_end, Prior(arm.wrist, usual.posture, information, None), person, EFFORT).cost
