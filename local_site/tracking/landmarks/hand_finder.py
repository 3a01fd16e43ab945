"""Finds the operator's hand in all views at once, and follows it: one of the right side that the views agree on."""

from collections.abc import Callable, Sequence

import numpy as np

from local_site.calibration.rig import Rig
from local_site.tracking.landmarks.hand_landmarks import HandLandmarks
from local_site.tracking.landmarks.hand_pairing import HandPairing, SeenHand
from local_site.tracking.landmarks.view_hands import TURNED_RIGHT, ViewHands
from local_site.tracking.tracker import TrackingReason, Views, extrapolation

FOLLOWED_MISFIT = 0.12  # of a hand that a view is not sure of
SURE_SCORE = 0.5
MOST_RETRIES = 2  # crops run again in one instant
MOST_JUMP_M = 0.12  # beyond the expected place within one instant: nobody moves like that

Accept = Callable[[SeenHand], bool]


class HandFinder:
    """Follows one hand through the views."""

    def __init__(self, rig: Rig, views: Sequence[ViewHands]) -> None:
        self._views, self._pairing = tuple(views), HandPairing(rig)
        self._last: tuple[int, SeenHand] | None = None
        self._before: tuple[int, SeenHand] | None = None
        self._attempts = 0

    def find(self, views: Views, accept: Accept, *, quickly: bool) -> SeenHand | str:
        """The hand at the views' instant, or a sentence why there is none.

        A hand that is new must be one that `accept` takes for the operator's. Outlines make up for less exact landmarks
        that are found `quickly`.
        """
        candidates = [self._views[k].hands(view, quickly=quickly) for k, view in enumerate(views.views)]
        found = [seen for seen in self._pairing.pairs(candidates) if _is_sure(seen)]
        if not found:
            self.forget()
            return TrackingReason.NO_HAND if not any(candidates) else TrackingReason.HANDS_DIFFER
        fitting = [seen for seen in found if (self._is_near(views.t_ns, seen) if self._last else accept(seen))]
        if not fitting:
            self.forget()
            return TrackingReason.OTHER_HAND
        seen = self._seen_rightly(views, fitting[0])
        for k, hand in seen.views.items():
            self._views[k].keep(hand)
        self._before, self._last = self._last, (views.t_ns, seen)
        return seen

    def forget(self) -> None:
        """Search everywhere from now on."""
        self._last = self._before = None
        for view in self._views:
            view.lose()

    def _is_near(self, t_ns: int, seen: SeenHand) -> bool:
        """Whether it is where the last instants let expect it; true without any."""
        if self._last is None or self._before is None:
            return True
        (last_ns, last), (before_ns, before) = self._last, self._before
        ahead = extrapolation(t_ns, last_ns, before_ns)
        expected = last.palm + ahead * (last.palm - before.palm)
        return float(np.linalg.norm(seen.palm - expected)) < MOST_JUMP_M * max(1.0, ahead)

    def _seen_rightly(self, views: Views, seen: SeenHand) -> SeenHand:
        """The hand with those views run again in other crops that take it for its mirror image."""
        hands = dict(seen.views)
        for k in list(hands)[:MOST_RETRIES]:
            if self._views[k].side(hands[k]) < TURNED_RIGHT and views.views[k].weight >= 1.0:
                hands[k] = self._views[k].again(views.views[k], hands[k], self._attempts)
                self._attempts += 1
        return self._pairing.meet(hands) or seen


def _is_sure(seen: SeenHand) -> bool:
    """A hand that a view is not sure of must fit all the better."""
    return seen.score >= SURE_SCORE or seen.misfit <= FOLLOWED_MISFIT
