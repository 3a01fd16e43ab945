"""The session's state machine: when the arm may follow the hand, when it stops, what ends an engagement; pure."""

from dataclasses import dataclass
from enum import Enum, auto
from typing import NamedTuple

from common.clock import NS_PER_MS
from common.messages.robot import SessionState
from remote_site.drivers.faults import RobotFault
from remote_site.kinematics.joints import JointMotion
from remote_site.reasons import Code, Reason, reason
from remote_site.safety.config import SafetyConfig
from remote_site.session.config import EngagementConfig
from remote_site.session.engagement_intent import EngagementIntent
from remote_site.session.hand_signal import HandSignal
from remote_site.session.lease import Lease
from remote_site.session.samples import Accepted, Rejected

FOLLOWING = (SessionState.ENGAGED, SessionState.HOLDING)
FOLLOWS = reason(Code.OK)


class Action(Enum):
    """What the caller does this tick."""

    CAPTURE = auto()  # take the newest accepted sample and the commanded tool pose as origins, then follow
    FOLLOW = auto()
    STOP = auto()  # the jerk-limited stop; at rest, stay


class Robot(NamedTuple):
    """The robot as the session sees it: why it takes no commands, None while it does, and what it was sent last."""

    fault: RobotFault | None
    sent: JointMotion

    @property
    def ready(self) -> bool:
        """The robot takes commands."""
        return self.fault is None

    @property
    def reason(self) -> str:
        """Why it takes no commands, empty while it does."""
        return str(self.fault or "")

    @property
    def resting(self) -> bool:
        """The commanded arm is at rest."""
        return self.sent.resting


@dataclass(frozen=True, slots=True)
class Decision:
    """The outcome of a tick: state, what to do, and why."""

    state: SessionState
    action: Action
    reason: Reason


@dataclass(frozen=True, slots=True)
class Answer:
    """The answer to a request of the operator."""

    done: bool
    reason: Reason


