"""Links between sites: Zenoh sessions with explicit endpoints, which publish, subscribe, ask and answer."""

import json
import threading
import time
from collections.abc import Callable, Collection, Sequence
from dataclasses import replace
from types import TracebackType
from typing import Any, Self, TypeVar

import zenoh

from common.errors import MessageError, RefusedError, TransportError
from common.link.access import Serves
from common.link.channels import ANY, Channel, ChannelSession, Keyed, Priority, Procedure
from common.link.config import ON_THIS_HOST, LinkSecurity
from common.link.credentials import Credentials, load_credentials
from common.link.endpoints import Endpoint, check_endpoint, check_free
from common.link.lanes import LANES, LanePublisher
from common.link.probe import (
    VIEWERS_CURE,
    QuicBlockageDetector,
    blocked_sentence,
    identity_refusal,
    refusal,
    speaks_tls,
)
from common.link.pubsub import Latest, Publisher
from common.link.roles import Role
from common.link.send_queues import SendQueues
from common.link.servers import REFUSAL, IdempotentServer, OnRefused, QuestionServer, Replied, Requested
from common.link.session_settings import Mode, Served, SessionEndpoints, prepare_environment, session_settings
from common.link.tap import MessageTap, untapped
from common.messages.base import Message
from common.messages.codec import decode, encode
from common.messages.wire_form import wire_form

M = TypeVar("M", bound=Message)
Q = TypeVar("Q", bound=Message)
R = TypeVar("R", bound=Message)

REQUEST_TIMEOUT_S = 0.7  # longer than any round trip over which the reason for a refusal is to be heard
PENDING_REQUESTS = 16
CLOSE_PATIENCE_S = 0.4
ROUTER_PATIENCE_S = 20.0
ROUTER_POLL_S = 0.2
CONTROL = (ChannelSession.CONTROL,)
PRIORITIES = {
    Priority.REAL_TIME: zenoh.Priority.REAL_TIME,
    Priority.INTERACTIVE: zenoh.Priority.INTERACTIVE_HIGH,
    Priority.DATA: zenoh.Priority.DATA,
}
RELIABILITY_IF_BEST_EFFORT = {True: zenoh.Reliability.BEST_EFFORT, False: zenoh.Reliability.RELIABLE}


