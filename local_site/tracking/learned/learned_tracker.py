"""The tracker for ordinary rooms: hand landmarks in two or more views, sharpened by the arm's outlines."""

from common.errors import CalibrationError
from common.geometry import Array
from common.messages.hand import TrackingStatus
from local_site.calibration.rig import Rig
from local_site.calibration.triangulation import focal_length
from local_site.tracking.config import LearnedConfig
from local_site.tracking.features.view_meter import views_problem
from local_site.tracking.landmarks.hand_finder import HandFinder
from local_site.tracking.landmarks.hand_pairing import SeenHand
from local_site.tracking.landmarks.models import view_hands
from local_site.tracking.learned.acquaintance import Acquaintance
from local_site.tracking.learned.arm_outlines import ArmOutlines
from local_site.tracking.learned.fitted_hand import FittedHand
from local_site.tracking.learned.followed_hand import FollowedHand
from local_site.tracking.learned.hand_motion import HandMotion
from local_site.tracking.learned.no_pair import why_no_pair
from local_site.tracking.learned.room_pictures import RoomPictures
from local_site.tracking.silhouette.arm_finder import NoArm, SeenArm
from local_site.tracking.silhouette.hand_model.fit import MAX_VIEWS, MIN_VIEWS, NO_VIEW, HandView
from local_site.tracking.silhouette.hand_model.landmark_equations import landmark_points
from local_site.tracking.silhouette.joints import elbow_covariance
from local_site.tracking.silhouette.operator_profile import OperatorProfile, make_profile
from local_site.tracking.silhouette.quality import doubts
from local_site.tracking.tracker import ArmEstimate, Overlay, TrackingReason, Views

# Of the crop's side: what landmarks miss by in one picture, more where the view may have seen the hand's mirror image.
LANDMARK_SIGMA, DOUBTFUL_SIGMA = 0.04, 0.06
SURE_SIDE, DOUBTFUL_SIDE = 0.8, 0.5
NO_PAIR = (TrackingReason.NO_HAND, TrackingReason.HANDS_DIFFER)


