"""Keeps the lease and the clock offset in a thread, and ends the site before a cell of another protocol."""

import contextvars
import threading
import time
from dataclasses import dataclass
from functools import partial
from types import TracebackType
from typing import Self

import structlog

from common.clock import NS_PER_MS, NS_PER_S, ClockEstimate
from common.errors import ProcessError, RefusedError, TransportError
from common.link.aside import Aside
from common.link.channels import DESCRIBE, LEASE, OPERATE, TROUBLE
from common.link.remote_clock import RemoteClock
from common.link.request_client import RequestClient
from common.link.transport import Link, open_link
from common.messages.hand import ClockSync
from common.messages.requests import (
    SILENT,
    WAITING,
    DescribeQuestion,
    LeaseAction,
    LeaseReply,
    LeaseRequest,
    OperatorAction,
    OperatorRequest,
    Reply,
    TroubleReport,
)
from common.messages.robot import Asker, site_words
from common.process.log import RefusalLog
from local_site.authority.lease_policy import KEEP_ASKING_NS, LeasePolicy

POLL_S = 0.02
CLOCK_EVERY_NS = 200 * NS_PER_MS
PATIENCE_NS = NS_PER_S
END_PATIENCE_S = 0.6  # for what is under way, and the release: without it the lease expires by itself
ROUNDS_TO_DOUBT = 25  # of silence, until it probes for the reason: about six seconds
ROUNDS_TO_WARN = 7  # at most five seconds
TAKE_IT = "where it is wanted again: farhand lease take, which also brings back that it is asked for automatically"
ACTIONS = {OperatorAction.GIVE: LeaseAction.HAND_OVER, OperatorAction.RELEASE: LeaseAction.RELEASE}
PATIENCE_S = 2.0
ASK_EVERY_S = 0.1


def tell_by_tls(link: Link, cell: str, operator: str, reason: str) -> bool:
    """Report to the remote site over TLS, where a QUIC link's endpoint has it as well; return whether it answered."""
    fallback = link.tls_fallback()
    if fallback is None:
        return False
    endpoint, security = fallback
    deadline_s = time.monotonic() + PATIENCE_S
    try:
        with open_link(connect=(str(endpoint),), security=security) as by_tls:
            while time.monotonic() < deadline_s:
                if by_tls.ask(TROUBLE, cell, TroubleReport(reason=reason), operator=operator) is not None:
                    return True
                time.sleep(ASK_EVERY_S)
    except TransportError:
        return False  # it is refused or gone for another reason, which this side reports
    return False


@dataclass(frozen=True, slots=True)
class LeaseAndClock:
    """The lease and clock of every sample: the lease's number (0 without one), and the offset where it is known."""

    lease: int = 0
    clock: ClockSync | None = None


class PolledClock:
    """The remote site's clock, measured every 200 ms; where it stays silent, a warning says why."""

    def __init__(self, link: Link, cell: str, operator: str) -> None:
        self._link, self._cell, self._operator = link, cell, operator
        self._due_ns = 0
        self.remote = RemoteClock(link, cell, ROUNDS_TO_DOUBT)

    def poll(self, now_ns: int) -> None:
        """Measure it if that is due."""
        if now_ns < self._due_ns:
            return
        self._due_ns = now_ns + CLOCK_EVERY_NS
        self.remote.measure()
        if self.remote.silent_rounds == ROUNDS_TO_WARN:
            Aside("silence").start(self._warn_of_silence)

    def _warn_of_silence(self) -> None:
        no_quic = self._link.why_no_quic()
        if no_quic:
            tell_by_tls(self._link, self._cell, self._operator, no_quic)
        cure = no_quic or self._link.why_silent() or "start it, and check the cell and the endpoint"
        structlog.get_logger().warning(
            "the remote site does not answer", cell=self._cell, endpoint=self._link.leads_to, cure=cure
        )


