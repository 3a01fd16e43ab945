"""A joint target that waits on its path for joints that cannot follow: all are slowed together; pure."""

import math
from collections.abc import Callable
from dataclasses import replace

import numpy as np

from common.clock import NS_PER_S
from common.geometry import Array
from remote_site.kinematics.joints import JointMotion
from remote_site.kinematics.limits import TARGET_SPEED, JointLimits
from remote_site.kinematics.model import ArmModel
from remote_site.motion.catch_up import BOUNDS
from remote_site.motion.joint_path import COUNTED, PLANNED, JointPath, Knot, on_the_curve, part_of
from remote_site.motion.target_predictor import JointBounds
from remote_site.motion.tool_shift import NOTHING, WRIST_ROLLS, ToolShift, fastest_alone

STOPPING = 0.85  # of the joints' accelerations: to stop with when the hand does
HARDEST = 0.7  # the same, to brake on the path for what was not foreseen
HAND_M_S2, BEYOND_M = 2.0, 0.008  # how a hand stops, and how far one joint alone may take the tool beyond
LEFT_M = 0.003  # so far beside its way a tool has left it
CANCELLED_M = 0.0015  # so far off its target, it soon leaves its way where joints cancel each other
NEAR_M, FAR_M = 0.001, 0.005  # a path waits for a tool that is off it: the more, the farther
CLOSE_RAD, CLOSE_PACE = 0.07, 0.1  # of the target, in every joint, and of full speed: what can be made up for
MADE_UP = 0.6  # of the joints' accelerations, for that
CATCH_UP = 2.0  # times as fast as after a hold: the hand is there, and sees it
SURE = 2.0  # the end of the path is passed at the hand's own pace, if this times as much can be followed; then at less
STRETCHED, MORE_STRETCHED = 2.2, 2.9  # `ToolShift.stretch`; before the arm, elbows bent by some 60 and 40 degrees
QUICK_M_S = 0.25  # slower, a tool that the noise of the samples takes off comes back
CANCEL = 2.0  # a joint alone would move the tool so much faster: joints cancel, as near a stretched elbow
SLOW, SLOW_M_S = 0.01, 0.01  # of full speed; of a tool that moves nowhere
HELD_S = 0.5  # off a path that waits: something else keeps the arm from it, as an obstacle does
LONGEST_S = 1.0  # at the speed that is allowed: what is left of the path; with many bends it takes six times as long
MOST_KNOTS = 300  # each costs every tick some 0.25 us
FASTEST_RAD_S = 10.0  # the decay rate
NOTHING_RAD = 1e-5

Rate = Callable[[float, list[float], list[float]], float]


class DecayingOffset:
    """Joins a motion to a target without a jump; `rate` finds one that all joints can follow."""

    def __init__(self, rate: Rate, dt: float) -> None:
        self._choose_rate, self._dt = rate, dt
        self.reset()

    def reset(self) -> None:
        """No offset."""
        self._rate, self._off, self._dq_off = 0.0, np.zeros(1), np.zeros(1)

    def begin(self, motion: JointMotion, target: JointMotion) -> None:
        """From the motion as it is, on to the target."""
        self._off, self._dq_off = motion.q - target.q, motion.dq - target.dq
        self._rate = self._choose_rate(FASTEST_RAD_S, self._off.tolist(), self._dq_off.tolist())

    def added_to(self, target: JointMotion) -> JointMotion:
        """The target's motion and what is left of the offset one tick later.

        Of x'' = -2 r x' - r² x the solution is x = exp(-r t) (x0 + t p) with p = x0' + r x0.
        """
        if self._rate == 0.0:
            return target
        rate, dt = self._rate, self._dt
        push, decay = self._dq_off + rate * self._off, math.exp(-rate * dt)
        left = self._off + dt * push
        off, dq_off = self._off, self._dq_off = decay * left, decay * (push - rate * left)
        if float(np.max(np.abs(off))) < NOTHING_RAD and float(np.max(np.abs(dq_off))) < NOTHING_RAD * rate:
            self.reset()
        return JointMotion(target.q + off, target.dq + dq_off, target.ddq - rate * (2 * dq_off + rate * off))


