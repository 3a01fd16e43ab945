"""Publishes the robot's state: which hand sample it obeys, when that moved it; at a pace that a long link takes."""

import math
import secrets
from collections.abc import Callable, Mapping

from msgspec.structs import replace

from common.clock import NS_PER_MS
from common.link.pubsub import Publisher
from common.messages.base import SESSION_BITS
from common.messages.robot import (
    Asker,
    LeaseState,
    LoopTiming,
    Pose,
    Readiness,
    RobotState,
    SessionState,
)
from common.process.link_log import LinkLog
from common.process.run_summary import RunSummary
from remote_site.kinematics.model import ArmModel
from remote_site.reasons import Code
from remote_site.recording.taps import ControlTap
from remote_site.runtime.driven_pipeline import DrivenPipeline
from remote_site.runtime.rate import Rate
from remote_site.runtime.site_memory import SiteMemory
from remote_site.runtime.tracing import Tracing
from remote_site.runtime.transition_log import TransitionLog
from remote_site.safety.collision import CollisionModel
from remote_site.session.hand_link_verdict import judged
from remote_site.session.lease import LeaseStatus
from remote_site.teleop.cycle import Snapshot

HEADER_BYTES = 100  # of Zenoh, QUIC, UDP and IP
LEAST_WINDOW_BYTES = 2 * 1200
UNKNOWN_MS = 120.0  # half a round trip, as long as no sample under a lease has shown it: a long way
SHARE = 0.65  # of the window; the rest is for answers, and for samples that take longer than most
LATE_PERCENTILE = 99.0
STATES_PER_TIMING = 50  # ordering thousands of latenesses does not belong in every tick


class StatePace:
    """Keeps the states within what always passes, so that none waits behind others.

    Where packets get lost, the congestion control of QUIC falls back to two packets per round trip (RFC 9002, section
    7.2), of at least 1200 bytes (RFC 9000, section 14). States go before answers there: more of them would leave none
    for the clock, the description and the lease. A change of the session's state or its code, and a halt, are never
    held back.
    """

    def __init__(self) -> None:
        self._sent_ns, self._bytes = 0, 0
        self._said: tuple[SessionState, Code, int] | None = None

    def is_due(self, now_ns: int, says: tuple[SessionState, Code, int], network_ms: float | None) -> bool:
        """Return whether to send the state now, which then counts as sent.

        `says` is the session's state with its code and its newest halt, `network_ms` half a round trip, None while it
        is not known.
        """
        way_ms = UNKNOWN_MS if network_ms is None else network_ms
        period_ns = 2 * way_ms * NS_PER_MS * self._bytes / (SHARE * LEAST_WINDOW_BYTES)
        if says == self._said and now_ns - self._sent_ns < period_ns:
            return False
        self._sent_ns, self._said = now_ns, says
        return True

    def sent(self, payload_bytes: int) -> None:
        """The state that was due had this size; the next one waits as long as that takes."""
        self._bytes = payload_bytes + HEADER_BYTES


class StateLog:
    """Logs what changes from state to state: the session, its links and limits; `summary` counts what was published."""

    def __init__(self) -> None:
        self._session, self._link = TransitionLog(), LinkLog()
        self.summary = RunSummary()

    def note_tick(self, snapshot: Snapshot) -> None:
        """Note a tick, whether or not its state is published."""
        self._session.note(snapshot.state, snapshot.reason, snapshot.halted_ns, snapshot.now_ns)

    def note_published(self, state: RobotState, now_ns: int) -> None:
        """Note a state that was published."""
        readiness = state.readiness
        self._link.note_limit(state.age_limit_ms, state.speed_scale, readiness.code, readiness.reason)
        self._link.note(state.hand_link, state.video_link, now_ns)
        self.summary.note(state, now_ns)


