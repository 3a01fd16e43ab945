"""The session's state machine: when the arm may follow the hand, when it stops, what ends an engagement; pure."""

from dataclasses import dataclass, replace
from enum import Enum, auto
from typing import NamedTuple

from common.clock import NS_PER_MS
from common.messages.hand import Intent
from common.messages.robot import FOLLOWING, SessionState
from remote_site.drivers.faults import RobotFault
from remote_site.kinematics.joints import JointMotion
from remote_site.reasons import Code, Reason, reason
from remote_site.safety.config import SafetyConfig
from remote_site.safety.turn_watch import LONGEST_TURN_NS, TurnWatch
from remote_site.session.age_limit import AgeLimit
from remote_site.session.config import EngagementConfig
from remote_site.session.engagement_intent import EngagementIntent
from remote_site.session.halts import Halts
from remote_site.session.hand_signal import HandSignal
from remote_site.session.hold import Hold
from remote_site.session.lease import Holder, Lease
from remote_site.session.operator_page import OperatorPage
from remote_site.session.samples import Accepted, Rejected

FOLLOWS = reason(Code.OK)


class Action(Enum):
    """The action that the caller takes in this tick."""

    CAPTURE = auto()  # take the newest accepted sample and the commanded tool pose as origins, then follow
    RESUME = auto()  # after a short hold: go on to the same origins if the hand is near, else as CAPTURE
    FOLLOW = auto()
    STOP = auto()  # the jerk-limited stop; at rest, stay


class Robot(NamedTuple):
    """The robot as the session sees it: why it takes no commands, None while it does, and what it was sent last.

    `site_ready` is whether every process of the remote site has started, `diverted` whether the driver has begun a stop
    by itself since the last command.
    """

    fault: RobotFault | None
    sent: JointMotion
    site_ready: bool = True
    diverted: bool = False

    @property
    def ready(self) -> bool:
        """The robot takes commands."""
        return self.fault is None

    @property
    def reason(self) -> str:
        """The reason why it takes no commands, empty while it does."""
        return str(self.fault or "")

    @property
    def resting(self) -> bool:
        """The commanded arm is at rest."""
        return self.sent.resting


@dataclass(frozen=True, slots=True)
class Decision:
    """The outcome of a tick: state, what to do, and why; `held_since_ns` is when the hold that now ends began.

    `clutched` is whether the operator held the clutch in it, and so moved the hand alone on purpose.
    """

    state: SessionState
    action: Action
    reason: Reason
    held_since_ns: int = 0
    clutched: bool = False


@dataclass(frozen=True, slots=True)
class Answer:
    """The answer to a request of the operator."""

    done: bool
    reason: Reason


