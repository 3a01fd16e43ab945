"""Links between sites: Zenoh sessions with explicit endpoints, which publish, subscribe, ask and answer."""

import json
import time
from collections.abc import Callable, Collection, Sequence
from types import TracebackType
from typing import Self, TypeVar

import zenoh

from common.errors import MessageError, RefusedError, TransportError
from common.link.channels import Channel, ChannelSession, Priority, Procedure
from common.link.config import ON_THIS_HOST, LinkSecurity
from common.link.credentials import Credentials, load_credentials
from common.link.endpoints import Endpoint, check_endpoint, check_free
from common.link.probe import identity_refusal, refusal, speaks_tls
from common.link.pubsub import Latest, Publisher
from common.link.roles import Role
from common.link.servers import REFUSAL, IdempotentServer, QuestionServer, Refused, Replied, Requested
from common.link.session_settings import Mode, SessionEndpoints, session_settings
from common.messages.base import Message
from common.messages.codec import decode, encode

M = TypeVar("M", bound=Message)
Q = TypeVar("Q", bound=Message)
R = TypeVar("R", bound=Message)

REQUEST_TIMEOUT_S = 0.3
PENDING_REQUESTS = 16
ROUTER_PATIENCE_S = 20.0
ROUTER_POLL_S = 0.2
QUIC_PATIENCE_S = 3.0  # of a side that has just come up, TLS answers first
CONTROL = (ChannelSession.CONTROL,)
PRIORITIES = {
    Priority.REAL_TIME: zenoh.Priority.REAL_TIME,
    Priority.INTERACTIVE: zenoh.Priority.INTERACTIVE_HIGH,
    Priority.DATA: zenoh.Priority.DATA,
}
RELIABILITY = {True: zenoh.Reliability.BEST_EFFORT, False: zenoh.Reliability.RELIABLE}


class Link:
    """One Zenoh session; a context manager, so that nothing is left open.

    What belongs to another of the site's sessions than its own `sessions` is a TransportError. With credentials, what
    their role may not do is a RefusedError here; the other side refuses it too.
    """

    def __init__(
        self,
        session: zenoh.Session,
        outgoing: Sequence[Endpoint] = (),
        credentials: Credentials | None = None,
        sessions: Collection[ChannelSession] = (),
    ) -> None:
        self._session = session
        self._outgoing = outgoing
        self._credentials = credentials
        self._sessions = sessions
        self._has_met = False
        self._answering_since: float | None = None

    def __enter__(self) -> Self:
        return self

    def __exit__(
        self, kind: type[BaseException] | None, error: BaseException | None, trace: TracebackType | None
    ) -> None:
        self.close()

    def close(self) -> None:
        """Close the session with everything declared on it; closing twice is harmless."""
        if not self._session.is_closed():
            self._session.close()  # type: ignore[no-untyped-call]  # zenoh leaves it unannotated

    def publisher(self, channel: Channel[M], cell: str, name: str = "*") -> Publisher[M]:
        """A publisher of a channel in a cell (`name` for channels of several, as cameras)."""
        key = channel.key_for(cell, name)
        self._check(channel.session, channel.sent_by, cell, f"send {key}")
        return Publisher(
            self._session.declare_publisher(
                key,
                priority=PRIORITIES[channel.priority],
                congestion_control=zenoh.CongestionControl.DROP,
                reliability=RELIABILITY[channel.best_effort],
            )
        )

    def latest(self, channel: Channel[M], cell: str, name: str = "*") -> Latest[M]:
        """A subscription that keeps only the newest messages of one key, as many as the channel's depth."""
        key = channel.key_for(cell, name)
        self._check(channel.session, channel.received_by, cell, f"receive {key}")
        handler: zenoh.handlers.RingChannel[zenoh.Sample] = zenoh.handlers.RingChannel(channel.depth)
        return Latest(self._session.declare_subscriber(key, handler), channel)

    def answer(self, procedure: Procedure[Q, R], cell: str, refused: Refused, name: str = "*") -> QuestionServer[Q, R]:
        """A server of questions in a cell; `refused` is called for queries that cannot be understood."""
        key = procedure.key_for(cell, name)
        self._check(ChannelSession.CONTROL, procedure.answered_by, cell, f"answer {key}")
        # Where questions pile up the oldest is dropped: a full queue would hold up everything else of its link.
        handler: zenoh.handlers.RingChannel[zenoh.Query] = zenoh.handlers.RingChannel(PENDING_REQUESTS)
        return QuestionServer(self._session.declare_queryable(key, handler), key, procedure, refused)

    def serve(
        self, procedure: Procedure[Requested, Replied], cell: str, refused: Refused, name: str = "*"
    ) -> IdempotentServer[Requested, Replied]:
        """A server of requests that must take effect once; `refused` is called for what cannot be understood."""
        return IdempotentServer(self.answer(procedure, cell, refused, name), procedure.reply)

    def ask(self, procedure: Procedure[Q, R], cell: str, question: Q, name: str = "*") -> R | None:
        """Ask once; None without an answer in time, RefusedError when the sites do not understand each other."""
        key = procedure.key_for(cell, name)
        self._check(ChannelSession.CONTROL, procedure.asked_by, cell, f"ask {key}")
        for reply in self._session.get(key, payload=encode(question), timeout=REQUEST_TIMEOUT_S):
            if reply.ok is not None:
                self._has_met = True
                return _understood(reply.ok.payload.to_bytes(), procedure)
            if reply.err is not None and (why := reply.err.payload.to_bytes()).startswith(REFUSAL):
                raise RefusedError(f"the other site {why.decode(errors='replace')}")
        return None

    def may_receive(self, channel: Channel[M]) -> bool:
        """Whether our certificate allows it; without certificates every site may."""
        return self._credentials is None or self._credentials.identity.role in channel.received_by

    def check_connected(self) -> None:
        """RefusedError with a sentence when one of our endpoints and this side refuse each other; nothing otherwise.

        A site that does not listen yet does not count as a refusal. Takes up to two seconds.
        """
        links = self._session.info.links()
        for endpoint in self._outgoing:
            link, why = next((link for link in links if _leads_to(link, endpoint)), None), None
            if link is None:
                why = refusal(endpoint, self._credentials) or self._blocked(endpoint)
            elif endpoint.is_secured and self._credentials is not None:
                why = identity_refusal(link.auth_identifier or "", str(endpoint), self._credentials.identity)
            if why is not None:
                raise RefusedError(why)

    def _blocked(self, endpoint: Endpoint) -> str | None:
        """Why there was never a link by QUIC though TLS has answered for a while; after an outage one comes back."""
        if not endpoint.is_quic or self._has_met or not speaks_tls(endpoint):
            self._answering_since = None
            return None
        now = time.monotonic()
        self._answering_since = self._answering_since or now
        if now - self._answering_since < QUIC_PATIENCE_S:
            return None
        return (
            f"{endpoint} answers by TLS, but not by QUIC: let UDP through to port {endpoint.port}, or write the "
            f"endpoint as tls/{endpoint.address} at both sites"
        )

    def _check(self, session: ChannelSession, allowed: frozenset[Role], cell: str, what: str) -> None:
        if session not in self._sessions:
            ours = " and ".join(self._sessions)
            raise TransportError(
                f"a link of the {ours} session may not {what}: that belongs to a link of the {session} session, opened "
                f"at the site's {session} endpoint"
            )
        if self._credentials is None:
            return
        own, roles = self._credentials.identity, " or ".join(sorted(allowed))
        if own.role is not Role.ROUTER and own.cell != cell:
            raise RefusedError(f"the certificate of {own.common_name} is for cell {own.cell}; it may not {what}")
        if own.role not in allowed:
            raise RefusedError(
                f"the certificate of {own.common_name} may not {what}: that takes one of {roles}, in [links.tls]"
            )


