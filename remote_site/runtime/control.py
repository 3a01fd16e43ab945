"""The control process: 250 times a second it reads the robot, runs one cycle and commands it; nothing else is in it."""

import gc
import secrets
import time
from collections.abc import Callable, Iterator, Sequence
from functools import partial

from common.clock import NS_PER_S
from common.errors import DriverError, MessageError
from common.host_clock import MonotonicClock, host_time
from common.link.channels import ENGAGEMENT, HAND, MAINTENANCE, MAINTENANCE_STOP, STATE, STOP, ChannelSession
from common.link.endpoints import stays_here
from common.link.pubsub import Latest
from common.link.rate_cap import RateCap
from common.link.tap import untapped
from common.link.transport import Link
from common.messages.hand import HandArm
from common.messages.requests import EngagementAction, Reply
from common.messages.robot import FOLLOWING, SessionState
from common.process.children import Heartbeat
from common.process.log import RefusalLog, log_summary
from common.process.service import StopFlag, ask_for_real_time
from common.steady_time import HostTime
from remote_site.config import RemoteConfig
from remote_site.drivers.faults import FaultCode
from remote_site.drivers.link import DriverLink, RobotReport
from remote_site.drivers.memory import DriverMemory
from remote_site.drivers.supervisor.write_scheduler import LEAST_FRACTION
from remote_site.kinematics.limits import load_arm
from remote_site.reasons import Code, reason
from remote_site.recording.memory import RecordingMemory
from remote_site.recording.taps import ControlTap
from remote_site.runtime.assist_memory import AssistMemory
from remote_site.runtime.driven_pipeline import DrivenPipeline
from remote_site.runtime.links import open_site_link
from remote_site.runtime.rate import Rate
from remote_site.runtime.recording_requests import ControlRecording, RecordingRequests
from remote_site.runtime.reporting import Reporter, StatePace, loop_timing
from remote_site.runtime.request_server import RequestServer, describe
from remote_site.runtime.site_memory import SiteMemory
from remote_site.safety.collision import CollisionModel
from remote_site.session.lease import Lease, LeaseServer
from remote_site.session.requests import SessionRequest
from remote_site.session.samples import NamedSample, as_of_now
from remote_site.session.state_machine import Answer
from remote_site.simulation.memory import CellMemory
from remote_site.simulation.views import PostureMirror
from remote_site.teleop.cycle import Snapshot
from remote_site.teleop.pipeline import TeleopPipeline

FIFO_PRIORITY = 50
ACTIVATION_TIMEOUT_S = 10.0
ACTIVATION_POLL_S = 0.02
TICKS_PER_STATE = 5
LEASE_BITS = 31
MAINTENANCE_NAME = "maintenance"
UNHELD_HZ = 3 * HAND.rate_hz  # samples taken of an operator without the lease; they are only counted, and recorded
TOO_MANY = MessageError("too_many", f"of an operator without the lease {UNHELD_HZ:g} hand samples a second are taken")

Waiting = tuple[SessionRequest, Callable[[Answer], None]]


