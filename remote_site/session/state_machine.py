"""The session: when the arm may follow the hand, when it must stop, and what ends an engagement; pure."""

from dataclasses import dataclass
from enum import Enum, auto

from common.clock import NS_PER_MS
from common.messages.robot import SessionState
from remote_site.reasons import Code, Reason, reason
from remote_site.safety.config import FULL_SPEED_MS, SafetyConfig
from remote_site.session.config import EngagementConfig, EngagementMode
from remote_site.session.hold_to_run import HoldToRun
from remote_site.session.lease import Lease
from remote_site.session.samples import Accepted, Rejected

FOLLOWING = (SessionState.ENGAGED, SessionState.HOLDING)
REPEATS = (Code.DUPLICATE, Code.OLD)  # they say nothing about the hand
CLOCK_TROUBLE = (Code.NO_OFFSET, Code.OLD_OFFSET, Code.FUTURE)  # how old the hand is cannot be told
INPUTS = {EngagementMode.HOLD_TO_RUN: "key", EngagementMode.PEDAL: "pedal"}
FOLLOWS = reason(Code.OK)


class Action(Enum):
    """What the caller does this tick."""

    CAPTURE = auto()  # take the newest accepted sample and the commanded tool pose as origins, then follow
    FOLLOW = auto()
    STOP = auto()  # the jerk-limited stop; at rest, stay