def _leads_to(link: zenoh.Link, endpoint: Endpoint) -> bool:
    """By protocol and port: the host's name has become an address."""
    destination = link.dst.partition("?")[0]
    return destination.startswith(f"{endpoint.protocol}/") and destination.endswith(f":{endpoint.port}")


def _understood(payload: bytes, procedure: Procedure[Q, R]) -> R:
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
    send_buffer_bytes: int | None = None,
    through_router: bool = False,
    given_up: Callable[[], bool] = lambda: False,
) -> Link:
    """Open a session at explicit endpoints; TransportError when one is not allowed or cannot be opened.

    `sessions` are those that the endpoints belong to; the link carries their channels only. `send_buffer_bytes` is how
    much may wait in each connection, None for the system's choice, which is megabytes. Listening fails immediately when
    the port is taken; connecting continues in the background until the other side is there, but a side that is there
    and refuses us, or that we refuse, is a RefusedError. `through_router` is for a site that others cannot reach: all
    messages pass the router at `connect`, waited for until `given_up`.
    """
    listening = tuple(check_free(endpoint, security) for endpoint in listen)
    outgoing = tuple(check_endpoint(endpoint, security) for endpoint in connect)
    credentials = _credentials((*listening, *outgoing), security)
    cells = [credentials.identity.cell] if credentials and credentials.identity.cell else []
    mode = Mode.CLIENT if through_router else Mode.PEER
    endpoints = SessionEndpoints(mode, listening, outgoing, send_buffer_bytes)
    if through_router:
        session = _open_when_met(endpoints, credentials, cells, given_up)
    else:
        session = _open(endpoints, credentials, cells)
    link = Link(session, outgoing, credentials, sessions)
    try:
        link.check_connected()
    except RefusedError:
        link.close()
        raise
    return link


def open_router(*, listen: tuple[str, ...], cells: Sequence[str], security: LinkSecurity) -> Link:
    """Open the meeting point of sites that cannot reach each other; it passes on what the cells' roles may send."""
    listening = tuple(check_free(endpoint, security) for endpoint in listen)
    credentials = _credentials(listening, security)
    return Link(_open(SessionEndpoints(Mode.ROUTER, listening), credentials, cells))


def _credentials(endpoints: Sequence[Endpoint], security: LinkSecurity) -> Credentials | None:
    return load_credentials(security.tls) if any(endpoint.is_secured for endpoint in endpoints) else None


def _open_when_met(
    endpoints: SessionEndpoints, credentials: Credentials | None, cells: Sequence[str], given_up: Callable[[], bool]
) -> zenoh.Session:
    """Open a client's session as soon as its router is there; TransportError when it does not come."""
    give_up = time.monotonic() + ROUTER_PATIENCE_S
    while True:
        try:
            return _open(endpoints, credentials, cells)
        except TransportError as error:
            why = next((why for endpoint in endpoints.connect if (why := refusal(endpoint, credentials))), None)
            if why is not None:
                raise RefusedError(why) from error
            if given_up() or time.monotonic() > give_up:
                raise TransportError(
                    f"no router answers at {endpoints}: start it there with 'farhand router'"
                ) from error
            time.sleep(ROUTER_POLL_S)


def _open(endpoints: SessionEndpoints, credentials: Credentials | None, cells: Sequence[str]) -> zenoh.Session:
    config = zenoh.Config()
    for key, value in session_settings(endpoints, credentials, cells).items():
        config.insert_json5(key, json.dumps(value))
    try:
        return zenoh.open(config)
    except zenoh.ZError as error:
        raise TransportError(f"cannot open {endpoints}: {str(error).partition(' at /')[0].strip(' .[')}") from error
