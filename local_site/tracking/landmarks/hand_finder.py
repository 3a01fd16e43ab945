"""Finds the operator's hand in all views at once, and follows it: a hand that the views agree on, the least doubted."""

import math
from collections.abc import Callable, Sequence

import numpy as np

from common.clock import NS_PER_MS, NS_PER_S
from local_site.calibration.rig import Rig
from local_site.tracking.landmarks.hand_landmarks import HandLandmarks
from local_site.tracking.landmarks.hand_pairing import HandPairing, SeenHand
from local_site.tracking.landmarks.still_hands import StillHands
from local_site.tracking.landmarks.view_hands import TURNED_RIGHT, Motion, ViewHands
from local_site.tracking.tracker import TrackingReason, Views, extrapolation

FOLLOWED_MISFIT = 0.12  # of a hand that a view is not sure of
SURE_SCORE = 0.5
MOST_RETRIES = 2  # crops run again in one instant
MOST_JUMP_M, MOST_SPEED = 0.1, 1.0  # from the expected place: landmarks vary by half of that; and m/s of what is unseen
SHORT_LOSS_NS = 300 * NS_PER_MS  # after which another hand may be held up

Doubt = Callable[[SeenHand], float]


class HandFinder:
    """Follows one hand through the views."""

    def __init__(self, rig: Rig, views: Sequence[ViewHands]) -> None:
        self._views, self._pairing = tuple(views), HandPairing(rig)
        self._last: tuple[int, SeenHand] | None = None
        self._before: tuple[int, SeenHand] | None = None
        self._attempts = self._instants = 0
        self._still = StillHands()
        self._sees_room = False
        self._blind: tuple[int, ...] = ()

    @property
    def sees_room(self) -> bool:
        """Return whether the pictures show no hand, or only what is still as a poster and no two views agree on."""
        return self._sees_room

    @property
    def blind(self) -> tuple[int, ...]:
        """The views without any hand at the last instant, by number."""
        return self._blind

    def find(self, views: Views, doubt: Doubt, *, quickly: bool, motion: Motion | None = None) -> SeenHand | str:
        """The hand at the views' instant, or a sentence why there is none.

        Of new hands the one of least `doubt` is taken. An infinite doubt refuses it, and with any above 0 the search
        for others goes on. Outlines make up for less exact landmarks that are found `quickly`; with the hand's expected
        `motion` the views are then looked at in turn.
        """
        candidates = self._candidates(views, motion if quickly else None, quickly=quickly)
        self._blind = tuple(k for k, hands in enumerate(candidates) if not hands)
        found = [seen for seen in self._pairing.pairs(candidates) if _is_sure(seen)]
        self._sees_room = not found and self._still.are_all(views.t_ns, candidates)
        if not found:
            self._search(views.t_ns)
            return TrackingReason.NO_HAND if not any(candidates) else TrackingReason.HANDS_DIFFER
        seen = self._nearest(views.t_ns, found) if self._last else _least_doubted(found, doubt)
        if seen is None:
            self._search(views.t_ns)
            return TrackingReason.OTHER_HAND
        is_followed = self._last is not None or doubt(seen) == 0
        seen = self._seen_rightly(views, seen)
        if is_followed:
            self._follow(views.t_ns, seen)
        return seen

    def forget(self) -> None:
        """Search everywhere from now on."""
        self._last = self._before = None
        for view in self._views:
            view.lose()

    def _follow(self, t_ns: int, seen: SeenHand) -> None:
        for k, hand in seen.views.items():
            self._views[k].keep(hand)
        self._before, self._last = self._last, (t_ns, seen)

    def _candidates(self, views: Views, motion: Motion | None, *, quickly: bool) -> list[list[HandLandmarks]]:
        """By view the hands that it sees; in every second instant the one that it saw before, moved."""
        self._instants += 1
        found = []
        for k, view in enumerate(views.views):
            known = None if self._last is None or motion is None else self._last[1].views.get(k)
            is_asked = (self._instants + k) % 2 == 0 or view.weight < 1.0
            hand = None if is_asked or known is None or motion is None else self._views[k].carried(known, motion)
            found.append(self._views[k].hands(view, quickly=quickly) if hand is None else [hand])
        return found

    def _search(self, t_ns: int) -> None:
        """Search in all pictures; for a while only where the hand was."""
        for view in self._views:
            view.lose()
        if self._last is not None and not 0 <= t_ns - self._last[0] < SHORT_LOSS_NS:
            self._last = self._before = None

    def _nearest(self, t_ns: int, found: Sequence[SeenHand]) -> SeenHand | None:
        """The hand nearest to where the last instants let expect it, None if that is too far off."""
        if self._last is None:
            return None
        (last_ns, last), (before_ns, before) = self._last, self._before or self._last
        ahead = extrapolation(t_ns, last_ns, before_ns)
        expected = last.palm + ahead * (last.palm - before.palm)
        away = [float(np.linalg.norm(seen.palm - expected)) for seen in found]
        reach_m = MOST_JUMP_M + MOST_SPEED * max(0, t_ns - last_ns) / NS_PER_S
        return found[int(np.argmin(away))] if min(away) < reach_m else None

    def _seen_rightly(self, views: Views, seen: SeenHand) -> SeenHand:
        """The hand with those views run again in other crops that take it for its mirror image."""
        hands = dict(seen.views)
        for k in list(hands)[:MOST_RETRIES]:
            if self._views[k].side(hands[k]) < TURNED_RIGHT and views.views[k].weight >= 1.0:
                hands[k] = self._views[k].again(views.views[k], hands[k], self._attempts)
                self._attempts += 1
        changed = any(hands[k] is not hand for k, hand in seen.views.items())
        return (self._pairing.meet(hands) if changed else None) or seen


def _least_doubted(found: Sequence[SeenHand], doubt: Doubt) -> SeenHand | None:
    seen = min(found, key=doubt)
    return seen if doubt(seen) < math.inf else None


def _is_sure(seen: SeenHand) -> bool:
    """A hand that a view is not sure of must fit all the better."""
    return seen.score >= SURE_SCORE or seen.misfit <= FOLLOWED_MISFIT