def run_control(
    config: RemoteConfig,
    driver_memory: DriverMemory,
    memory: CellMemory | None,
    site: SiteMemory,
    assist: AssistMemory | None,
    recorded: RecordingMemory | None,
    should_stop: StopFlag,
    heartbeat: Heartbeat,
) -> None:
    """Control the robot until asked to stop; then have it stopped."""
    clock = MonotonicClock()
    tap = ControlTap(recorded, clock) if recorded is not None else None
    model, limits = load_arm(config.robot)
    driver = DriverLink(driver_memory, limits, clock)
    note_message = tap.note_message if tap is not None else untapped
    with open_site_link(config.links, ChannelSession.CONTROL, should_stop, tap=note_message) as link:
        leases = LeaseServer(round(config.lease.seconds * NS_PER_S), 1 + secrets.randbits(LEASE_BITS))
        pipeline = TeleopPipeline(config, model, limits)
        # of its own: what is measured for a report must not touch what the pipeline has cached
        robot, fixtures = config.robot, config.safety.collision
        reported_collision = CollisionModel.from_urdf(robot.urdf, model, robot.capsules, fixtures)
        real_time = ask_for_real_time(FIFO_PRIORITY)
        mirror = PostureMirror(config.simulation, memory.snapshot) if memory and not config.cell_is_simulated else None
        description = describe(config, model, limits)
        gc.collect()
        gc.freeze()
        # from here on the driver counts the time without a command
        _activate(driver, should_stop)
        rate = Rate(config.control.rate_hz, clock, least_fraction=LEAST_FRACTION)
        states = link.publisher(STATE, config.cell)
        one_host = stays_here(config.links.control_endpoint)
        timing = partial(loop_timing, rate, real_time=real_time)
        reporter = Reporter(states, site, model, reported_collision, timing, one_host=one_host, tap=tap)
        refusals = RefusalLog()
        server = RequestServer(link, description, leases, clock, refusals.note, config.links.heard)
        driven, inbox = DrivenPipeline(pipeline, driver), Inbox(link, config.cell, refusals, config.links.heard)
        recording = None
        if tap is not None:
            asked = RecordingRequests(link, config.cell, config.links.heard, leases, tap, refusals.note)
            recording = ControlRecording(tap, asked)
        loop = ControlLoop(driven, leases, inbox, reporter, server, mirror, site, assist, recording)
        try:
            while not should_stop():
                rate.wait()
                loop.tick(clock.now_ns())
                heartbeat.beat()
            driver.stop()
            loop.end()
        finally:
            log_summary(reporter.log.summary.sentences())


class Inbox:
    """The hand channel and the requests about the engagement; payloads that are no message are counted.

    Who sends is known from the key alone. Every listed operator has buffers of their own, so that none displaces
    another's samples or requests; stops have theirs, which no other request displaces.
    """

    def __init__(
        self,
        link: Link,
        cell: str,
        refusals: RefusalLog,
        operators: Sequence[str],
        read_clocks: Callable[[], HostTime] = host_time,
    ) -> None:
        self._read_clocks = read_clocks
        self._hands = [
            (link.latest(HAND, cell, operator=operator), RateCap(UNHELD_HZ, HAND.depth)) for operator in operators
        ]
        refused = refusals.note
        self._stops = [link.answer(STOP, cell, refused, operator=operator) for operator in operators]
        self._stops.append(link.answer(MAINTENANCE_STOP, cell, refused))
        self._others = [link.serve(ENGAGEMENT, cell, refused, operator=operator) for operator in operators]
        self._others.append(link.serve(MAINTENANCE, cell, refused))
        self.refusals = refusals

    def samples(self, lease: Lease | None, now_ns: int) -> list[NamedSample]:
        """The hand samples that have arrived, each operator's oldest first; not more than UNHELD_HZ without the lease.

        So nobody else can make the holder's cycles, and a recording of them, large.
        """
        ahead_ns, holder = self._read_clocks().ahead_ns, lease.holder.name if lease is not None else None
        came = ((named, cap) for hand, cap in self._hands for named in self._taken(hand))
        return [
            NamedSample(operator, as_of_now(sample, ahead_ns))
            for (operator, sample), cap in came
            if operator == holder or self._admits(cap, now_ns)
        ]

    def requests(self, now_ns: int) -> list[Waiting]:
        """At most one stop and one other request of each operator and of maintenance, with what answers each.

        The stops come first.
        """
        stops = [asked for server in self._stops if (asked := server.take()) is not None]
        others = [other for server in self._others if (other := server.take(now_ns)) is not None]
        return [
            *(_waiting(EngagementAction.STOP, operator, 0, 0, reply) for operator, _, reply in stops),
            *(_waiting(asked.action, operator, asked.id, asked.seen_ns, reply) for operator, asked, reply in others),
        ]

    def _admits(self, cap: RateCap, now_ns: int) -> bool:
        if cap.pause_ns(now_ns):
            self.refusals.note(TOO_MANY)
            return False
        cap.passed(now_ns)
        return True

    def _taken(self, hand: Latest[HandArm]) -> Iterator[tuple[str, HandArm]]:
        for _ in range(HAND.depth):
            try:
                named = hand.take_named()
            except MessageError as error:
                self.refusals.note(error)
                continue
            if named is None:
                return
            yield named