@dataclass(frozen=True, slots=True)
class Robot:
    """What the session needs to know of the robot: can it take commands (why not), and does the commanded arm rest."""

    ready: bool
    reason: str
    resting: bool


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

    Feed every intake result to `sample`, the lease in force to `authorise`, and call `tick` once per control tick. What
    a loss ended never starts again by itself: automatic engagement fires once, any other end of an engagement, or a new
    local session, disarms it, and a key or pedal has to be let go and pressed anew.
    """

    def __init__(self, safety: SafetyConfig, engagement: EngagementConfig) -> None:
        self._soft_ns = round(safety.t_soft_ms * NS_PER_MS)
        self._latch_ns = round(safety.t_latch_ms * NS_PER_MS)
        self._engagement = engagement
        self.speed_scale = min(1.0, FULL_SPEED_MS / safety.t_soft_ms)
        self.state = SessionState.DISENGAGED
        self.engagements = 0
        self._reason = reason(Code.NOT_ENGAGED)
        self._armed = engagement.mode is EngagementMode.AUTOMATIC
        self._input = INPUTS.get(engagement.mode)
        self._hold = HoldToRun()
        self._lease: Lease | None = None
        self._requested = False
        self._good = 0
        self._born_ns: int | None = None
        self._ticked_ns: int | None = None
        self._trouble: Reason | None = None
        self._stopped: Reason | None = None

    @property
    def held(self) -> bool:
        """Whether the operator holds down the key or pedal, as far as that counts."""
        return self._hold.held

    def authorise(self, lease: Lease | None) -> None:
        """Take note of the lease in force; the end of the one before ends the engagement, and what it has shown."""
        former, self._lease = self._lease, lease
        if former is None or (lease is not None and lease.number == former.number):
            return
        self._good, self._born_ns, self._trouble = 0, None, None
        self._hold.end()
        if self.state in FOLLOWING:
            self._leave(_latched(reason(Code.LEASE_LOST, holder=former.holder.name)))

    def sample(self, result: Accepted | Rejected) -> None:
        """Take note of a judged sample."""
        if result.new_session:
            self._armed = False
            self._good, self._born_ns = 0, None
            self._leave(reason(Code.NEW_SESSION))
        self._see_intent(result.sample.intent.hold if isinstance(result, Accepted) else result.held)
        if isinstance(result, Accepted):
            self._accept(result)
        elif result.reason.code not in REPEATS:
            self._good = 0
            if result.hand_lost or result.reason.code in CLOCK_TROUBLE:
                self._trouble = result.reason
            if result.latch and self.state in FOLLOWING:
                self._leave(_latched(result.reason))

    def request_engage(self, now_ns: int, robot: Robot) -> Answer:
        """Engage at the next tick, or say what is missing."""
        if self.state in FOLLOWING:
            return Answer(True, self._reason)
        missing = self._barred() or self._missing(now_ns, robot)
        if missing is not None:
            return Answer(False, missing)
        self._requested = True
        return Answer(True, reason(Code.OK))

    def readiness(self, now_ns: int, robot: Robot) -> Answer:
        """Whether the arm follows or could be engaged now, apart from whether the operator wants it; if not, why."""
        if self.state in FOLLOWING:
            return Answer(True, self._reason)
        missing = self._barred() or self._unready(now_ns, robot)
        return Answer(missing is None, missing or reason(Code.READY))

    def request_disengage(self) -> Answer:
        """End the engagement; the arm stops."""
        self._leave(reason(Code.RELEASED))
        return Answer(True, self._reason)

    def stop(self, operator: str) -> Answer:
        """End the engagement, and bar the next one until `reset`; who stopped the arm first is told."""
        self._stopped = self._stopped or reason(Code.STOPPED, operator=operator)
        self._leave(self._stopped)
        return Answer(True, self._stopped)

    def fault(self, cause: str) -> None:
        """The robot or a part of the remote site has failed: no motion until `reset` and a new engagement."""
        self.state, self._reason = SessionState.FAULT, reason(Code.FAULT, cause=cause)
        self._armed = self._requested = False
        self._hold.end()

    def clear_fault(self) -> None:
        """Leave a fault behind; a stop stays in force."""
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
        requested, self._requested = self._requested, False
        paused_ns = now_ns - (self._ticked_ns or now_ns)
        self._ticked_ns = now_ns
        if self.state is SessionState.FAULT:
            return self._decide(Action.STOP)
        if self.state is SessionState.DISENGAGED:
            return self._wait(now_ns, robot, requested)
        if not robot.ready:
            self._leave(_latched(reason(Code.ROBOT_NOT_READY, reason=robot.reason)))
            return self._decide(Action.STOP)
        if self._age_ns(now_ns) > self._latch_ns:
            self._leave(_latched(self._trouble or self._stale(now_ns, self._latch_ns)))
            return self._decide(Action.STOP)
        if paused_ns > self._soft_ns:
            self.state, self._good = SessionState.HOLDING, 0
            return self._decide(Action.STOP, self._paused(paused_ns))
        return self._engaged(now_ns, robot)

    def _accept(self, accepted: Accepted) -> None:
        gap_ns = accepted.born_ns - self._born_ns if self._born_ns is not None else 0
        self._good = self._good + 1 if gap_ns <= self._soft_ns else 1
        self._born_ns = accepted.born_ns
        self._trouble = None

    def _see_intent(self, held: bool | None) -> None:
        """Letting go of the key or pedal ends the engagement at once."""
        if held is not None and self._hold.see(held) and self._input is not None and self.state in FOLLOWING:
            self._leave(reason(Code.LET_GO, input=self._input))
            self._hold.see(held)

    def _wait(self, now_ns: int, robot: Robot, requested: bool) -> Decision:
        if self._age_ns(now_ns) > self._latch_ns:
            self._hold.end()
        missing = self._barred() or self._missing(now_ns, robot)
        if missing is None and (requested or self._armed or self._input is not None):
            self._armed = False
            self.engagements += 1
            self.state = SessionState.ENGAGED
            return self._decide(Action.CAPTURE, reason(Code.OK))
        if self._armed or requested:
            self._reason = missing or reason(Code.READY)
        return self._decide(Action.STOP)

    def _engaged(self, now_ns: int, robot: Robot) -> Decision:
        unwell = self._unwell(now_ns)
        if unwell is not None:
            self.state = SessionState.HOLDING
            return self._decide(Action.STOP, unwell)
        if self.state is SessionState.ENGAGED:
            return self._decide(Action.FOLLOW, FOLLOWS)
        if self._good < self._engagement.resume_frames:
            return self._decide(Action.STOP, self._collecting(self._engagement.resume_frames))
        if not robot.resting:
            return self._decide(Action.STOP, reason(Code.MOVING))
        self.state = SessionState.ENGAGED
        return self._decide(Action.CAPTURE, reason(Code.OK))

    def _missing(self, now_ns: int, robot: Robot) -> Reason | None:
        """What engagement still lacks, of readiness or of the operator's intent."""
        return self._unready(now_ns, robot) or self._unwanted()

    def _unwanted(self) -> Reason | None:
        if self._input is None or self._hold.held:
            return None
        return reason(Code.NOT_HELD if self._hold.armed else Code.LET_GO_FIRST, input=self._input)

    def _unready(self, now_ns: int, robot: Robot) -> Reason | None:
        if self._lease is None:
            return reason(Code.NO_LEASE)
        if not robot.ready:
            return reason(Code.ROBOT_NOT_READY, reason=robot.reason)
        if not robot.resting:
            return reason(Code.MOVING)
        if (unwell := self._unwell(now_ns)) is not None:
            return unwell
        if self._good < self._engagement.frames:
            return self._collecting(self._engagement.frames)
        return None

    def _unwell(self, now_ns: int) -> Reason | None:
        """Why the newest hand sample is nothing to follow."""
        if self._trouble is not None:
            return self._trouble
        if self._born_ns is None:
            return reason(Code.NO_HAND)
        return self._stale(now_ns, self._soft_ns) if self._age_ns(now_ns) > self._soft_ns else None

    def _barred(self) -> Reason | None:
        """The fault or the stop that has to be reset first."""
        return self._reason if self.state is SessionState.FAULT else self._stopped

    def _age_ns(self, now_ns: int) -> int:
        return now_ns - self._born_ns if self._born_ns is not None else self._latch_ns + 1

    def _stale(self, now_ns: int, limit_ns: int) -> Reason:
        return reason(Code.STALE, age_ms=self._age_ns(now_ns) / NS_PER_MS, limit_ms=limit_ns / NS_PER_MS)

    def _paused(self, paused_ns: int) -> Reason:
        return reason(Code.PAUSED, paused_ms=paused_ns / NS_PER_MS, limit_ms=self._soft_ns / NS_PER_MS)

    def _collecting(self, needed: int) -> Reason:
        return reason(Code.COLLECTING, count=min(self._good, needed), needed=needed)

    def _leave(self, why: Reason) -> None:
        if self.state is SessionState.FAULT:
            return
        self.state = SessionState.DISENGAGED
        self._armed = self._requested = False
        self._hold.end()
        self._reason = self._stopped or why

    def _decide(self, action: Action, why: Reason | None = None) -> Decision:
        if why is not None:
            self._reason = why
        return Decision(self.state, action, self._reason)


def _latched(cause: Reason) -> Reason:
    return reason(Code.LATCHED, cause=cause.sentence)
