"""What the remote site tells of itself: the robot's state, which hand sample it obeys, and when that moved it."""

import math
import secrets
from collections.abc import Mapping

from common.link.pubsub import Publisher
from common.messages.robot import (
    LeaseState,
    LoopTiming,
    Readiness,
    RobotState,
    SessionState,
)
from common.process.rate import Rate
from remote_site.drivers.link import RobotReport
from remote_site.kinematics.model import ArmModel
from remote_site.runtime.tracing import Tracing
from remote_site.runtime.transition_log import TransitionLog
from remote_site.session.shared_lease import NOBODY, SharedLease
from remote_site.teleop.pipeline import Step, TeleopPipeline, pose_of

SESSION_BITS = 62
LATE_PERCENTILE = 99.0
STATES_PER_TIMING = 50  # ordering thousands of latenesses does not belong in every tick


class Reporter:
    """Keeps the times of the obeyed samples, publishes RobotState, and shows on a board whose lease is in force."""

    def __init__(
        self, publisher: Publisher[RobotState], board: SharedLease, model: ArmModel, rate: Rate, *, real_time: bool
    ) -> None:
        self._publisher = publisher
        self._board = board
        self._model = model
        self._rate = rate
        self._real_time = real_time
        self._session = secrets.randbits(SESSION_BITS)
        self._seq = 0
        self._tracing = Tracing()
        self._timing = self._measured_timing()
        self._log = TransitionLog()

    def note(self, step: Step, command_seq: int, command_ns: int, reading: RobotReport) -> None:
        """Note the command that first obeys a sample, and the reading that first shows it in the robot's motion."""
        self._log.note(step.state, step.reason)
        if step.obeys is not None:
            self._tracing.obey(step.obeys, command_seq, command_ns, step.motion)
        self._tracing.see(reading)

    def publish(
        self, step: Step, chain: TeleopPipeline, reading: RobotReport, malformed: Mapping[str, int], now_ns: int
    ) -> None:
        """Send the robot's state as measured and commanded."""
        self._seq += 1
        if self._seq % STATES_PER_TIMING == 0:
            self._timing = self._measured_timing()
        lease = _lease(chain, now_ns)
        self._board.show(lease.number if lease is not None else NOBODY)
        rejected = {code.value: count for code, count in chain.intake.rejected.items()} | dict(malformed)
        self._publisher.put(
            RobotState(
                session=self._session,
                seq=self._seq,
                t_ns=reading.t_ns,
                state=step.state,
                code=step.reason.code.value,
                reason=step.reason.sentence,
                joints=self._model.joint_names,
                q=tuple(reading.q.tolist()),
                q_commanded=tuple(chain.sent.q.tolist()),
                base_T_tool=pose_of(self._model.forward(reading.q)),
                gripper=reading.gripper,
                gripper_toggles_applied=chain.gripper.applied,
                obeyed=self._tracing.told(),
                engagement=chain.engagement,
                rejected=rejected,
                timing=self._timing,
                lease=lease,
                clock=chain.intake.clock,
                readiness=_readiness(chain, reading, now_ns),
                min_distance=_finite(chain.collision.distance(reading.q)),
                target=pose_of(chain.target) if step.state is SessionState.ENGAGED else None,
                traced=self._tracing.traced,
            )
        )

    def _measured_timing(self) -> LoopTiming:
        rate = self._rate
        late_us = rate.late_us(LATE_PERCENTILE)
        return LoopTiming(rate.hz, late_us, rate.missed, rate.ticks, self._real_time)


def _lease(chain: TeleopPipeline, now_ns: int) -> LeaseState | None:
    lease, asker = chain.leases.current(now_ns), chain.leases.asker(now_ns)
    if lease is None:
        return None
    holder = lease.holder
    return LeaseState(lease.number, holder.name, holder.session, lease.expires_ns, asker.name if asker else None)


def _readiness(chain: TeleopPipeline, reading: RobotReport, now_ns: int) -> Readiness:
    answer = chain.session.readiness(now_ns, chain.robot(reading.fault))
    return Readiness(answer.done, answer.reason.code.value, answer.reason.sentence, chain.session.held)


def _finite(distance: float) -> float | None:
    return distance if math.isfinite(distance) else None
