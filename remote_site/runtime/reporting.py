"""Publishes the robot's state: which hand sample it obeys, and when that sample moved it."""

import math
import secrets
from collections.abc import Mapping

from common.link.pubsub import Publisher
from common.messages.robot import (
    LeaseState,
    LoopTiming,
    Pose,
    Readiness,
    RobotState,
    SessionState,
)
from remote_site.kinematics.model import ArmModel
from remote_site.runtime.driven_pipeline import DrivenPipeline
from remote_site.runtime.rate import Rate
from remote_site.runtime.shared_lease import NO_LEASE, SharedLease
from remote_site.runtime.tracing import Tracing
from remote_site.runtime.transition_log import TransitionLog
from remote_site.safety.collision import CollisionModel
from remote_site.session.lease import LeaseStatus
from remote_site.teleop.cycle import Snapshot

SESSION_BITS = 62
LATE_PERCENTILE = 99.0
STATES_PER_TIMING = 50  # ordering thousands of latenesses does not belong in every tick


class Reporter:
    """Publishes RobotState with the times of the obeyed samples, and shares the number of the lease in force."""

    def __init__(
        self,
        publisher: Publisher[RobotState],
        shared_lease: SharedLease,
        model: ArmModel,
        collision: CollisionModel,
        rate: Rate,
        *,
        real_time: bool,
    ) -> None:
        self._publisher = publisher
        self._shared_lease = shared_lease
        self._model = model
        self._collision = collision
        self._rate = rate
        self._real_time = real_time
        self._session = secrets.randbits(SESSION_BITS)
        self._seq = 0
        self._tracing = Tracing()
        self._timing = self._measured_timing()
        self._log = TransitionLog()

    def note(self, snapshot: Snapshot, driven: DrivenPipeline) -> None:
        """Note the command that first obeys a sample, and the reading that first shows it in the robot's motion."""
        self._log.note(snapshot.state, snapshot.reason)
        if snapshot.obeys is not None:
            self._tracing.obey(snapshot.obeys, driven.seq, snapshot.now_ns, driven.sent)
        self._tracing.see(driven.report)

    def publish(self, snapshot: Snapshot, driven: DrivenPipeline, malformed: Mapping[str, int]) -> None:
        """Send the robot's state as measured and commanded."""
        self._seq += 1
        if self._seq % STATES_PER_TIMING == 0:
            self._timing = self._measured_timing()
        lease, report = _lease(snapshot.lease), driven.report
        self._shared_lease.show(lease.number if lease is not None else NO_LEASE)
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