class Link:
    """One Zenoh session, as a context manager that closes it.

    TransportError for a channel or procedure that does not belong to one of `sessions`. With credentials, RefusedError
    for what their role may not do; the other site refuses that too.
    """

    def __init__(
        self,
        session: zenoh.Session,
        outgoing: Sequence[Endpoint] = (),
        credentials: Credentials | None = None,
        sessions: Collection[ChannelSession] = (),
        tap: MessageTap = untapped,
    ) -> None:
        self._session, self._tap = session, tap
        self._lanes: Sequence[zenoh.Session] = ()
        self._outgoing = outgoing
        self._credentials = credentials
        self._sessions = sessions
        self._was_up = False
        self._quic_doubt = QuicBlockageDetector()

    def __enter__(self) -> Self:
        return self

    def __exit__(
        self, kind: type[BaseException] | None, error: BaseException | None, trace: TracebackType | None
    ) -> None:
        self.close()

    def close(self) -> None:
        """Close the sessions with everything declared on them; closing twice is harmless.

        It waits for CLOSE_PATIENCE_S at most: for a neighbour that is gone Zenoh would wait until its lease is over.
        """
        open_sessions = (session for session in (*self._lanes, self._session) if not session.is_closed())
        closing = [threading.Thread(target=session.close, name="close", daemon=True) for session in open_sessions]
        for each in closing:
            each.start()
        until_s = time.monotonic() + CLOSE_PATIENCE_S
        for each in closing:
            each.join(max(until_s - time.monotonic(), 0.0))

    def take_lanes(self, lanes: Sequence[zenoh.Session]) -> None:
        """Let publishers that are declared from now on use these, which are closed with the link."""
        self._lanes = lanes

    def publisher(self, channel: Channel[M], cell: str, name: str = ANY, *, operator: str = ANY) -> Publisher[M]:
        """A publisher of a channel in a cell; `name` tells apart channels of one kind, such as cameras."""
        key = channel.key_for(cell, name, operator)
        self._check(channel.session, channel.sent_by, cell, f"send {key}")
        self._check_operator(channel, operator, f"send {key}")
        wire_form(channel.message)  # built here, and not in the control tick that sends the first
        in_lanes = [_declare(lane, key, channel) for lane in self._lanes] if channel.in_lanes else []
        lanes = LanePublisher(in_lanes) if in_lanes else None
        return Publisher(_declare(self._session, key, channel), self._tap, lanes)

    def latest(self, channel: Channel[M], cell: str, name: str = ANY, *, operator: str = ANY) -> Latest[M]:
        """A subscription that keeps only the newest messages of one key, as many as the channel's depth."""
        key = channel.key_for(cell, name, operator)
        self._check(channel.session, channel.received_by, cell, f"receive {key}")
        self._check_operator(channel, operator, f"receive {key}")
        wire_form(channel.message)  # built here, and not in the control tick that takes the first
        handler: zenoh.handlers.RingChannel[zenoh.Sample] = zenoh.handlers.RingChannel(channel.depth)
        return Latest(self._session.declare_subscriber(key, handler), channel, self._tap)

    def answer(
        self, procedure: Procedure[Q, R], cell: str, on_refused: OnRefused, *, operator: str = ANY
    ) -> QuestionServer[Q, R]:
        """A server of questions in a cell; `on_refused` is called for queries that cannot be decoded."""
        key = procedure.key_for(cell, operator=operator)
        self._check(ChannelSession.CONTROL, procedure.answered_by, cell, f"answer {key}")
        self._check_operator(procedure, operator, f"answer {key}")
        # A ring drops the oldest question when it is full; a queue would then block everything else on the link.
        handler: zenoh.handlers.RingChannel[zenoh.Query] = zenoh.handlers.RingChannel(PENDING_REQUESTS)
        return QuestionServer(self._session.declare_queryable(key, handler), key, procedure, on_refused, self._tap)

    def serve(
        self, procedure: Procedure[Requested, Replied], cell: str, on_refused: OnRefused, *, operator: str = ANY
    ) -> IdempotentServer[Requested, Replied]:
        """A server of requests that must take effect once; `on_refused` is called for what cannot be decoded."""
        return IdempotentServer(self.answer(procedure, cell, on_refused, operator=operator), procedure.reply)

    def ask(
        self,
        procedure: Procedure[Q, R],
        cell: str,
        question: Q,
        *,
        operator: str = ANY,
        timeout_s: float = REQUEST_TIMEOUT_S,
    ) -> R | None:
        """Ask once, with an operator's certificate what is that operator's to ask; None without an answer in time.

        RefusedError when one site cannot decode the other's message, TransportError once the link is closed.
        """
        own = self._credentials.identity.operator if self._credentials is not None else None
        if own is not None and procedure.of_operators is not None:
            procedure, operator = procedure.of_operators, own
        key = procedure.key_for(cell, operator=operator)
        self._check(ChannelSession.CONTROL, procedure.asked_by, cell, f"ask {key}")
        self._check_operator(procedure, operator, f"ask {key}")
        self._was_up = self._was_up or self.is_up()
        try:
            priority = PRIORITIES[Priority.INTERACTIVE]  # no stop, and no answer, waits behind a load
            replies = self._session.get(key, payload=encode(question), timeout=timeout_s, priority=priority)
        except zenoh.ZError as error:
            raise TransportError("the link was closed") from error
        for reply in replies:
            if reply.ok is not None:
                return _decode_reply(reply.ok.payload.to_bytes(), procedure)
            if reply.err is not None and (why := reply.err.payload.to_bytes()).startswith(REFUSAL):
                raise RefusedError(f"the other site {why.decode(errors='replace')}")
        return None

    def send_queues(self) -> SendQueues:
        """Return the queues that hold messages in this host on their way to the link's neighbours."""
        return SendQueues(self._session)

    def may_receive(self, channel: Channel[M]) -> bool:
        """Return whether our certificate's role may subscribe to the channel; without certificates every site may."""
        return self._credentials is None or self._credentials.identity.role in channel.received_by

    def may_ask(self, procedure: Procedure[Q, R]) -> bool:
        """Return whether our certificate's role may ask this; without certificates every site may."""
        return self._credentials is None or self._credentials.identity.role in procedure.asked_by

    def check_connected(self) -> None:
        """RefusedError with the reason when this side and the listener at one of our endpoints refuse each other.

        An endpoint where no site listens yet is no error. Takes about two seconds for each one that does not answer.
        """
        links = self._session.info.links()
        for endpoint in self._outgoing:
            link = next((link for link in links if _leads_to(link, endpoint)), None)
            why = None
            if link is None:
                why = refusal(endpoint, self._credentials) or self._quic_doubt.blocked(endpoint, was_up=self._was_up)
            elif endpoint.is_secured and self._credentials is not None:
                why = identity_refusal(link.auth_identifier or "", str(endpoint), self._credentials.identity)
            if why is not None:
                raise RefusedError(why)

    def why_silent(self) -> str:
        """Say what may keep our certificate from being answered now where the link itself is up, else nothing.

        An operator was perhaps answered before: a name is taken off the list while its site runs.
        """
        own = self._credentials.identity if self._credentials is not None else None
        if own is not None and own.role is Role.VIEWER and self.is_up():
            return f"the link is up, but nothing answers {own.common_name}: if the remote site runs, {VIEWERS_CURE}"
        if own is None or own.operator is None or not self.is_up():
            return ""
        return (
            f"the link is up, but nothing answers {own.common_name}: if the remote site runs, links.operators there, "
            f'or the router\'s, leaves out "{own.operator}"; add the name and restart that site, or install this '
            "release there"
        )

    def why_no_quic(self) -> str:
        """Why a QUIC link that has been up does not come back although the endpoint answers by TLS, else nothing."""
        links = self._session.info.links()
        down = (end for end in self._outgoing if end.is_quic and not any(_leads_to(link, end) for link in links))
        found = (blocked_sentence(end, was_up=True) for end in down if self._was_up and speaks_tls(end))
        return next(found, "")

    def tls_fallback(self) -> tuple[Endpoint, LinkSecurity] | None:
        """Our first QUIC endpoint by TLS, for which its site listens too, with our certificate; None without one."""
        quic = next((endpoint for endpoint in self._outgoing if endpoint.is_quic), None)
        if quic is None or self._credentials is None:
            return None
        return replace(quic, protocol="tls"), LinkSecurity(tls=self._credentials.tls)

    @property
    def leads_to(self) -> str:
        """The endpoints to which this side connects, to be read by people."""
        return ", ".join(map(str, self._outgoing))

    def is_up(self) -> bool:
        """Return whether one of our endpoints is connected now."""
        links = self._session.info.links()
        return any(_leads_to(link, endpoint) for link in links for endpoint in self._outgoing)

    def _check(self, session: ChannelSession, allowed: frozenset[Role], cell: str, action: str) -> None:
        if session not in self._sessions:
            ours = " and ".join(self._sessions)
            raise TransportError(
                f"a link of the {ours} session may not {action}: that belongs to a link of the {session} session, "
                f"opened at the site's {session} endpoint"
            )
        if self._credentials is None:
            return
        own, roles = self._credentials.identity, " or ".join(sorted(allowed))
        if own.cell != cell:
            raise RefusedError(f"the certificate of {own.common_name} is for cell {own.cell}; it may not {action}")
        if own.role not in allowed:
            raise RefusedError(
                f"the certificate of {own.common_name} may not {action}: that takes one of {roles}, in [links.tls]"
            )

    def _check_operator(self, keyed: Keyed, operator: str, action: str) -> None:
        """RefusedError for another operator's key than that of our certificate."""
        own = self._credentials.identity if self._credentials is not None else None
        if own is not None and own.operator is not None and keyed.by_operator and own.operator != operator:
            raise RefusedError(
                f"the certificate of {own.common_name} may not {action}: that key is another operator's; set "
                f'operator = "{own.operator}", or name the other\'s certificate in [links.tls]'
            )