class Session:
    """DISENGAGED -> ENGAGED <-> HOLDING -> DISENGAGED, FAULT above all; time comes in as nanoseconds of one clock.

    Feed every validated sample to `sample`, the lease in force to `authorise`, and call `tick` once per control tick.
    What a loss ended never starts again by itself: automatic engagement happens once; any other end of an engagement,
    or a new local session, disarms it, and a key or pedal has to be released and pressed again.
    """

    def __init__(self, safety: SafetyConfig, engagement: EngagementConfig) -> None:
        self._engagement = engagement
        self._hand = HandSignal(safety)
        self._intent = EngagementIntent(engagement.mode)
        self.state = SessionState.DISENGAGED
        self.engagements = 0
        self._reason = reason(Code.NOT_ENGAGED)
        self._lease: Lease | None = None
        self._stopped: Reason | None = None
        self._ticked_ns: int | None = None

    @property
    def held(self) -> bool:
        """Whether the operator holds down the key or pedal, as far as that counts."""
        return self._intent.hold.held

    def authorise(self, lease: Lease | None) -> None:
        """Take note of the lease in force; the end of the former one ends the engagement, and forgets its samples."""
        former, self._lease = self._lease, lease
        if former is None or (lease is not None and lease.number == former.number):
            return
        self._hand.forget()
        self._intent.hold.end()
        if self.state in FOLLOWING:
            self._leave(_latched(reason(Code.LEASE_LOST, holder=former.holder.name)))

    def sample(self, result: Accepted | Rejected) -> None:
        """Take note of a judged sample."""
        if result.new_session:
            self._intent.armed = False
            self._hand.restart()
            self._leave(reason(Code.NEW_SESSION))
        self._see_intent(result.sample.intent.hold if isinstance(result, Accepted) else result.held)
        self._hand.take(result)
        if isinstance(result, Rejected) and result.latch and self.state in FOLLOWING:
            self._leave(_latched(result.reason))

    def request_engage(self, now_ns: int, robot: Robot) -> Answer:
        """Engage at the next tick, or state what is missing."""
        if self.state in FOLLOWING:
            return Answer(True, self._reason)
        missing = self._barred() or self._missing(now_ns, robot)
        if missing is not None:
            return Answer(False, missing)
        self._intent.requested = True
        return Answer(True, reason(Code.OK))

    def readiness(self, now_ns: int, robot: Robot) -> Answer:
        """Whether the arm follows or could be engaged now, apart from the operator's intent; if not, why."""
        if self.state in FOLLOWING:
            return Answer(True, self._reason)
        missing = self._barred() or self._unready(now_ns, robot)
        return Answer(missing is None, missing or reason(Code.READY))

    def request_disengage(self) -> Answer:
        """End the engagement; the arm stops."""
        self._leave(reason(Code.RELEASED))
        return Answer(True, self._reason)

    def stop(self, operator: str) -> Answer:
        """End the engagement, and bar the next one until `reset`; the first who stopped the arm is named."""
        self._stopped = self._stopped or reason(Code.STOPPED, operator=operator)
        self._leave(self._stopped)
        return Answer(True, self._stopped)

    def fault(self, cause: str) -> None:
        """The robot or a part of the remote site has failed: no motion until `reset` and a new engagement."""
        self.state, self._reason = SessionState.FAULT, reason(Code.FAULT, cause=cause)
        self._intent.end()

    def clear_fault(self) -> None:
        """Clear a fault; a stop stays in force."""
        if self.state is SessionState.FAULT:
            self.state, self._reason = SessionState.DISENGAGED, self._stopped or reason(Code.NOT_ENGAGED)

    def reset(self) -> Answer:
        """Clear a fault and a stop; engaging is a request of its own."""
        if self._stopped is not None and self.state is SessionState.DISENGAGED:
            self._reason = reason(Code.RESET)
        self._stopped = None
        self.clear_fault()
        return Answer(True, self._reason)

    def tick(self, now_ns: int, robot: Robot) -> Decision:
        """Decide what this tick does."""
        requested, self._intent.requested = self._intent.requested, False
        paused_ns = now_ns - (self._ticked_ns or now_ns)
        self._ticked_ns = now_ns
        if self.state is SessionState.FAULT:
            return self._decide(Action.STOP)
        if self.state is SessionState.DISENGAGED:
            return self._wait(now_ns, robot, requested)
        if not robot.ready:
            self._leave(_latched(reason(Code.ROBOT_NOT_READY, reason=robot.reason)))
            return self._decide(Action.STOP)
        if (too_old := self._hand.too_old(now_ns)) is not None:
            self._leave(_latched(too_old))
            return self._decide(Action.STOP)
        if paused_ns > self._hand.soft_ns:
            self.state, self._hand.good = SessionState.HOLDING, 0
            limit_ms = self._hand.soft_ns / NS_PER_MS
            return self._decide(Action.STOP, reason(Code.PAUSED, paused_ms=paused_ns / NS_PER_MS, limit_ms=limit_ms))
        return self._engaged(now_ns, robot)

    def _see_intent(self, held: bool | None) -> None:
        """Releasing the key or pedal ends the engagement immediately."""
        if held is not None and self._intent.released(held) and self.state in FOLLOWING:
            self._leave(reason(Code.LET_GO, input=self._intent.input))
            self._intent.released(held)

    def _wait(self, now_ns: int, robot: Robot, requested: bool) -> Decision:
        intent = self._intent
        if self._hand.too_old(now_ns) is not None:
            intent.hold.end()
        missing = self._barred() or self._missing(now_ns, robot)
        if missing is None and (requested or intent.armed or intent.input is not None):
            intent.armed = False
            self.engagements += 1
            self.state = SessionState.ENGAGED
            return self._decide(Action.CAPTURE, reason(Code.OK))
        if intent.armed or requested:
            self._reason = missing or reason(Code.READY)
        return self._decide(Action.STOP)

    def _engaged(self, now_ns: int, robot: Robot) -> Decision:
        unfit = self._hand.unfit(now_ns)
        if unfit is not None:
            self.state = SessionState.HOLDING
            return self._decide(Action.STOP, unfit)
        if self.state is SessionState.ENGAGED:
            return self._decide(Action.FOLLOW, FOLLOWS)
        if (collecting := self._hand.collecting(self._engagement.resume_frames)) is not None:
            return self._decide(Action.STOP, collecting)
        if not robot.resting:
            return self._decide(Action.STOP, reason(Code.MOVING))
        self.state = SessionState.ENGAGED
        return self._decide(Action.CAPTURE, reason(Code.OK))

    def _missing(self, now_ns: int, robot: Robot) -> Reason | None:
        """What an engagement still lacks, of readiness or of the operator's intent."""
        return self._unready(now_ns, robot) or self._intent.lacking()

    def _unready(self, now_ns: int, robot: Robot) -> Reason | None:
        if self._lease is None:
            return reason(Code.NO_LEASE)
        if not robot.ready:
            return reason(Code.ROBOT_NOT_READY, reason=robot.reason)
        if not robot.resting:
            return reason(Code.MOVING)
        return self._hand.unfit(now_ns) or self._hand.collecting(self._engagement.frames)

    def _barred(self) -> Reason | None:
        """The fault or the stop that has to be reset first."""
        return self._reason if self.state is SessionState.FAULT else self._stopped

    def _leave(self, why: Reason) -> None:
        if self.state is SessionState.FAULT:
            return
        self.state = SessionState.DISENGAGED
        self._intent.end()
        self._reason = self._stopped or why

    def _decide(self, action: Action, why: Reason | None = None) -> Decision:
        if why is not None:
            self._reason = why
        return Decision(self.state, action, self._reason)


def _latched(cause: Reason) -> Reason:
    return reason(Code.LATCHED, cause=cause.sentence)