class WaitingTarget:
    """Lets a target pass as it is while the joints can follow it, and could stop where a hand would stop.

    Near a stretched elbow or a straight wrist joints have to be quicker than they can. Each by itself would then take
    the tool off its path by decimetres. So the target goes along the path of the hand's samples, no faster than all
    joints can together, and slower while the tool is off it. Where more than LONGEST_S is left of the path, it becomes
    a short cut.
    """

    def __init__(self, model: ArmModel, limits: JointLimits, dt: float) -> None:
        self._tool, self._dt = ToolShift(model), dt
        self._path, self._bounds = JointPath(model, limits), JointBounds(model, limits, SLOW)
        gentle = replace(limits, acceleration=MADE_UP * limits.acceleration)
        self._offset = DecayingOffset(JointBounds(model, gentle, SLOW).convergence, dt)
        self.reset()

    def reset(self) -> None:
        """Wait no longer."""
        self._path.clear()
        self._offset.reset()
        self._s = self._pace = 0.0
        self._speed = 1.0
        self._halted, self._held_s = False, 0.0

    @property
    def waits(self) -> bool:
        """Return whether it is on its path, not where the hand asks."""
        return bool(self._path.knots)

    @property
    def ahead_s(self) -> float:
        """The rest of the path, in s at full speed."""
        return self._path.knots[-1].s - self._s if self.waits else 0.0

    def add(self, q: Array, t_ns: int) -> None:
        """Take a solution (n,) in rad on the hand's way at `t_ns`; a target that does not wait needs none."""
        if self.waits and len(self._path.knots) < MOST_KNOTS and self.ahead_s < LONGEST_S * self._speed:
            self._path.add(q, t_ns)
        self._halted = False

    def halt(self, q: Array) -> None:
        """Take `q` (n,) in rad as the end of the hand's way: the hand is where the arm cannot reach."""
        self._halted = self.waits
        if len(self._path.knots) == 1:
            self._path.add(q, self._path.knots[0].t_ns + 1)

    def follow(
        self, hand_ns: int, target: JointMotion, sent: JointMotion, speed: float, *, barred: bool = False
    ) -> JointMotion:
        """The target's motion, or the motion on its path, for an arm that `sent` leads at a fraction of full speed.

        `hand_ns` is when the hand was where the target is. A target whose arm is `barred` from it does not wait.
        """
        self._speed = speed
        asked, followable = self._path.pace(target.dq), self._followable(target, speed)
        if not self.waits:
            motion = self._offset.added_to(target)
            motion = motion if motion is target else self._inside(motion)
            if not barred and self._must_wait(motion, target, sent, too_fast=asked > followable):
                self._s, self._pace = 0.0, min(self._path.pace(motion.dq), self._path.pace(sent.dq))
                self._path.begin(motion.q, hand_ns, 0.0, motion.dq, self._pace)
            return motion
        alone = len(self._path.knots) == 1
        motion = self._alongside(target, sent, speed) if alone else self._walk(asked, followable, sent, speed)
        motion = self._inside(motion)
        off_m = self._tool.between_m(motion.q, sent.q)
        self._held_s = self._held_s + self._dt if off_m >= FAR_M and self._pace == 0.0 else 0.0
        caught_up = off_m <= NEAR_M and asked <= followable and self._is_close(motion, target)
        if barred or caught_up or self._held_s > HELD_S:
            self.reset()
            self._offset.begin(motion, target)
        return motion

    def _inside(self, motion: JointMotion) -> JointMotion:
        """The motion within the joints' limits: a curve between solutions that are may swing beyond."""
        q, dq = (np.array(column) for column in self._bounds.clamp(motion.q.tolist(), motion.dq.tolist()))
        return JointMotion(q, dq, np.where(dq == motion.dq, motion.ddq, 0.0))

    def _is_close(self, motion: JointMotion, target: JointMotion) -> bool:
        """Return whether what is left to the target is so little that it need not be on the path."""
        far = np.abs(motion.q - target.q)
        far[WRIST_ROLLS] *= COUNTED
        return float(far.max()) < CLOSE_RAD and self._path.pace(motion.dq - target.dq) < CLOSE_PACE

    def _followable(self, target: JointMotion, speed: float) -> float:
        """The greatest pace that the joints can follow, and from which they stop soon enough if the hand stops.

        A hand that stops with a from v goes on by v²/2a; at the pace u, v/u m of its way are one s, so that is u v/2a.
        Joints that need (u² / 2 gain) s to stop are then ahead; each must not take the tool further than BEYOND_M.
        """
        pace = self._path.pace(target.dq)
        if pace <= SLOW:
            return TARGET_SPEED * speed
        moved = self._tool.lever(target.q) * target.dq
        tool_m_s = math.hypot(*moved.sum(axis=1).tolist())
        stops_s = tool_m_s / (2 * HAND_M_S2) + BEYOND_M / max(fastest_alone(moved), NOTHING)
        gain = STOPPING / PLANNED * self._path.gain(target.dq / pace)
        return min(TARGET_SPEED * speed, 2 * gain * stops_s)

    def _alongside(self, target: JointMotion, sent: JointMotion, speed: float) -> JointMotion:
        """One tick on beside the target, while the hand's sample of this moment has not come yet.

        Not onto the target: it is a prediction, and may turn back. Then it brakes first.
        """
        here, asked, former = self._path.knots[0], self._path.pace(target.dq), self._pace
        onward = asked > SLOW and (former <= SLOW or float(target.dq @ here.chord) > 0.0)
        slope = target.dq / asked if onward else here.chord
        most = 0.0 if self._halted or not onward else min(asked, TARGET_SPEED * speed) * self._near(here.q, sent.q)
        gone = self._advance(most, self._path.gain(slope))
        t_ns = here.t_ns + round(min(gone / max(asked, SLOW), self._dt) * NS_PER_S)
        self._path.begin(here.q + gone * slope, t_ns, self._s, slope, asked)
        return JointMotion(here.q, former * slope, (self._pace - former) / self._dt * slope)

    def _walk(self, asked: float, followable: float, sent: JointMotion, speed: float) -> JointMotion:
        """One tick on along the path, for a hand at the pace `asked` where `followable` is the greatest."""
        knots, s, former = self._path.knots, self._s, self._pace
        q, slope, bend = on_the_curve(knots[0], knots[1], s)
        own = knots[0].own + part_of(knots[0], knots[1], s) * (knots[1].own - knots[0].own)
        end = 0.0 if self._halted else asked * min(max(SURE * (1.0 - asked / followable), 0.0), 1.0)
        most = _catching_up(knots[1], max(own, asked))
        most = min(most, TARGET_SPEED * speed, self._brakable(end)) * self._near(q, sent.q)
        self._advance(most, knots[1].gain)
        while len(knots) > 2 and knots[1].s <= self._s:
            knots.popleft()
        last = knots[-1]
        if self._s >= last.s:  # until the hand's next sample comes, on beside the target
            self._path.begin(last.q, last.t_ns, last.s, last.chord, last.own)
        return JointMotion(q, former * slope, (self._pace - former) / self._dt * slope + former * former * bend)

    def _advance(self, most: float, gain: float) -> float:
        """Go on for a tick at a pace of no more than `most` if it can be; how far in s."""
        former, knots = self._pace, self._path.knots
        harder = HARDEST / PLANNED * gain
        self._pace = max(min(most, former + gain * self._dt), former - harder * self._dt, 0.0)
        gone = (former + self._pace) / 2 * self._dt
        if len(knots) > 1:
            gone = min(gone, max(knots[-1].s - self._s, 0.0))
        self._s += gone
        return gone

    def _brakable(self, end: float) -> float:
        """The greatest pace from which every bend is taken slowly enough, and the last knot at the pace `end`."""
        knots = self._path.knots
        square, after = end * end, knots[-1]
        for k in range(len(knots) - 2, 0, -1):
            square = min(square + 2 * after.gain * (after.s - knots[k].s), after.bend, knots[k].bend)
            after = knots[k]
        return math.sqrt(min(square + 2 * after.gain * max(after.s - self._s, 0.0), after.bend))

    def _must_wait(self, motion: JointMotion, target: JointMotion, sent: JointMotion, *, too_fast: bool) -> bool:
        """Return whether joints will take the tool off its way: where the elbow is bent, what they lag leads along it.

        Not so what joints 4 and 6 lag: the others make up for where these should be.
        """
        if self._tool.by_rolls_m(target.q, sent.q) > BEYOND_M and self._tool.between_m(target.q, sent.q) > FAR_M:
            return True
        if not too_fast and not self._left(motion, sent.q):
            return False
        quick = too_fast or self._tool.speed_m_s(target.q, target.dq) >= QUICK_M_S
        return self._stretch(sent, target) > (STRETCHED if quick else MORE_STRETCHED)

    def _stretch(self, here: JointMotion, target: JointMotion) -> float:
        return max(self._tool.stretch(here.q), self._tool.stretch(target.q))

    def _left(self, target: JointMotion, at: Array) -> bool:
        """Return whether the tool has left its way, or is about to.

        One that is behind its target is late, but on its way: what counts is how far it is beside it. Where the joints'
        own motions cancel, as near a stretched elbow, what they lag soon leads beside the way.
        """
        lever = self._tool.lever(at)
        off, moved = lever @ (target.q - at), lever * target.dq
        velocity = moved.sum(axis=1)
        speed = max(math.hypot(*velocity.tolist()), SLOW_M_S)
        cancels = fastest_alone(moved) >= CANCEL * speed
        along = 0.0 if cancels else float(off @ velocity) / speed
        return float(off @ off) - along * along > (CANCELLED_M if cancels else LEFT_M) ** 2

    def _near(self, q: Array, at: Array) -> float:
        """Rate how near the tool is to its place on the path: 1 where the path goes on as it can, 0 where it waits."""
        return min(max((FAR_M - self._tool.between_m(q, at)) / (FAR_M - NEAR_M), 0.0), 1.0)


def _catching_up(to: Knot, own: float) -> float:
    """The pace that exceeds the hand's own by no more than what may be caught up."""
    return min(own + CATCH_UP * more / max(there, NOTHING) for there, more in zip(to.tool, BOUNDS, strict=True))