class ControlLoop:
    """Runs one tick after the other: read, cycle, command, then reply and report."""

    def __init__(
        self,
        driven: DrivenPipeline,
        leases: LeaseServer,
        inbox: Inbox,
        reporter: Reporter,
        server: RequestServer,
        mirror: PostureMirror | None,
        site: SiteMemory,
        assist: AssistMemory | None = None,
        recording: ControlRecording | None = None,
    ) -> None:
        self._driven = driven
        self._leases = leases
        self._inbox = inbox
        self._reporter = reporter
        self._server = server
        self._mirror = mirror
        self._site, self._assist, self._recording = site, assist, recording
        self._pace, self._ticks = StatePace(), 0
        self._snapshot: Snapshot | None = None

    def tick(self, now_ns: int) -> None:
        """One control tick; no reply delays a command."""
        driven, waiting = self._driven, self._inbox.requests(now_ns)
        requests = [request for request, _ in waiting]
        lease = self._leases.status(now_ns)
        samples = self._inbox.samples(lease.lease, now_ns)
        markers = self._assist.take_markers() if self._assist is not None else ()
        snapshot = self._snapshot = driven.cycle(now_ns, lease, samples, requests, markers, site_ready=self._site.ready)
        for (_, reply), answer in zip(waiting, snapshot.answers, strict=True):
            reply(answer)
        self._reporter.note(snapshot, driven)
        self._ticks += 1
        if self._ticks % TICKS_PER_STATE == 0 and self._is_due(snapshot):
            self._pace.sent(self._reporter.publish(snapshot, driven, self._inbox.refusals.counts))
        if self._recording is not None:
            self._recording.tick(driven)
        if self._assist is not None:
            self._assist.show_joints(driven.report.t_ns, driven.report.q)
        if self._mirror is not None:
            self._mirror.show(driven.report.t_ns, driven.report.q)
        self._server.poll(engaged=snapshot.state in FOLLOWING)

    def end(self) -> None:
        """Publish that the site has been asked to end, or why it has to: nobody hears anything of it after that."""
        failure = self._site.failure
        if self._snapshot is None or not (self._site.ending or failure):
            return
        if failure:
            state, why = SessionState.FAULT, reason(Code.SITE_FAILED, cause=failure)
        else:
            state = SessionState.DISENGAGED if self._snapshot.state in FOLLOWING else self._snapshot.state
            why = reason(Code.SITE_ENDED)
        ended = self._snapshot._replace(state=state, reason=why)
        self._reporter.note(ended, self._driven)
        self._reporter.publish(ended, self._driven, self._inbox.refusals.counts)

    def _is_due(self, snapshot: Snapshot) -> bool:
        return self._pace.is_due(
            snapshot.now_ns, (snapshot.state, snapshot.reason.code, snapshot.halted_ns), snapshot.network_ms
        )


def _waiting(
    action: EngagementAction, operator: str, number: int, seen_ns: int, reply: Callable[[Reply], None]
) -> Waiting:
    """A request that came on this operator's key, empty for maintenance's, and what sends the session's answer."""

    def answering(answer: Answer) -> None:
        reply(Reply(id=number, done=answer.done, code=answer.reason.code.value, reason=answer.reason.sentence))

    asker = operator or MAINTENANCE_NAME
    return SessionRequest(action, asker, maintenance=not operator, seen_ns=seen_ns), answering


def _activate(driver: DriverLink, should_stop: StopFlag) -> None:
    """Activate the robot where it is measured, and never before; DriverError when it does not get ready."""
    deadline = time.monotonic() + ACTIVATION_TIMEOUT_S
    asked = False
    while not should_stop():
        report = driver.read()
        if asked and report.ready:
            return
        if report.measured and (not asked or (report.answered and not report.ready and not _pending(report))):
            driver.activate(report.q)
            asked = True
        if time.monotonic() > deadline:
            raise DriverError(f"the robot did not get ready in {ACTIVATION_TIMEOUT_S:g} s: {report.fault}")
        time.sleep(ACTIVATION_POLL_S)


def _pending(report: RobotReport) -> bool:
    return report.fault is not None and report.fault.code is FaultCode.NOT_ACTIVATED
