"""Publishes the robot's state: which hand sample it obeys, and when that sample moved it."""

import contextvars
import math
import secrets
import threading
from collections import Counter
from collections.abc import Callable, Mapping
from queue import SimpleQueue

import structlog

from common.errors import MessageError
from common.link.transport import Publisher
from common.messages.robot import (
    LeaseState,
    LoopTiming,
    Pose,
    Readiness,
    RobotState,
    SessionState,
)
from common.process.rate import Rate
from remote_site.config import RemoteConfig
from remote_site.kinematics.limits import load_arm
from remote_site.reasons import Reason
from remote_site.runtime.driven_pipeline import DrivenPipeline
from remote_site.runtime.tracing import Tracing
from remote_site.safety.collision import CollisionModel
from remote_site.session.lease import LeaseStatus
from remote_site.session.shared_lease import NOBODY, SharedLease
from remote_site.teleop.cycle import Snapshot

SESSION_BITS = 62
LATE_PERCENTILE = 99.0
STATES_PER_TIMING = 50  # ordering thousands of latenesses does not belong in every tick


class TransitionLog:
    """Writes every change of the session's state to the log from a thread of its own: no tick waits for a log."""

    def __init__(self) -> None:
        self._queue: SimpleQueue[Callable[[], object]] = SimpleQueue()
        self._state: SessionState | None = None
        context = contextvars.copy_context()
        threading.Thread(target=context.run, args=(self._write_for_ever,), name="log", daemon=True).start()

    def note(self, state: SessionState, reason: Reason) -> None:
        """Note the state of a tick."""
        if state is not self._state:
            self._state = state
            log = structlog.get_logger()
            words = {"state": state.value, "code": reason.code.value, "reason": reason.sentence}
            self._queue.put(lambda: log.info("session", **words))

    def warn(self, event: str, sentence: str) -> None:
        """Write a warning."""
        self._queue.put(lambda: structlog.get_logger().warning(event, reason=sentence))

    def _write_for_ever(self) -> None:
        while True:
            self._queue.get()()


class Refusals:
    """Counts payloads that were no message by reason, and tells the first of each in the log."""

    def __init__(self, log: TransitionLog) -> None:
        self.counts: Counter[str] = Counter()
        self._log = log

    def note(self, error: MessageError) -> None:
        """Count one."""
        if not self.counts[error.reason]:
            self._log.warn("a message is refused", str(error))
        self.counts[error.reason] += 1


class Reporter:
    """Publishes RobotState with the times of the obeyed samples, and shares which lease is in force."""

    def __init__(
        self,
        publisher: Publisher[RobotState],
        shared_lease: SharedLease,
        config: RemoteConfig,
        rate: Rate,
        *,
        real_time: bool,
    ) -> None:
        self._publisher = publisher
        self._shared_lease = shared_lease
        self._model, _ = load_arm(config.robot)
        robot = config.robot
        # of its own: what is measured for a report must not touch what the pipeline has cached
        self._collision = CollisionModel.from_urdf(robot.urdf, self._model, robot.capsules, config.safety.collision)
        self._rate = rate
        self._real_time = real_time
        self._session = secrets.randbits(SESSION_BITS)
        self._seq = 0
        self._tracing = Tracing()
        self._timing = self._measured_timing()
        self.log = TransitionLog()

    def note(self, snapshot: Snapshot, driven: DrivenPipeline) -> None:
        """Note the command that first obeys a sample, and the reading that first shows it in the robot's motion."""
        self.log.note(snapshot.state, snapshot.reason)
        if snapshot.obeys is not None:
            self._tracing.obey(snapshot.obeys, driven.seq, snapshot.now_ns, driven.sent)
        self._tracing.see(driven.report)

    def publish(self, snapshot: Snapshot, driven: DrivenPipeline, malformed: Mapping[str, int]) -> None:
        """Send the robot's state as measured and commanded."""
        self._seq += 1
        if self._seq % STATES_PER_TIMING == 0:
            self._timing = self._measured_timing()
        lease, report = _lease(snapshot.lease), driven.report
        self._shared_lease.show(lease.number if lease is not None else NOBODY)
        answer = snapshot.readiness
        self._publisher.put(
            RobotState(
                session=self._session,
                seq=self._seq,
                t_ns=report.t_ns,
                state=snapshot.state,
                code=snapshot.reason.code.value,
                reason=snapshot.reason.sentence,
                joints=self._model.joint_names,
                q=tuple(report.q.tolist()),
                q_commanded=tuple(driven.sent.q.tolist()),
                base_T_tool=Pose.from_transform(self._model.forward(report.q)),
                gripper=report.gripper,
                gripper_toggles_applied=snapshot.gripper_toggles,
                obeyed=self._tracing.reported(),
                engagement=snapshot.engagement,
                rejected={code.value: count for code, count in snapshot.rejected.items()} | dict(malformed),
                timing=self._timing,
                lease=lease,
                clock=snapshot.clock,
                readiness=Readiness(answer.done, answer.reason.code.value, answer.reason.sentence, snapshot.held),
                min_distance=_finite(self._collision.distance(report.q)),
                target=Pose.from_transform(snapshot.target) if snapshot.state is SessionState.ENGAGED else None,
                traced=self._tracing.traced,
            )
        )

    def _measured_timing(self) -> LoopTiming:
        rate = self._rate
        late_us = rate.late_us(LATE_PERCENTILE)
        return LoopTiming(rate.hz, late_us, rate.missed, rate.ticks, self._real_time)


def _lease(status: LeaseStatus) -> LeaseState | None:
    lease, asker = status.lease, status.asker
    if lease is None:
        return None
    holder = lease.holder
    return LeaseState(lease.number, holder.name, holder.session, lease.expires_ns, asker.name if asker else None)


def _finite(distance: float) -> float | None:
    return distance if math.isfinite(distance) else None
