"""The hand between instants: the hand model fitted to landmarks, and to the outlines where they agree with them."""

from collections import deque
from collections.abc import Iterator, Sequence
from statistics import median

import numpy as np

from common.geometry import Array
from local_site.calibration.triangulation import project, triangulate_many
from local_site.tracking.landmarks.hand_landmarks import MIDDLE_KNUCKLE, WRIST
from local_site.tracking.learned.finger_orders import (
    in_likely_order,
    is_as_told,
    is_contradicted,
    palm_extent,
    possible_orders,
    thumb_agrees,
)
from local_site.tracking.learned.fitted_hand import MAX_COST, FittedHand
from local_site.tracking.learned.hand_starts import PALM_LANDMARKS, any_posture, pose_from_landmarks, scale_of
from local_site.tracking.silhouette.hand_model.fit import (
    MIN_VIEWS,
    NO_PIXELS,
    NO_VIEW,
    HandFit,
    HandView,
    Prior,
    fit_hand,
)
from local_site.tracking.silhouette.hand_model.habits import (
    OPEN_CURL,
    STILL_OPEN_CURL,
    Belief,
    Habits,
    LimbEvidence,
    near_last,
    prior_information,
)
from local_site.tracking.silhouette.hand_model.landmark_equations import landmark_points
from local_site.tracking.silhouette.hand_model.skeleton import (
    PALM,
    HandPose,
    Person,
    most_curled,
)
from local_site.tracking.silhouette.operator_profile import OperatorProfile
from local_site.tracking.silhouette.tips import INDEX, THUMB, find_tips

ITERATIONS, PLACING_ITERATIONS, SHARPENING_ITERATIONS = 6, 3, 4
BESIDE_OUTLINE = 2.5  # times the landmarks' standard deviation
START_ITERATIONS, START_SIGMAS = 5, 3.0
LOOSE_WRIST_M = 0.03
HABITUAL = 2.0  # mean squared deviation from a habit in its own standard deviations
CLEARLY_BETTER, REVERSED_BETTER = 0.9, 0.7  # of the cost so far: of new starts as told, and with fingers reversed
START_EVERY, WORSE, REMEMBERED_COSTS = 5, 1.2, 30
UNUSUAL, UNUSUAL_COST = 2.2, 0.5  # against the median, and at least
LEAST_USUAL_CURL, MOST_GRIPPER_CURL = 0.3, 2.0  # rad, of a hand held like a gripper: no flat hand, no fist
STRETCHED, STILL_STRETCHED = 0.4, 0.55  # rad, of the finger that is curled most in an open hand
LEAST_SCALE, MOST_SCALE = 0.4, 2.0  # of a hand against the average one
MOST_LANDMARK_MISFIT = 0.6  # of the palm's extent in the picture; index for little finger is more
BELIEVED_AFTER, KNOWN_AFTER = 3, 10  # instants
REMEMBERED_SCALES = 60
MOST_STEP_M = 0.1  # between two instants: 3 m/s at 30 pairs/s