class LearnedTracker:
    """Tracks a bare arm before any background.

    The landmarks give the hand, its side and a start; the outlines of hand and arm sharpen it where they agree with
    them. Raises CalibrationError for a rig of more than four cameras, ModelError without the models.
    """

    def __init__(self, rig: Rig, config: LearnedConfig | None = None, profile: OperatorProfile | None = None) -> None:
        """`profile` is what an earlier run has learned of the operator."""
        if len(rig.cameras) > MAX_VIEWS:
            raise CalibrationError(f"the tracker takes {MAX_VIEWS} cameras at most, the rig has {len(rig.cameras)}")
        self._rig = rig
        config = config or LearnedConfig()
        self._right_arm = config.right_arm
        self._finder = HandFinder(rig, view_hands(rig, config.right_arm))
        self._outlines = ArmOutlines(rig)
        self._room = RoomPictures()
        self._operator = Acquaintance(config, profile)
        self._hand = FollowedHand(config.right_arm, profile)
        self._motion = HandMotion()
        self._outlined = False

    @property
    def profile(self) -> OperatorProfile | None:
        """What has been learned of the operator in all runs, None until this one has learned the arm and the hand."""
        length, hand = self._operator.body.forearm_length, self._hand.learned
        if length is None or hand is None or not self._operator.is_known:
            return None
        return make_profile(*hand, length, self._operator.pairs)

    def track(self, views: Views) -> ArmEstimate:
        """The arm at the views' instant; a frame that cannot be tracked gives the reason."""
        problem = views_problem(self._rig, views, MIN_VIEWS)
        if problem:
            return self._lost(views, problem)
        # Before a dark wall the outlines cost so little that there is time to look at all views.
        motion = self._motion.expected(views.t_ns) if self._outlines.in_room else None
        seen = self._finder.find(views, self._operator.doubt, quickly=self._outlined, motion=motion)
        if isinstance(seen, str):
            outlined = self._by_outlines(views) if seen in NO_PAIR else None
            return outlined or self._lost(views, seen)
        if not self._operator.has_side(views.t_ns, seen):
            self._finder.forget()
            return self._lost(views, TrackingReason.OTHER_SIDE)
        arm = self._outlines.find(views, self._operator.body, seen, starting=not self._operator.is_known)
        if isinstance(arm, NoArm) and self._operator.lacks_arm(seen):
            self._finder.forget()
        hand = self._fit(seen, arm)
        if hand is None:
            return self._lost(views, TrackingReason.HAND_UNCLEAR)
        return self._found(views.t_ns, arm, hand, seen.residual_px)

    def _by_outlines(self, views: Views) -> ArmEstimate | None:
        """The arm before a dark wall whose outlines fit on for a short time in which no two views see its hand."""
        if not self._outlined or not self._operator.was_seen(views.t_ns):
            return None
        arm = self._outlines.find_without_hand(views, self._operator.body)
        if isinstance(arm, NoArm) or not self._operator.has_length(arm, arm.joints.wrist):
            return None
        finder = self._outlines.finder
        hand = self._hand.track_outlines(tuple(finder.hand_views(arm).values()), finder.evidence(arm))
        return None if hand is None or not hand.is_clear else self._found(views.t_ns, arm, hand)

    def _fit(self, seen: SeenHand, arm: SeenArm | NoArm) -> FittedHand | None:
        finder = self._outlines.finder
        outlines = finder.hand_views(arm) if isinstance(arm, SeenArm) else {}
        views = [
            self._with_landmarks(outlines.get(k), matrix, seen, k)
            for k, matrix in enumerate(self._rig.matrices)
            if k in outlines or k in seen.views
        ]
        evidence = finder.evidence(arm) if isinstance(arm, SeenArm) else None
        return self._hand.track(views, seen.points, evidence, outlines_are_sharp=not self._outlines.in_room)

    def _with_landmarks(self, outline: HandView | None, matrix: Array, seen: SeenHand, k: int) -> HandView:
        view = outline or NO_VIEW._replace(projection=matrix, focal_px=focal_length(matrix))
        if k not in seen.views:
            return view
        side = seen.views[k].for_side(self._right_arm)
        if side < DOUBTFUL_SIDE:
            return view
        sigma = LANDMARK_SIGMA if side > SURE_SIDE else DOUBTFUL_SIGMA
        return view._replace(landmarks=seen.pixels[k], landmark_sigma=sigma * seen.views[k].crop.side_px)

    def _found(
        self, t_ns: int, arm: SeenArm | NoArm, hand: FittedHand, hand_residual_px: float | None = None
    ) -> ArmEstimate:
        wrist = hand.fit.pose.wrist
        points = {"wrist": wrist, "index": hand.index.point, "thumb": hand.thumb.point}
        covariances = {
            "wrist": hand.wrist_covariance,
            "index": hand.index_covariance,
            "thumb": hand.thumb_covariance,
        }
        reasons = [] if hand.is_clear else [TrackingReason.HAND_UNCLEAR]
        if not self._rig.contains(wrist):
            reasons.append(TrackingReason.OUTSIDE_VOLUME)
        elbow_reason = self._judge_arm(arm, wrist, reasons)
        if hand.is_fist:  # the arm is learned all the same
            reasons.append(TrackingReason.FIST)
        overlays: tuple[Overlay, ...] = ()
        if isinstance(arm, SeenArm):
            self._outlines.finder.keep(arm, wrist)
            overlays = self._outlines.finder.overlays(arm, [arm.joints.elbow, *points.values()])
            if not elbow_reason:
                points["elbow"] = arm.joints.elbow
                covariances["elbow"] = elbow_covariance(arm.joints, arm.limbs)
        self._motion.add(t_ns, landmark_points(hand.fit.spheres.centres))
        self._outlined = self._operator.is_known and hand.is_clear and hand.outline_views >= MIN_VIEWS
        status, reason = self._operator.status(reasons, elbow_reason)
        if status is TrackingStatus.TRACKED and hand.thumb_inferred:
            reason = "; ".join(filter(None, [reason, TrackingReason.THUMB_INFERRED]))
        return ArmEstimate(
            t_ns,
            status,
            reason,
            **points,
            thumb_inferred=hand.thumb_inferred,
            hand_open=hand.hand_open and self._operator.is_sure_of_side,
            fingers_together=hand.fingers_together,
            overlays=overlays,
            covariances=covariances,
            residual_px=arm.residual_px if isinstance(arm, SeenArm) and arm.residual_px else hand_residual_px,
        )

    def _judge_arm(self, arm: SeenArm | NoArm, wrist: Array, hand_reasons: list[TrackingReason]) -> str:
        """Learn the arm where all agrees; why its elbow is not to be trusted, else empty."""
        if isinstance(arm, NoArm):
            return arm.reason
        reasons = doubts(self._rig, arm.limbs, arm.features, arm.joints)
        self._learn(arm, wrist, hand_reasons, reasons)
        if not self._operator.is_known:
            return "; ".join(reasons) or TrackingReason.LEARNING
        # The forearm's line and its known length tell where the elbow is, too.
        against = [reason for reason in reasons if reason != TrackingReason.NO_UPPER_ARM]
        return "; ".join(against) or ("" if self._operator.has_length(arm, wrist) else TrackingReason.NO_ARM)

    def _learn(
        self, arm: SeenArm, wrist: Array, hand_reasons: list[TrackingReason], reasons: list[TrackingReason]
    ) -> None:
        before = self._operator.profile
        if not hand_reasons:
            self._operator.learn(arm, wrist, self._outlines.finder.sleeve(arm), reasons)
        elif TrackingReason.HAND_UNCLEAR in hand_reasons:
            self._operator.doubt_profile()
        if self._operator.profile is not before:
            self._hand = FollowedHand(self._right_arm, None)

    def _lost(self, views: Views, reason: str) -> ArmEstimate:
        self._motion.forget()
        self._outlined = False
        self._outlines.forget()
        self._operator.lose(views.t_ns)
        if not self._operator.has_begun:
            self._finder.forget()
            self._hand.forget()
        told = why_no_pair(reason, self._rig, views, self._finder.blind) if reason in NO_PAIR else reason
        if reason in NO_PAIR and self._finder.sees_room and not self._operator.is_known:
            room = self._room.take(views)
            if room is not None:
                self._outlines.learn_room(room)
            if self._room.is_learning:
                lesson = told if TrackingReason.DARK in told else TrackingReason.LEARNING_ROOM
                return ArmEstimate(views.t_ns, TrackingStatus.INITIALISING, lesson)
        else:
            self._room.forget()
        return ArmEstimate(views.t_ns, TrackingStatus.LOST, told)
