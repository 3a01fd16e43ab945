"""The next joint motion towards the tool's target: collision-free, jerk-limited, guarded; pure."""

from common.geometry import Array
from remote_site.kinematics.dexterity import FULL, Dexterity
from remote_site.kinematics.joints import JointMotion
from remote_site.motion.jerk_limited import JerkLimitedTracker
from remote_site.motion.target_tracker import TargetTracker
from remote_site.motion.tool_sample import ToolSample
from remote_site.reasons import Reason
from remote_site.safety.collision_avoidance import CollisionAvoidance
from remote_site.safety.guard import Guard, Refused


class MotionPlanner:
    """Plans one tick at a time from the motion that was really sent; whatever it returns, the guard has passed it."""

    def __init__(
        self,
        tracker: TargetTracker,
        dexterity: Dexterity,
        avoidance: CollisionAvoidance,
        jerk_limited: JerkLimitedTracker,
        guard: Guard,
    ) -> None:
        self._tracker = tracker
        self._dexterity = dexterity
        self._avoidance = avoidance
        self._jerk_limited = jerk_limited
        self._guard = guard
        self._hindrance: Reason | None = None
        self._obstacle: Reason | None = None
        self._slowing = FULL
        self._near, self._barred = 1.0, False
        self._unjudged = 0

    @property
    def hindrance(self) -> Reason | None:
        """The reason why the arm does not follow the target fully, None while it does."""
        return self._hindrance or self._obstacle

    def pace(self, sent: JointMotion) -> float:
        """The greatest fraction of its speed that a joint has or reaches once its acceleration is taken back."""
        return self._jerk_limited.limits.pace(sent.dq, sent.ddq)

    def reset(self, t_ns: int, q: Array) -> None:
        """Start again from a target that rests at `q` (n,) rad since `t_ns`."""
        self._tracker.reset(t_ns, q)
        self._hindrance, self._slowing, self._unjudged = None, FULL, 0
        self._near, self._barred = 1.0, False

    def aim(self, target: ToolSample) -> None:
        """Take a new target of the tool."""
        unreached = self._tracker.aim(target)
        self._hindrance = target.leashed or unreached or target.boxed
        self._unjudged += 1

    def stop(self, sent: JointMotion) -> JointMotion:
        """The motion one tick into the stop."""
        return self._guard.stop(sent)

    def follow(self, now_ns: int, sent: JointMotion, speed_scale: float, *, aimed: bool) -> JointMotion:
        """The motion one tick on towards the target, or into the stop if the target must not be followed.

        `speed_scale` is the fraction of full speed that is allowed, `aimed` whether a target came in this tick.
        """
        self._jerk_limited.reset(sent)
        pace = self._slowing.fraction * self._near * speed_scale  # as in the tick before
        target = self._tracker.at(now_ns, sent, pace, barred=self._barred)
        aside = self._avoidance.turn_aside(sent.q, target)
        self._near, self._barred = aside.speed, aside.reason is not None
        if self._unjudged > aimed:  # deferred by one tick to bound tick time: aiming is the expensive one
            self._slowing, self._unjudged = self._dexterity.slowing(sent.q, target.q), 0
        self._obstacle = aside.reason or self._slowing.reason
        proposed = self._jerk_limited.track(aside.target, aside.speed * self._slowing.fraction * speed_scale)
        if isinstance(proposed, Reason):
            self._hindrance = proposed
            return self.stop(sent)
        tempered = self._avoidance.temper(proposed, sent, aside.close_pairs) if aside.close_pairs else proposed
        if tempered is None:
            return self.stop(sent)
        verdict = self._guard.check(tempered, sent)
        if isinstance(verdict, Refused):
            self._hindrance = verdict.reason
            return self.stop(sent)
        return tempered