class FollowedHand:
    """Fits a hand from instant to instant; the sizes that it learns are one operator's and are kept through losses."""

    def __init__(self, right_arm: bool, profile: OperatorProfile | None) -> None:
        """`profile` is what an earlier run has learned."""
        self._right_arm = right_arm
        self._habits = Habits(None if profile is None else profile.habits)
        known = [] if profile is None else [profile.scale] * REMEMBERED_SCALES
        self._scales: deque[float] = deque(known, REMEMBERED_SCALES)
        self._last: tuple[HandPose, Array, Array] | None = None
        self._open = self._apart = False
        self._mistaken = self._instants = self._turn = 0
        self._costs: deque[float] = deque(maxlen=REMEMBERED_COSTS)

    @property
    def learned(self) -> tuple[float, Belief] | None:
        """The hand's size against the average and its habits, None until they are known."""
        return (median(self._scales), self._habits.own) if self._habits.learned and self._scales else None

    def forget(self) -> None:
        """Start from an unknown pose with the next instant."""
        self._last, self._mistaken = None, 0
        self._open = self._apart = False

    def track(
        self,
        views: Sequence[HandView],
        landmarks: Array,
        arm: LimbEvidence | None,
        *,
        outlines_are_sharp: bool = False,
    ) -> FittedHand | None:
        """The hand of views with landmarks, whose triangulation (21, 3) in m is `landmarks`; None without a start.

        `outlines_are_sharp` before a dark wall, where nothing else has edges.
        """
        if not _show(views) or not LEAST_SCALE < scale_of(landmarks, self._right_arm) < MOST_SCALE:
            return None
        person = self._person(landmarks, arm)
        fitted = self._fit(views, landmarks, arm, person, outlines_are_sharp=outlines_are_sharp)
        if fitted is None:
            return None
        fit, believed = fitted
        points = landmark_points(fit.spheres.centres)
        self._last = fit.pose, landmarks, points
        self._mistaken = self._mistaken + 1 if fit.cost > MAX_COST else 0
        self._open = self._is_open(fit.pose.posture)
        self._apart = self._habits.are_apart(fit.pose.posture, self._apart)
        is_unusual = fit.cost > max(UNUSUAL * median(self._costs), UNUSUAL_COST)
        doubtful = is_unusual or is_contradicted(views, points)
        if not (self._open or self._mistaken or doubtful) and most_curled(fit.pose.posture) < MOST_GRIPPER_CURL:
            self._habits.learn_fit(fit)
        index, thumb = find_tips(believed, fit.spheres, (INDEX, THUMB))
        landmark_views = sum(len(view.landmarks) > 0 and not np.isnan(view.landmarks).any() for view in believed)
        outline_views = sum(len(view.pixels) > 0 for view in believed)
        return FittedHand(fit, index, thumb, self._open, not self._apart, landmark_views, outline_views, doubtful)

    def track_outlines(self, views: Sequence[HandView], arm: LimbEvidence) -> FittedHand | None:
        """The hand of views without landmarks, near the last one moved with the arm; None without one near there."""
        if self._last is None:
            return None
        pose, landmarks, _ = self._last
        moved = arm.wrist - pose.wrist
        return None if float(np.linalg.norm(moved)) > MOST_STEP_M else self.track(views, landmarks + moved, arm)

    def _fit(
        self,
        views: Sequence[HandView],
        landmarks: Array,
        arm: LimbEvidence | None,
        person: Person,
        *,
        outlines_are_sharp: bool,
    ) -> tuple[HandFit, Sequence[HandView]] | None:
        """The best fit, and the views as they were believed for it.

        From the last pose; now and then, and where that fits worse than usual, also from the landmarks alone.
        """
        best: tuple[HandFit, Sequence[HandView]] | None = None
        for believed, start, belief in self._starts(views, landmarks, person):
            prior = _prior(belief, start, arm)
            fit = _fitted(believed, start, prior, person, outlines_are_sharp=outlines_are_sharp)
            if best is None:
                best = fit, believed
                self._instants += 1
                if self._instants % START_EVERY and self._costs and fit.cost < WORSE * median(self._costs):
                    break
                continue
            better = CLEARLY_BETTER if is_as_told(believed, views) else REVERSED_BETTER
            if fit.cost < better * best[0].cost and thumb_agrees(believed, landmark_points(fit.spheres.centres)):
                best = fit, believed
        if best is not None:
            self._costs.append(best[0].cost)
        return best

    def _believed(self, views: Sequence[HandView], landmarks: Array) -> Sequence[HandView]:
        """The views with their fingers in the order that is likely after the last instant.

        A view whose landmarks take one finger for another is left without them: no finger moves that far at once. After
        some bad instants they are believed again.
        """
        if self._last is None:
            return views
        _, before, fitted = self._last
        palm = list(PALM_LANDMARKS)
        points = fitted + np.mean(landmarks[palm] - before[palm], axis=0)
        expected = [project(view.projection, points) for view in views]
        ordered = [in_likely_order(view, pixels) for view, pixels in zip(views, expected, strict=True)]
        if self._mistaken > BELIEVED_AFTER:
            return ordered
        believed = [_unless_mistaken(view, pixels) for view, pixels in zip(ordered, expected, strict=True)]
        return believed if _show(believed) else ordered

    def _is_open(self, posture: Array) -> bool:
        """Whether all fingers are stretched well beyond their usual curl; with hysteresis (thesis 4.2).

        Not before the operator's own curl is known: a U of nearly straight fingers would be open for ever.
        """
        if self._habits.learned < KNOWN_AFTER:
            return False
        usual = max(most_curled(self._habits.own.posture), LEAST_USUAL_CURL)
        share, most = (STILL_OPEN_CURL, STILL_STRETCHED) if self._open else (OPEN_CURL, STRETCHED)
        return bool(most_curled(posture) < min(share * usual, most))

    def _person(self, landmarks: Array, arm: LimbEvidence | None) -> Person:
        if len(self._scales) < REMEMBERED_SCALES:
            self._scales.append(scale_of(landmarks, self._right_arm))
        away = landmarks[WRIST] - landmarks[MIDDLE_KNUCKLE] if arm is None else arm.elbow - arm.wrist
        return Person(median(self._scales), self._right_arm, away / max(float(np.linalg.norm(away)), 1e-6))

    def _expected(self, posture: Array) -> Belief:
        """What is believed of a hand that was last held like this: a habit if it was one."""
        for habit in (self._habits.closed, self._habits.opened):
            if _is_habitual(posture, habit):
                return habit
        return any_posture(self._habits.own)

    def _starts(
        self, views: Sequence[HandView], landmarks: Array, person: Person
    ) -> Iterator[tuple[Sequence[HandView], HandPose, Belief]]:
        """The last pose moved with the palm, and new ones where landmarks show them; each with the views as they are
        believed for it, and what is believed of the hand."""
        belief = any_posture(self._habits.own)
        if self._last is not None:
            last, before, _ = self._last
            palm = list(PALM_LANDMARKS)
            moved = last._replace(wrist=last.wrist + np.mean(landmarks[palm] - before[palm], axis=0))
            yield self._believed(views, landmarks), moved, near_last(self._expected(last.posture), last.posture)
        if sum(len(view.landmarks) > 0 for view in views) < MIN_VIEWS:
            return
        for order in self._orders(views):
            yield order, _start(order, belief, person), belief

    def _orders(self, views: Sequence[HandView]) -> list[list[HandView]]:
        """The orders of the fingers to start from: all at first, later the one that is told and another in turn.

        Only outlines can decide between them.
        """
        if sum(len(view.pixels) > 0 for view in views) < MIN_VIEWS:
            return [list(views)]
        orders = possible_orders(views)
        if self._last is None:
            return orders
        self._turn = self._turn % (len(orders) - 1) + 1
        return [orders[0], orders[self._turn]]


