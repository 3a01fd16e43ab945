"""An operator's body as kept between runs: the hand's sizes and habits, the forearm's length."""

import math
from typing import Annotated

import msgspec
import numpy as np
from msgspec import Meta

from common.geometry import Array
from local_site.tracking.silhouette.hand_model.habits import Belief
from local_site.tracking.silhouette.hand_model.skeleton import PALM, PARAMETERS

OTHER_BODY_SHARE = 0.08
MOST_PAIRS = 100  # so that a body that grows is followed
MAX_ANGLE, MAX_LOG_SIZE = 2.5, 0.7

Row = Annotated[tuple[float, ...], Meta(min_length=PARAMETERS, max_length=PARAMETERS)]


class OperatorProfile(msgspec.Struct, frozen=True, kw_only=True, forbid_unknown_fields=True):
    """An operator's hand and forearm: `scale` against the average hand, how a gripper is held (10,) with the
    information (10, 10) about it, the forearm's length in m, and from how many pairs of images that is."""

    scale: Annotated[float, Meta(ge=0.4, le=2.0)]
    posture: Row
    information: Annotated[tuple[Row, ...], Meta(min_length=PARAMETERS, max_length=PARAMETERS)]
    forearm_length_m: Annotated[float, Meta(ge=0.1, le=0.5)]
    pairs: Annotated[int, Meta(ge=1, le=MOST_PAIRS)]

    @property
    def habits(self) -> Belief:
        """How the hand is held, with its information."""
        return Belief(np.array(self.posture), np.array(self.information))

    def is_of(self, forearm_length_m: float) -> bool:
        """Whether a newly measured forearm can be the same operator's."""
        return abs(forearm_length_m / self.forearm_length_m - 1) < OTHER_BODY_SHARE

    def length_with(self, forearm_length_m: float, pairs: int) -> float:
        """The forearm's length in m, from all runs and from as many pairs now."""
        total = self.forearm_length_m * self.pairs + forearm_length_m * pairs
        return total / (self.pairs + pairs)


def make_profile(scale: float, habits: Belief, forearm_length_m: float, pairs: int) -> OperatorProfile:
    """The profile of what has been learned."""
    return OperatorProfile(
        scale=scale,
        posture=_row(habits.posture),
        information=tuple(_row(row) for row in habits.information),
        forearm_length_m=forearm_length_m,
        pairs=min(pairs, MOST_PAIRS),
    )


def profile_mistakes(profile: OperatorProfile) -> list[str]:
    """What is wrong with a profile; msgspec has checked types, lengths and sizes."""
    mistakes = []
    angles, sizes = profile.posture[:PALM], profile.posture[PALM:]
    if not all(abs(angle) < MAX_ANGLE for angle in angles) or not all(abs(size) < MAX_LOG_SIZE for size in sizes):
        mistakes.append("posture is not that of a hand")
    information = np.array(profile.information)
    if not np.isfinite(information).all() or not np.allclose(information, information.T):
        mistakes.append("information is not symmetric, or not finite")
    elif not math.isfinite(float(np.sum(information))) or np.linalg.eigvalsh(information)[0] <= 0:
        mistakes.append("information is not positive")
    return mistakes


def _row(values: Array) -> tuple[float, ...]:
    return tuple(float(value) for value in values)
