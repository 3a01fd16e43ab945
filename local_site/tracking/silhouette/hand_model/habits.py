"""Priors of the hand's posture: of any hand before it is known, and of the operator's as learned during tracking."""

from dataclasses import dataclass

import numpy as np

from common.geometry import Array
from local_site.tracking.silhouette.hand_model.fit import HandFit, Prior
from local_site.tracking.silhouette.hand_model.skeleton import (
    GAP_BY_SPREAD,
    MCP_CURL,
    PARAMETERS,
    PIP_CURL,
    POSE,
    SPREAD,
    STATE,
    TIP_RADIUS,
    TYPICAL_FOREARM,
    HandPose,
    Person,
)

GRIPPER = np.array([0.6, 0.4, 0.1, 0.03, 0.85, 0.57, -0.1, 0.0, 0.0, 0.0])
GRIPPER_SIGMA = np.array([0.35, 0.35, 0.1, 0.08, 0.3, 0.3, 0.25, 0.08, 0.10, 0.12])
HABIT_SIGMA = np.array([0.08, 0.08, 0.03, 0.03, 0.08, 0.08, 0.08, 0.004, 0.004, 0.004])
OPEN = np.array([0.03, 0.1, 0.0, 0.25, 1.0, 0.0, 0.0])
OPEN_SIGMA = np.array([0.2, 0.2, 0.05, 0.15, 0.25, 0.25, 0.2, 0.02, 0.02, 0.02])
STEP_SIGMA = np.array([0.06, 0.06, 0.02, 0.03, 0.05, 0.05, 0.05, 0.004, 0.004, 0.004])
TURN_SIGMA = 0.5
OPEN_CURL, STILL_OPEN_CURL, CLOSED_CURL = 0.6, 0.75, 0.85  # fractions of the usual curl
# A gap between the tips of half a finger's width, which is three pixels where a pixel is 2 mm of the hand.
APART = TIP_RADIUS / GAP_BY_SPREAD
STILL_APART = 0.5 * APART
FRAME_WEIGHT = 0.15
MEMORY = 0.998


@dataclass(frozen=True, slots=True)
class Belief:
    """A posture (10,) and the information (10, 10) about it."""

    posture: Array
    information: Array


@dataclass(frozen=True, slots=True)
class LimbEvidence:
    """The hand as the limbs show it: wrist (3,) in m with covariance (3, 3), elbow (3,), far end of the hand (3,)."""

    wrist: Array
    wrist_covariance: Array
    elbow: Array
    far_end: Array

    def person(self, right_arm: bool, scale: float | None = None) -> Person:
        """The person of this arm; without a known `scale` the forearm's length gives it."""
        to_elbow = self.elbow - self.wrist
        length = max(float(np.linalg.norm(to_elbow)), 1e-6)
        return Person(length / TYPICAL_FOREARM if scale is None else scale, right_arm, to_elbow / length)

    def prior(self, belief: Belief, near: HandPose | None = None) -> Prior:
        """The prior of a hand on this arm; with a pose `near` it also constrains the rotation."""
        information = prior_information(self.wrist_covariance, belief.information, turn_known=near is not None)
        return Prior(self.wrist, np.eye(3) if near is None else near.rotation, belief.posture, information)