class Session:
    """DISENGAGED -> ENGAGED <-> HOLDING -> DISENGAGED, FAULT above all; time comes in as nanoseconds of one clock.

    Feed every validated sample to `sample`, the lease in force to `authorise`, the age limit in force to `limit_age`,
    and call `tick` once per control tick. What a loss ended never starts again by itself: automatic engagement happens
    once, and shortly after the start; any other end of an engagement, a reset or a new local session disarms it, and a
    key or pedal has to be released and pressed again.
    """

    def __init__(self, safety: SafetyConfig, engagement: EngagementConfig, limit: AgeLimit) -> None:
        self._engagement = engagement
        self._hand = HandSignal(safety, limit, engagement.frames)
        self._intent = EngagementIntent(engagement.mode)
        self.page = OperatorPage()
        self._hold = Hold(safety)
        self.state = SessionState.DISENGAGED
        self.engagements = 0
        self._reason = reason(Code.NOT_ENGAGED)
        self._lease: Lease | None = None
        self._holder: Holder | None = None
        self.halts = Halts()
        self._ticks = TurnWatch()

    @property
    def held(self) -> bool:
        """Return whether the operator holds down the key or pedal, as far as that counts."""
        return self._intent.hold.held

    @property
    def barred(self) -> bool:
        """A fault or a stop has to be reset before anything moves."""
        return self.halts.reason is not None

    def unseen(self, seen_ns: int, act: str) -> Reason | None:
        """Say why who was shown the halt at `seen_ns` may not `act`; None where no other has come since."""
        return self.halts.unseen(seen_ns, act, self._reason.sentence)

    def authorise(self, lease: Lease | None) -> None:
        """Take note of the lease in force; the end of the former one ends the engagement, and forgets its samples."""
        former, self._lease = self._lease, lease
        if lease is not None:
            self.page.begin(lease.number)
            if lease.holder != self._holder:
                self._holder = lease.holder
                self._hand.distrust()
        if former is None or (lease is not None and lease.number == former.number):
            return
        self._hand.forget()
        self._intent.hold.end()
        if self.state in FOLLOWING:
            self._leave(_latched(reason(Code.LEASE_LOST, holder=former.holder)))

    def limit_age(self, limit: AgeLimit) -> None:
        """Take note of the age limit in force."""
        self._hand.limit_age(limit)

    def sample(self, result: Accepted | Rejected) -> None:
        """Take note of a judged sample."""
        if result.new_session:
            self._intent.armed = False
            self._hand.restart()
            self._leave(reason(Code.NEW_SESSION, holder=self._holder or "another site"))
        if result.sample is not None:
            self._see_intent(result.sample.intent)
        self.page.clutch.observe(result, self._hand.soft_ns)
        self._hand.observe(result)
        if isinstance(result, Rejected):
            self._hold.note(result.reason)
        if self._page_silence() is not None:
            self._hand.distrust()
        if isinstance(result, Rejected) and result.latch and self.state in FOLLOWING:
            self._leave(_latched(result.reason))

    def request_engage(self, now_ns: int, robot: Robot) -> Answer:
        """Engage at the next tick, or state what is missing."""
        if self.state in FOLLOWING:
            return Answer(True, self._reason)
        missing = self.halts.reason or self._missing(now_ns, robot)
        if missing is not None:
            return Answer(False, missing)
        self._intent.requested = True
        return Answer(True, reason(Code.OK))

    def readiness(self, now_ns: int, robot: Robot) -> Answer:
        """Tell whether the arm follows or could be engaged now, apart from the operator's intent; if not, why."""
        if self.state in FOLLOWING:
            return Answer(True, self._reason)
        missing = self.halts.reason or self._unready(now_ns, robot)
        return Answer(missing is None, missing or reason(Code.READY))

    def request_disengage(self, now_ns: int) -> Answer:
        """End the engagement; the arm stops."""
        self.halts.note(now_ns)
        self._leave(reason(Code.RELEASED))
        return Answer(True, self._reason)

    def stop(self, operator: str, now_ns: int) -> Answer:
        """End the engagement, and bar the next one until `reset`; all who stop the arm are named, in a fault too."""
        if self.state is not SessionState.FAULT:
            self.state = SessionState.DISENGAGED
        return Answer(True, self._bar(self.halts.stop(operator, now_ns)))

    def fault(self, cause: str, now_ns: int) -> None:
        """The robot or a part of the remote site has failed: no motion until `reset` and a new engagement.

        The first cause is kept; what follows from it does not replace it.
        """
        if self.state is SessionState.FAULT:
            return
        self.state = SessionState.FAULT
        self._bar(self.halts.fail(cause, now_ns))

    def reset(self) -> Answer:
        """Clear a fault and a stop, and end all holding; engaging is a request or a press of its own."""
        self.halts.clear()
        self.state, self._reason = SessionState.DISENGAGED, reason(Code.RESET)
        self._intent.end()
        return Answer(True, self._reason)

    def tick(self, now_ns: int, robot: Robot) -> Decision:
        """Decide what this tick does."""
        requested, self._intent.requested = self._intent.requested, False
        self._ticks.note(now_ns)
        paused_ns = self._ticks.took_ns
        if robot.diverted:
            self._hold.divert(now_ns)
        if self.state in FOLLOWING and (slow := self._slow()) is not None:
            self.fault(slow.sentence, now_ns)
        if self.state is SessionState.FAULT:
            return self._decide(Action.STOP)
        if self.state is SessionState.DISENGAGED:
            return self._wait(now_ns, robot, requested)
        if (ended := self._ended(now_ns, robot)) is not None:
            self._leave(ended)
            return self._decide(Action.STOP)
        if paused_ns > self._hand.soft_ns:
            self._hand.distrust()
            limit_ms = self._hand.soft_ns / NS_PER_MS
            return self._stop(now_ns, reason(Code.PAUSED, paused_ms=paused_ns / NS_PER_MS, limit_ms=limit_ms))
        return self._engaged(now_ns, robot)

    def _see_intent(self, intent: Intent | None) -> None:
        """Releasing the key or pedal ends the engagement immediately, and so does a page that reports no more."""
        self.page.see(intent)
        held = intent.hold if intent is not None else None
        if self._intent.released(held) and self.state in FOLLOWING:
            self._leave(reason(Code.LET_GO, input=self._intent.input))
            self._intent.released(held)

    def _wait(self, now_ns: int, robot: Robot, requested: bool) -> Decision:
        intent = self._intent
        if self._hand.too_old(now_ns) is not None:
            intent.hold.end()
        if intent.expires(now_ns, both_ready=robot.site_ready and robot.ready and self._lease is not None):
            self._reason = self.halts.reason or reason(Code.AUTOMATIC_EXPIRED)
        missing = self.halts.reason or self._missing(now_ns, robot)
        if missing is None and (requested or intent.armed or intent.input is not None):
            intent.armed = False
            self.engagements += 1
            self.state = SessionState.ENGAGED
            return self._decide(Action.CAPTURE, reason(Code.OK))
        if intent.armed or requested:
            self._reason = missing or reason(Code.READY)
        return self._decide(Action.STOP)

    def _ended(self, now_ns: int, robot: Robot) -> Reason | None:
        """Say what ends an engagement for good; a hold ends it too when it lasts, whatever trickles in."""
        if not robot.ready:
            return reason(Code.ROBOT_NOT_READY, reason=robot.reason)
        if (too_old := self._hand.too_old(now_ns)) is not None:
            return _latched(too_old)
        too_long = self._hold.too_long(now_ns, self._reason) if self.state is SessionState.HOLDING else None
        return _latched(too_long) if too_long is not None else None

    def _stop(self, now_ns: int, why: Reason) -> Decision:
        """Hold: stop, and resume when the hand is good again."""
        if self.state is not SessionState.HOLDING:
            self.state = SessionState.HOLDING
            self._hold.begin(now_ns, why)
            self._hand.recount()
        self._hold.note(why)
        if why.code is Code.CLUTCHED:
            self._hold.prolong(now_ns)
        return self._decide(Action.STOP, why)

    def _engaged(self, now_ns: int, robot: Robot) -> Decision:
        unfit = self._hand.unfit(now_ns) or self._page_silence() or self.page.clutch.reason()
        if unfit is not None:
            return self._stop(now_ns, unfit)
        if self.state is SessionState.ENGAGED:
            return self._decide(Action.FOLLOW, FOLLOWS)
        waits = self._hand.collecting(self._engagement.resume_frames) or self._hold.unearned(now_ns)
        if waits is not None:
            return self._decide(Action.STOP, waits)
        if not robot.resting:
            return self._decide(Action.STOP, reason(Code.MOVING))
        self.state = SessionState.ENGAGED
        action = Action.RESUME if self._hold.short(now_ns) else Action.CAPTURE
        follows = self._decide(action, reason(Code.OK))
        return replace(follows, held_since_ns=self._hold.began_ns, clutched=self._hold.clutched)

    def _missing(self, now_ns: int, robot: Robot) -> Reason | None:
        """Say what an engagement still lacks, of readiness or of the operator's intent."""
        return self._unready(now_ns, robot) or self._intent.lacking()

    def _unready(self, now_ns: int, robot: Robot) -> Reason | None:
        if not robot.site_ready:
            return reason(Code.SITE_STARTING)
        if self._lease is None:
            return reason(Code.NO_LEASE)
        if (slow := self._slow()) is not None:
            return slow
        if not robot.ready:
            return reason(Code.ROBOT_NOT_READY, reason=robot.reason)
        if not robot.resting:
            return reason(Code.MOVING)
        unfit = self._hand.too_slow() or self._hand.unfit(now_ns) or self._page_silence()
        unfit = unfit or self.page.clutch.reason() or self._hand.unanswered(now_ns)
        return unfit or self._hand.collecting(self._hand.frames)

    def _slow(self) -> Reason | None:
        """Say why control is too slow to lead an arm; None while it keeps up."""
        took_ms, limit_ms = self._ticks.slow_ns / NS_PER_MS, LONGEST_TURN_NS / NS_PER_MS
        return reason(Code.SLOW, who="control", took_ms=took_ms, limit_ms=limit_ms) if took_ms else None

    def _page_silence(self) -> Reason | None:
        """Say why the arm waits for the operator's page; with hold-to-run or a pedal silence is a release instead."""
        return reason(Code.PAGE_SILENT) if self.page.silent and self._intent.input is None else None

    def _bar(self, why: Reason) -> Reason:
        self._reason = why
        self._intent.end()
        return why

    def _leave(self, why: Reason) -> None:
        if self.state is SessionState.FAULT:
            return
        self.state = SessionState.DISENGAGED
        self._intent.end()
        self._reason = self.halts.reason or why

    def _decide(self, action: Action, why: Reason | None = None) -> Decision:
        if why is not None:
            self._reason = why
        return Decision(self.state, action, self._reason)


def _latched(cause: Reason) -> Reason:
    return reason(Code.LATCHED, cause=cause.sentence)