def _fitted(
    views: Sequence[HandView], start: HandPose, prior: Prior, person: Person, *, outlines_are_sharp: bool
) -> HandFit:
    """The fit from a start.

    Landmarks of one picture miss together. So beside sharp outlines they first bring each finger to its place, and then
    count for less: with little weight from the start, a finger can stay in the outline of another.
    """
    if not outlines_are_sharp:
        return fit_hand(views, start, prior, person, ITERATIONS)
    placed = fit_hand(views, start, prior, person, PLACING_ITERATIONS)
    return fit_hand([_blunted(view) for view in views], placed.pose, prior, person, SHARPENING_ITERATIONS)


def _blunted(view: HandView) -> HandView:
    """The view with landmarks that count for less where it has an outline."""
    return view._replace(landmark_sigma=BESIDE_OUTLINE * view.landmark_sigma) if len(view.pixels) else view


def _show(views: Sequence[HandView]) -> bool:
    """Whether the views show anything of the hand."""
    return any(len(view.landmarks) + len(view.pixels) for view in views)


def _unless_mistaken(view: HandView, expected: Array) -> HandView:
    """The view without its landmarks where these lie far from those expected (21, 2) in px."""
    if not len(view.landmarks):
        return view
    off = float(np.sqrt(np.nanmean(np.sum((view.landmarks - expected) ** 2, axis=1))))
    return view._replace(landmarks=NO_PIXELS) if off > MOST_LANDMARK_MISFIT * palm_extent(expected) else view


def _start(views: Sequence[HandView], belief: Belief, person: Person) -> HandPose:
    """The pose that fits the landmarks of the views alone."""
    shown = [view for view in views if len(view.landmarks)]
    pixels = np.stack([view.landmarks for view in shown], axis=1)
    points = triangulate_many([view.projection for view in shown], pixels)
    start = pose_from_landmarks(points, person, belief.posture[PALM:])
    alone = [
        NO_VIEW._replace(
            projection=view.projection,
            focal_px=view.focal_px,
            landmarks=view.landmarks,
            landmark_sigma=START_SIGMAS * view.landmark_sigma,
        )
        for view in shown
    ]
    return fit_hand(alone, start, _prior(belief, start, None), person, START_ITERATIONS).pose


def _is_habitual(posture: Array, habit: Belief) -> bool:
    off = posture - habit.posture
    return bool(off @ habit.information @ off < HABITUAL * len(off))


def _prior(belief: Belief, start: HandPose, arm: LimbEvidence | None) -> Prior:
    if arm is not None:
        return arm.prior(belief, start)
    information = prior_information(LOOSE_WRIST_M**2 * np.eye(3), belief.information, turn_known=True)
    return Prior(start.wrist, start.rotation, belief.posture, information)