def _declare(session: zenoh.Session, key: str, channel: Channel[Any]) -> zenoh.Publisher:
    return session.declare_publisher(
        key,
        priority=PRIORITIES[channel.priority],
        congestion_control=zenoh.CongestionControl.DROP,
        reliability=RELIABILITY_IF_BEST_EFFORT[channel.best_effort],
    )


def _leads_to(link: zenoh.Link, endpoint: Endpoint) -> bool:
    """Return whether protocol and port match; the host is not compared: Zenoh reports its address, not its name."""
    destination = link.dst.partition("?")[0]
    return destination.startswith(f"{endpoint.protocol}/") and destination.endswith(f":{endpoint.port}")


def _decode_reply(payload: bytes, procedure: Procedure[Q, R]) -> R:
    try:
        return decode(payload, procedure.reply, procedure.max_bytes)
    except MessageError as error:
        raise RefusedError(f"the other site's answer is refused: {error}") from error


def open_link(
    *,
    listen: tuple[str, ...] = (),
    connect: tuple[str, ...] = (),
    security: LinkSecurity = ON_THIS_HOST,
    sessions: Collection[ChannelSession] = CONTROL,
    operators: Sequence[str] = (),
    send_buffer_bytes: int | None = None,
    through_router: bool = False,
    in_lanes: bool = False,
    should_stop: Callable[[], bool] = lambda: False,
    tap: MessageTap = untapped,
) -> Link:
    """Open a session at explicit endpoints; TransportError when one is not allowed or cannot be opened.

    `sessions` are those that the endpoints belong to; the link carries their channels only. `operators` may operate a
    remote site; an operator's own link needs no list. `send_buffer_bytes` is the
    size of each connection's send buffer, None for the system's choice, which is megabytes. Listening fails immediately
    when the port is taken. Connecting continues in the background until the other side listens; RefusedError when it
    does but refuses us, or we refuse it. `through_router` is for a site that no other can connect to: all messages go
    through the router at `connect`, which is awaited for ROUTER_PATIENCE_S, or until `should_stop`. With `in_lanes`
    what channels send in lanes goes over connections of its own too where `connect` is QUIC. The `tap` is called with
    every message of the link's publishers, subscriptions and servers.
    """
    listening = tuple(check_free(endpoint, security) for endpoint in listen)
    outgoing = tuple(check_endpoint(endpoint, security) for endpoint in connect)
    credentials = _credentials((*listening, *outgoing), security)
    mode = Mode.CLIENT if through_router else Mode.PEER
    endpoints = SessionEndpoints(mode, listening, outgoing, send_buffer_bytes)
    served = Served(credentials, tuple(operators))
    session = (
        _open_through_router(endpoints, served, should_stop) if through_router else open_session(endpoints, served)
    )
    link = Link(session, outgoing, credentials, sessions, tap)
    try:
        link.check_connected()
    except RefusedError:
        link.close()
        raise
    by_quic = tuple(endpoint for endpoint in outgoing if endpoint.is_quic)
    if in_lanes and by_quic:
        lane = SessionEndpoints(mode, connect=by_quic), replace(served, serves=Serves.LANE)
        link.take_lanes([open_session(*lane) for _ in range(LANES)])
    return link