class Reporter:
    """Publishes RobotState with the times of the obeyed samples, logs it, and shares the lease in force."""

    def __init__(
        self,
        publisher: Publisher[RobotState],
        site: SiteMemory,
        model: ArmModel,
        collision: CollisionModel,
        measure_timing: Callable[[], LoopTiming],
        *,
        one_host: bool,
        tap: ControlTap | None = None,
    ) -> None:
        self._one_host, self._tap = one_host, tap
        self._publisher = publisher
        self._site = site
        self._model = model
        self._collision = collision
        self._measure_timing = measure_timing
        self._session = secrets.randbits(SESSION_BITS)
        self._seq = 0
        self._tracing = Tracing()
        self._timing = measure_timing()
        self.log = StateLog()

    def note(self, snapshot: Snapshot, driven: DrivenPipeline) -> None:
        """Note the command that first obeys a sample, and the reading that first shows it in the robot's motion."""
        self.log.note_tick(snapshot)
        if snapshot.obeys is not None:
            self._tracing.obey(snapshot.obeys, driven.seq, snapshot.now_ns, driven.sent)
        self._tracing.see(driven.report)

    def publish(self, snapshot: Snapshot, driven: DrivenPipeline, malformed: Mapping[str, int]) -> int:
        """Send the robot's state as measured and commanded; its size in bytes."""
        self._seq += 1
        if self._seq % STATES_PER_TIMING == 0:
            self._timing = self._measure_timing()
        self._site.show_lease(snapshot.lease.lease)
        state = self._completed(self._state(snapshot, driven, malformed), snapshot, driven)
        self._publisher.put(state)
        self.log.note_published(state, snapshot.now_ns)
        return self._publisher.payload_bytes

    def _state(self, snapshot: Snapshot, driven: DrivenPipeline, malformed: Mapping[str, int]) -> RobotState:
        """Build what every state has: the robot, the session, and how well the loop runs."""
        report, reason = driven.report, snapshot.reason
        return RobotState(
            session=self._session,
            seq=self._seq,
            t_ns=report.t_ns,
            state=snapshot.state,
            code=reason.code.value,
            reason=reason.sentence,
            age_limit_ms=snapshot.age_limit_ms,
            speed_scale=snapshot.speed_scale,
            q=tuple(report.q.tolist()),
            q_commanded=tuple(driven.sent.q.tolist()),
            base_T_tool=Pose.from_transform(self._model.forward(report.q)),
            gripper=report.gripper,
            gripper_toggles_applied=snapshot.gripper_toggles,
            gripper_next=snapshot.gripper_next,
            obeyed=self._tracing.reported(),
            engagement=snapshot.engagement,
            rejected={code.value: count for code, count in snapshot.rejected.items()} | dict(malformed),
            timing=self._timing,
            lease=_lease(snapshot.lease),
            clock=snapshot.clock,
            readiness=_readiness(snapshot),
        )

    def _completed(self, state: RobotState, snapshot: Snapshot, driven: DrivenPipeline) -> RobotState:
        """The same with what not every state has: of an arm that follows, its links, and what a site is set up for."""
        follows = snapshot.state is SessionState.ENGAGED
        return replace(
            state,
            min_distance=_finite(self._collision.distance(driven.report.q)),
            target=Pose.from_transform(snapshot.target) if follows else None,
            traced=self._tracing.traced,
            settings=snapshot.settings,
            reference=snapshot.reference if follows else None,
            hand_link=judged(snapshot.hand_link, snapshot.age_limit_ms, one_host=self._one_host),
            video_link=self._site.video_link,
            assist=snapshot.assist,
            recording=self._tap.state(snapshot.now_ns) if self._tap is not None else None,
            halted_ns=snapshot.halted_ns,
        )


def loop_timing(rate: Rate, *, real_time: bool) -> LoopTiming:
    """Report how well the control loop keeps its rate, and whether the kernel schedules it in real time."""
    return LoopTiming(rate.hz, rate.late_us(LATE_PERCENTILE), rate.missed, rate.ticks, real_time)


def _readiness(snapshot: Snapshot) -> Readiness:
    answer = snapshot.readiness
    return Readiness(answer.done, answer.reason.code.value, answer.reason.sentence, snapshot.held)


def _lease(status: LeaseStatus) -> LeaseState | None:
    lease, asker = status.lease, status.asker
    if lease is None:
        return None
    holder, asked_by = lease.holder, Asker(asker.name, asker.session) if asker is not None else None
    return LeaseState(lease.number, holder.name, holder.session, lease.expires_ns, asked_by)


def _finite(distance: float) -> float | None:
    return distance if math.isfinite(distance) else None
