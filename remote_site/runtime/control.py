"""The control process: read, intake, map, inverse kinematics, guard, write, 250 times a second; nothing else in it."""

import gc
import secrets
import time

from common.clock import NS_PER_S, MonotonicClock
from common.errors import DriverError, MessageError
from common.link.channels import (
    ENGAGEMENT,
    HAND,
    MAINTENANCE,
    STATE,
)
from common.link.transport import Link
from common.messages.hand import HandArm
from common.messages.requests import EngagementAction, EngagementRequest, Reply
from common.process.children import Heartbeat
from common.process.rate import Rate
from common.process.service import StopFlag, ask_for_real_time
from remote_site.config import RemoteConfig
from remote_site.drivers.driver import JointCommand
from remote_site.drivers.faults import FaultCode
from remote_site.drivers.link import DriverLink, RobotReport
from remote_site.drivers.memory import DriverMemory
from remote_site.drivers.supervisor.write_scheduler import LEAST_SHARE
from remote_site.kinematics.limits import JointLimits
from remote_site.kinematics.model import ArmModel
from remote_site.reasons import Code, Reason, reason
from remote_site.runtime.links import open_site_link
from remote_site.runtime.reporting import Refusals, Reporter
from remote_site.runtime.request_server import RequestServer, describe
from remote_site.session.fault_latch import FaultLatch
from remote_site.session.lease import LeaseServer
from remote_site.session.shared_lease import SharedLease
from remote_site.session.state_machine import Answer
from remote_site.simulation.memory import CellMemory
from remote_site.simulation.views import PostureMirror
from remote_site.teleop.pipeline import Step, TeleopPipeline

FIFO_PRIORITY = 50
ACTIVATION_TIMEOUT_S = 10.0
ACTIVATION_POLL_S = 0.02
TICKS_PER_STATE = 5
LEASE_BITS = 48


def run_control(
    config: RemoteConfig,
    driver_memory: DriverMemory,
    memory: CellMemory | None,
    board: SharedLease,
    should_stop: StopFlag,
    heartbeat: Heartbeat,
) -> None:
    """Control the robot until asked to stop; then have it stopped."""
    clock = MonotonicClock()
    model = ArmModel.from_urdf(config.robot.urdf, config.robot.tool_frame, config.robot.tool_T_tcp)
    limits = JointLimits.from_model(model, config.robot)
    driver = DriverLink(driver_memory, limits, clock)
    with open_site_link(config.links, config.links.control, should_stop) as link:
        leases = LeaseServer(round(config.lease.seconds * NS_PER_S), 1 + secrets.randbits(LEASE_BITS))
        chain = TeleopPipeline(config, model, limits, config.robot.start, leases)
        real_time = ask_for_real_time(FIFO_PRIORITY)
        mirror = PostureMirror(config.simulation, memory.snapshot) if memory and not config.cell_is_simulated else None
        description = describe(config, model, limits, config.control.rate_hz / TICKS_PER_STATE)
        gc.collect()
        gc.freeze()
        # from here on the driver counts the time without a command
        _activate(driver, chain, should_stop)
        rate = Rate(config.control.rate_hz, clock, least_share=LEAST_SHARE)
        reporter = Reporter(link.publisher(STATE, config.cell), board, model, rate, real_time=real_time)
        refusals = Refusals(reporter.log)
        desk = RequestServer(link, description, leases, clock, refusals.note)
        loop = ControlLoop(chain, driver, reporter, Inbox(link, config.cell, refusals), desk, mirror)
        while not should_stop():
            rate.wait()
            loop.tick(clock.now_ns())
            heartbeat.beat()
        driver.stop()


class Inbox:
    """The hand channel and what is asked of the engagement; payloads that are no message are counted and told."""

    def __init__(self, link: Link, cell: str, refusals: Refusals) -> None:
        self.hand = link.latest(HAND, cell)
        self.engagement = link.serve(ENGAGEMENT, cell, refusals.note)
        self.maintenance = link.serve(MAINTENANCE, cell, refusals.note)
        self.refusals = refusals

    def take(self) -> list[HandArm]:
        """The hand samples that have come, the oldest first."""
        samples = []
        for _ in range(HAND.depth):
            try:
                sample = self.hand.take()
            except MessageError as error:
                self.refusals.note(error)
                continue
            if sample is None:
                break
            samples.append(sample)
        return samples