def open_router(*, listen: tuple[str, ...], security: LinkSecurity, operators: Sequence[str]) -> Link:
    """Open a router between sites that cannot reach each other; it passes on what the roles of its cell may send."""
    listening = tuple(check_free(endpoint, security) for endpoint in listen)
    served = Served(_credentials(listening, security), tuple(operators))
    return Link(open_session(SessionEndpoints(Mode.ROUTER, listening), served))


def _credentials(endpoints: Sequence[Endpoint], security: LinkSecurity) -> Credentials | None:
    return load_credentials(security.tls) if any(endpoint.is_secured for endpoint in endpoints) else None


def _open_through_router(endpoints: SessionEndpoints, served: Served, should_stop: Callable[[], bool]) -> zenoh.Session:
    """Open a client's session as soon as its router answers; TransportError if it does not in time."""
    deadline_s = time.monotonic() + ROUTER_PATIENCE_S
    while True:
        try:
            return open_session(endpoints, served)
        except TransportError as error:
            why = next((why for endpoint in endpoints.connect if (why := refusal(endpoint, served.credentials))), None)
            if why is not None:
                raise RefusedError(why) from error
            if should_stop() or time.monotonic() > deadline_s:
                raise TransportError(
                    f"no router answers at {endpoints}: start it there with 'farhand router'"
                ) from error
            time.sleep(ROUTER_POLL_S)


def open_session(endpoints: SessionEndpoints, served: Served) -> zenoh.Session:
    """A session of Zenoh with our settings; TransportError when it cannot be opened."""
    prepare_environment()
    config = zenoh.Config()
    for key, value in session_settings(endpoints, served).items():
        config.insert_json5(key, json.dumps(value))
    try:
        return zenoh.open(config)
    except zenoh.ZError as error:
        why = str(error).partition(" at /")[0].strip(" .[")  # without the source location that Zenoh appends
        raise TransportError(f"cannot open {endpoints}: {why}") from error