class Authority:
    """Acquires and renews the lease while its block lasts, and releases it at the end, if the remote site answers soon.

    `session` is the number that this site's samples carry, `operator` the name shown to others.
    """

    def __init__(self, link: Link, cell: str, operator: str, session: int, *, automatic: bool) -> None:
        self.session = session
        self._link, self._cell = link, cell
        self._policy = LeasePolicy(operator, automatic=automatic)
        self._clock = PolledClock(link, cell, operator)
        self._client = RequestClient(link, cell, self._clock.remote, operator=operator, patience_ns=PATIENCE_NS)
        self._server = link.serve(OPERATE, cell, RefusalLog().note, operator=operator)
        self._described = False
        self._refused: RefusedError | None = None
        self._logged = ""
        self._stop = threading.Event()
        self._thread = threading.Thread(
            target=contextvars.copy_context().run, args=(self._run,), name="authority", daemon=True
        )

    def __enter__(self) -> Self:
        structlog.get_logger().info("operator", shown_as=site_words(self._policy.operator, self.session))
        self._thread.start()
        return self

    def __exit__(
        self, kind: type[BaseException] | None, error: BaseException | None, trace: TracebackType | None
    ) -> None:
        self._stop.set()
        self._thread.join(END_PATIENCE_S)

    def lease_and_clock(self, now_ns: int, captured_ns: int | None = None) -> LeaseAndClock:
        """The current lease and clock offset, for a sample of this capture so that it is never taken for younger.

        RefusedError when both sites cannot or may not talk to each other.
        """
        if self._refused is not None:
            raise self._refused
        if not self._thread.is_alive():
            raise ProcessError("the thread that keeps the lease has died")
        known = self._clock.remote.estimate(now_ns, captured_ns)
        return LeaseAndClock(self._policy.held(now_ns), _sync(known) if known is not None else None)

    def _run(self) -> None:
        try:
            while not self._stop.wait(POLL_S):
                self._step(time.monotonic_ns())
            if self._policy.held(time.monotonic_ns()):
                self._request(LeaseAction.RELEASE)
        except RefusedError as error:
            tell_by_tls(self._link, self._cell, self._policy.operator, str(error))
            self._refused = error
        except Exception:
            if not self._stop.is_set():  # else the link is closed already: the remote site did not answer in time
                raise

    def _step(self, now_ns: int) -> None:
        self._clock.poll(now_ns)
        action = self._policy.due(now_ns)
        if action is not None and (action is LeaseAction.RENEW or self._is_described()):
            self._request(action)
        self._server.poll(time.monotonic_ns(), self._operate)

    def _is_described(self) -> bool:
        """Ask for the cell's description once, so that another protocol is noticed before anything moves."""
        if not self._described:
            cell = self._link.ask(DESCRIBE, self._cell, DescribeQuestion())
            if cell is None:
                return False
            self._described = True
            structlog.get_logger().info(
                "cell", robot=cell.robot, driver=cell.driver, joints=len(cell.joints), software=cell.software
            )
        return True

    def _request(self, action: LeaseAction, to: Asker | None = None) -> LeaseReply | None:
        """Send a request; None while the remote clock is not known or without an answer."""
        asked_ns = time.monotonic_ns()
        if self._clock.remote.estimate(asked_ns) is None:
            return None
        held = self._policy.held(asked_ns)
        make = partial(LeaseRequest, action=action, session=self.session, lease=held, to=to)
        self._policy.asked(asked_ns)
        try:
            reply = self._client.ask(LEASE, make)
        except RefusedError:
            raise
        except TransportError:
            return None
        asked_by_itself = self._policy.asks_by_itself
        self._policy.take_reply(reply, asked_ns, time.monotonic_ns())
        self._log(held, reply)
        self._log_asking(asked_by_itself)
        return reply

    def _log(self, had: int, reply: LeaseReply) -> None:
        """Log a lease that has come or gone, and a refusal once."""
        if reply.lease == had and reply.done:
            return
        self._described = self._described and reply.lease != 0
        log, words = structlog.get_logger(), f"{reply.code} {reply.reason}"
        if reply.done:
            log.info("lease", code=reply.code, reason=reply.reason)
        elif words != self._logged:
            log.warning("lease", code=reply.code, reason=reply.reason)
        self._logged = words

    def _log_asking(self, asked_by_itself: bool) -> None:
        if asked_by_itself and not self._policy.asks_by_itself:
            structlog.get_logger().warning("the lease is not asked for automatically any more", cure=TAKE_IT)

    def _operate(self, request: OperatorRequest) -> Reply:
        """Carry out an act of the operator; the reply is the remote site's, or tells whom this site waits for."""
        if request.action is OperatorAction.TAKE:
            self._policy.keep_asking(time.monotonic_ns())
            answer = self._request(LeaseAction.ACQUIRE) if self._is_described() else None
        else:
            answer = self._request(ACTIONS[request.action], request.to)
            if answer is not None and answer.done:
                asked_by_itself = self._policy.asks_by_itself
                self._policy.stop_asking()
                self._log_asking(asked_by_itself)
        if answer is None:
            silent = "the remote site does not answer the local one"
            return Reply(id=request.id, done=False, code=SILENT, reason=silent)
        if request.action is OperatorAction.TAKE and not answer.done and answer.holder:
            return Reply(id=request.id, done=False, code=WAITING, reason=self._whom_it_waits_for(answer))
        return Reply(id=request.id, done=answer.done, code=answer.code, reason=answer.reason)

    def _whom_it_waits_for(self, answer: LeaseReply) -> str:
        holder = site_words(answer.holder, answer.holder_session)
        return (
            f"{holder} holds the lease, and hands it over with: farhand lease give {self._policy.operator}, or on the "
            f"page; this site asks for {KEEP_ASKING_NS // NS_PER_S} s"
        )


def _sync(known: ClockEstimate) -> ClockSync:
    offset = known.offset
    return ClockSync(
        remote_minus_local_ns=offset.offset_ns,
        uncertainty_ns=offset.uncertainty_ns,
        measured_ns=known.measured_ns,
        remote_ahead_ns=known.their_ahead_ns,
    )