class Habits:
    """The operator's way to hold the hand as a gripper, and its sizes: at first those of an average hand, then more and
    more the operator's own, as motion shows the hand from all sides."""

    def __init__(self, own: Belief | None = None) -> None:
        """`own` was learned in an earlier run."""
        self.own = own or Belief(GRIPPER, np.diag(1 / GRIPPER_SIGMA**2))
        self.learned = 0

    @property
    def closed(self) -> Belief:
        """The hand held like a gripper."""
        spread = np.linalg.inv(self.own.information) + np.diag(HABIT_SIGMA**2)
        return Belief(self.own.posture, np.linalg.inv(spread).astype(np.float64))

    @property
    def opened(self) -> Belief:
        """The hand with its fingers stretched and spread."""
        posture = self.own.posture.copy()
        posture[: len(OPEN)] = OPEN
        return Belief(posture, np.diag(1 / OPEN_SIGMA**2))

    def learn(self, seen: Array, prior: Belief, information: Array) -> None:
        """Learn a fitted posture (10,), given the prior of its fit and the outlines' information (10, 10).

        The prior is removed from the fit, and a frame is weighted down: the errors of neighbouring frames correlate.
        """
        alone = (prior.information + information) @ (seen - prior.posture)
        alone += information @ (prior.posture - self.own.posture)
        damped = np.linalg.inv(np.eye(PARAMETERS) + information @ np.diag(HABIT_SIGMA**2))
        total = MEMORY * self.own.information + FRAME_WEIGHT * damped @ information
        total = 0.5 * (total + total.T)
        self.own = Belief(self.own.posture + np.linalg.solve(total, FRAME_WEIGHT * damped @ alone), total)
        self.learned += 1

    def learn_fit(self, fit: HandFit) -> None:
        """Learn the posture of a fit, with all the information of its outlines."""
        prior = fit.prior
        shown = fit.information - prior.information
        shown[:3, :3] += prior.information[:3, :3]
        belief = Belief(prior.posture, prior.information[POSE:, POSE:])
        self.learn(fit.pose.posture, belief, posture_information(shown))

    def is_open(self, posture: Array, was_open: bool = False) -> bool:
        """Return whether the fingers are stretched well beyond their usual curl (thesis 4.2).

        A hand that was open stays open until the fingers are nearly curled as usual (hysteresis).
        """
        return self._curl(posture) < (STILL_OPEN_CURL if was_open else OPEN_CURL)

    def are_apart(self, posture: Array, were_apart: bool = False) -> bool:
        """Return whether all fingers are seen apart, as an opening hand has to show them (thesis 4.2).

        They lie side by side in the usual hold, a U like a gripper's jaws; of an operator who fans them there, as in an
        average one. From there they have to part until the background shows between each two tips. Fingers that were
        apart stay so until that gap is half closed.
        """
        together = min(float(self.own.posture[SPREAD]), float(GRIPPER[SPREAD]))
        return float(posture[SPREAD]) - together > (STILL_APART if were_apart else APART)

    def is_closed(self, posture: Array) -> bool:
        """Return whether the fingers are curled as usual."""
        return self._curl(posture) > CLOSED_CURL

    def _curl(self, posture: Array) -> float:
        """The curl of the fingers relative to the usual one."""
        usual = float(self.own.posture[MCP_CURL] + self.own.posture[PIP_CURL])
        return float(posture[MCP_CURL] + posture[PIP_CURL]) / max(usual, 1e-3)


def near_last(belief: Belief, last: Array) -> Belief:
    """A belief that includes the last posture (10,), from which a hand changes little in a frame."""
    near = np.diag(1 / STEP_SIGMA**2)
    information = belief.information + near
    mean = np.linalg.solve(information, belief.information @ belief.posture + near @ last)
    return Belief(mean.astype(np.float64), information)


def prior_information(wrist_covariance: Array, posture_information: Array, turn_known: bool) -> Array:
    """The information matrix (16, 16) of a prior, from the wrist's covariance (3, 3) in m² and a posture's."""
    information = np.zeros((STATE, STATE))
    information[:3, :3] = np.linalg.inv(wrist_covariance)
    if turn_known:
        information[(3, 4, 5), (3, 4, 5)] = 1 / TURN_SIGMA**2
    information[POSE:, POSE:] = posture_information
    return information


def posture_information(information: Array) -> Array:
    """The information (10, 10) about the posture with the pose marginalised out of (16, 16): a Schur complement."""
    cross = information[:POSE, POSE:]
    result: Array = information[POSE:, POSE:] - cross.T @ np.linalg.solve(information[:POSE, :POSE], cross)
    return result