class ControlLoop:
    """One tick after the other; `tick` is the whole way from sample to command."""

    def __init__(
        self,
        chain: TeleopPipeline,
        driver: DriverLink,
        reporter: Reporter,
        inbox: Inbox,
        desk: RequestServer,
        mirror: PostureMirror | None,
    ) -> None:
        self._chain = chain
        self._mirror = mirror
        self._driver = driver
        self._reporter = reporter
        self._inbox = inbox
        self._desk = desk
        self._seq = self._ticks = self._now_ns = 0
        self._reading = driver.read()
        self._faults = FaultLatch(chain.session)

    def tick(self, now_ns: int) -> None:
        """Read, take a sample, decide, command, tell."""
        chain = self._chain
        self._reading = self._driver.read()
        self._now_ns, chain.measured = now_ns, self._reading.q
        if not self._reading.ready:
            chain.sent = self._reading.sent  # before an activation in this tick, which says better where it goes on
        if self._faults.note(self._reading.fault, now_ns, resting=chain.sent.resting):
            self._wake()
        for sample in self._inbox.take():
            chain.receive(sample, now_ns)
        self._inbox.engagement.poll(now_ns, lambda request: _reply(request, self._act(request)))
        self._inbox.maintenance.poll(now_ns, lambda request: _reply(request, self._maintain(request)))
        step = chain.tick(now_ns, chain.robot(self._reading.fault))
        if self._reading.ready:
            self._write(step, now_ns)
        self._reporter.note(step, self._seq, now_ns, self._reading)
        self._ticks += 1
        if self._ticks % TICKS_PER_STATE == 0:
            self._reporter.publish(step, chain, self._reading, self._inbox.refusals.counts, now_ns)
        if self._mirror is not None:
            self._mirror.show(self._reading.t_ns, self._reading.q)
        self._desk.poll()

    def _write(self, step: Step, now_ns: int) -> None:
        self._seq += 1
        motion = step.motion
        command = JointCommand(self._seq, now_ns, motion.q, motion.dq, motion.ddq, self._chain.gripper.is_open)
        self._chain.sent = self._driver.write(command).motion

    def _act(self, request: EngagementRequest) -> Answer:
        """Do what is asked of the engagement: anybody may stop the arm, the rest is the lease holder's."""
        session, action, operator = self._chain.session, request.action, request.operator
        if action is EngagementAction.STOP:
            return session.stop(operator)
        foreign = self._foreign(operator)
        if foreign is not None:
            return Answer(False, foreign)
        if action is EngagementAction.DISENGAGE:
            return session.request_disengage()
        return self._engage() if action is EngagementAction.ENGAGE else self._reset()

    def _maintain(self, request: EngagementRequest) -> Answer:
        """Do what maintenance may without the lease: stop the arm, and reset it; to let it follow is an operator's."""
        if request.action is EngagementAction.STOP:
            return self._chain.session.stop(request.operator)
        if request.action is EngagementAction.RESET:
            return self._reset()
        return Answer(False, reason(Code.OPERATORS_ONLY))

    def _engage(self) -> Answer:
        """Clear a fault, wake a robot that has stopped, then ask the session."""
        chain, reading = self._chain, self._reading
        chain.session.clear_fault()
        if not reading.ready:
            self._wake()
            return Answer(False, reason(Code.ACTIVATED))
        return chain.session.request_engage(self._now_ns, chain.robot(reading.fault))

    def _reset(self) -> Answer:
        """Clear a fault and a stop, and wake a robot that has stopped."""
        if not self._reading.ready:
            self._wake()
        return self._chain.session.reset()

    def _wake(self) -> None:
        """Have the robot take commands again where it stands."""
        self._driver.activate(self._reading.q)
        self._chain.restart_from(self._reading.q)

    def _foreign(self, operator: str) -> Reason | None:
        """Why this operator may not have the arm; None for the lease's holder."""
        lease = self._chain.leases.current(self._now_ns)
        if lease is None:
            return reason(Code.NO_LEASE)
        return None if lease.holder.name == operator else reason(Code.NOT_HOLDER, holder=lease.holder.name)


def _reply(request: EngagementRequest, answer: Answer) -> Reply:
    return Reply(id=request.id, done=answer.done, code=answer.reason.code.value, reason=answer.reason.sentence)


def _activate(driver: DriverLink, chain: TeleopPipeline, should_stop: StopFlag) -> None:
    """Bring the robot to take commands where it stands; DriverError when it does not get ready."""
    deadline = time.monotonic() + ACTIVATION_TIMEOUT_S
    asked = False
    while not should_stop():
        report = driver.read()
        if asked and report.ready:
            return
        if not asked or (report.answered and not report.ready and not _pending(report)):
            chain.restart_from(report.q if report.t_ns else chain.sent.q)
            driver.activate(chain.sent.q)
            asked = True
        if time.monotonic() > deadline:
            raise DriverError(f"the robot did not get ready in {ACTIVATION_TIMEOUT_S:g} s: {report.fault}")
        time.sleep(ACTIVATION_POLL_S)


def _pending(report: RobotReport) -> bool:
    return report.fault is not None and report.fault.code is FaultCode.NOT_ACTIVATED
