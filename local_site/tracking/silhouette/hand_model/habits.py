"""What hands look like before a particular one is known, and what is learned of the operator's while it is tracked."""

from dataclasses import dataclass

import numpy as np

from common.geometry import Array
from local_site.tracking.silhouette.hand_model.placement import POSE, STATE
from local_site.tracking.silhouette.hand_model.skeleton import MCP_CURL, PARAMETERS, PIP_CURL

GRIPPER = np.array([0.6, 0.4, 0.1, 0.03, 0.85, 0.57, -0.1, 0.0, 0.0, 0.0])
GRIPPER_SIGMA = np.array([0.35, 0.35, 0.1, 0.08, 0.3, 0.3, 0.25, 0.08, 0.10, 0.12])
HABIT_SIGMA = np.array([0.08, 0.08, 0.03, 0.03, 0.08, 0.08, 0.08, 0.004, 0.004, 0.004])
OPEN = np.array([0.03, 0.1, 0.0, 0.25, 1.0, 0.0, 0.0])
OPEN_SIGMA = np.array([0.2, 0.2, 0.05, 0.15, 0.25, 0.25, 0.2, 0.02, 0.02, 0.02])
STEP_SIGMA = np.array([0.06, 0.06, 0.02, 0.03, 0.05, 0.05, 0.05, 0.004, 0.004, 0.004])
TURN_SIGMA = 0.5
OPEN_SHARE, STILL_OPEN_SHARE, CLOSED_SHARE = 0.6, 0.75, 0.85
FRAME_SHARE = 0.15
MEMORY = 0.998


@dataclass(frozen=True, slots=True)
class Belief:
    """A posture (10,) and the information (10, 10) about it."""

    posture: Array
    information: Array


class Habits:
    """How the operator holds the hand as a gripper, and its sizes: at first an average hand's, then more and more the
    operator's own, as motion shows it from all sides."""

    def __init__(self, own: Belief | None = None) -> None:
        """`own` is what an earlier run has learned."""
        own = own or Belief(GRIPPER, np.diag(1 / GRIPPER_SIGMA**2))
        self._mean = own.posture.copy()
        self._information = own.information.copy()
        self.learned = 0

    @property
    def own(self) -> Belief:
        """How this operator usually holds the hand, as far as it is known."""
        return Belief(self._mean, self._information)

    @property
    def closed(self) -> Belief:
        """The hand held like a gripper."""
        spread = np.linalg.inv(self._information) + np.diag(HABIT_SIGMA**2)
        return Belief(self._mean, np.linalg.inv(spread).astype(np.float64))

    @property
    def opened(self) -> Belief:
        """The hand with its fingers stretched and spread."""
        posture = self._mean.copy()
        posture[: len(OPEN)] = OPEN
        return Belief(posture, np.diag(1 / OPEN_SIGMA**2))

    def learn(self, seen: Array, prior: Belief, information: Array) -> None:
        """Take in a fitted posture (10,), with the prior it was fitted under and what the outlines told (10, 10).

        The fit is undone of its prior, and a frame counts by a share only: neighbouring frames err alike.
        """
        alone = (prior.information + information) @ (seen - prior.posture)
        alone += information @ (prior.posture - self._mean)
        damped = np.linalg.inv(np.eye(PARAMETERS) + information @ np.diag(HABIT_SIGMA**2))
        self._information = MEMORY * self._information + FRAME_SHARE * damped @ information
        self._information = 0.5 * (self._information + self._information.T)
        self._mean = self._mean + np.linalg.solve(self._information, FRAME_SHARE * damped @ alone)
        self.learned += 1

    def is_open(self, posture: Array, was_open: bool = False) -> bool:
        """Whether the fingers are stretched well beyond their usual curl (thesis 4.2).

        A hand that was open stays so until the fingers are nearly curled as usual, lest it opens twice in one move.
        """
        return self._curl_share(posture) < (STILL_OPEN_SHARE if was_open else OPEN_SHARE)

    def is_closed(self, posture: Array) -> bool:
        """Whether the fingers are curled as usual."""
        return self._curl_share(posture) > CLOSED_SHARE

    def _curl_share(self, posture: Array) -> float:
        usual = float(self._mean[MCP_CURL] + self._mean[PIP_CURL])
        return float(posture[MCP_CURL] + posture[PIP_CURL]) / max(usual, 1e-3)


def near_last(belief: Belief, last: Array) -> Belief:
    """A belief that also knows the last posture (10,), from which a hand changes little in a frame."""
    near = np.diag(1 / STEP_SIGMA**2)
    information = belief.information + near
    mean = np.linalg.solve(information, belief.information @ belief.posture + near @ last)
    return Belief(mean.astype(np.float64), information)


def prior_information(wrist_covariance: Array, posture_information: Array, turn_known: bool) -> Array:
    """The information matrix (16, 16) of a prior."""
    information = np.zeros((STATE, STATE))
    information[:3, :3] = np.linalg.inv(wrist_covariance)
    if turn_known:
        information[(3, 4, 5), (3, 4, 5)] = 1 / TURN_SIGMA**2
    information[POSE:, POSE:] = posture_information
    return information


def posture_information(information: Array) -> Array:
    """What an information matrix (16, 16) says of the posture alone (10, 10), whatever the pose."""
    cross = information[:POSE, POSE:]
    result: Array = information[POSE:, POSE:] - cross.T @ np.linalg.solve(information[:POSE, :POSE], cross)
    return result
