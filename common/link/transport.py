"""The only importer of zenoh: sessions with explicit endpoints; publish, latest and request."""

import json
import time
from collections.abc import Callable, Sequence
from types import TracebackType
from typing import Generic, Self, TypeVar

import structlog
import zenoh

from common.clock import NS_PER_S, RoundTrip
from common.errors import MessageError, RefusedError, TransportError
from common.link.channels import (
    CLOCK,
    Channel,
    Priority,
    Procedure,
)
from common.link.config import ON_THIS_HOST, LinkSecurity
from common.link.credentials import Credentials, load_credentials
from common.link.endpoints import Endpoint, check_endpoint, check_free
from common.link.once import Replied, Requested, Server
from common.link.probe import answers, identity_refusal, refusal
from common.link.rate_cap import RateCap
from common.link.roles import Role
from common.link.session_settings import Mode, Places, session_settings
from common.messages.base import Message
from common.messages.codec import decode, encode
from common.messages.requests import ClockQuestion

M = TypeVar("M", bound=Message)
Q = TypeVar("Q", bound=Message)
R = TypeVar("R", bound=Message)
Refused = Callable[[MessageError], None]

REQUEST_TIMEOUT_S = 0.3
PENDING_REQUESTS = 16
ROUTER_PATIENCE_S = 20.0
ROUTER_POLL_S = 0.2
QUIC_PATIENCE_S = 3.0  # of a side that has just come up, TLS answers first
REFUSAL = b"refused: "  # begins our own error replies; zenoh has others, such as for a time-out
PRIORITIES = {
    Priority.REAL_TIME: zenoh.Priority.REAL_TIME,
    Priority.INTERACTIVE: zenoh.Priority.INTERACTIVE_HIGH,
    Priority.DATA: zenoh.Priority.DATA,
}
RELIABILITY = {True: zenoh.Reliability.BEST_EFFORT, False: zenoh.Reliability.RELIABLE}


class Publisher(Generic[M]):
    """Puts messages on one key; dropped under congestion, never blocking."""

    def __init__(self, publisher: zenoh.Publisher) -> None:
        self._publisher = publisher

    def put(self, message: M) -> None:
        """Send a message; MessageError when it holds a number that is not finite."""
        self._publisher.put(encode(message))

    @property
    def has_listener(self) -> bool:
        """Whether anybody subscribes to this key now, as far as this session has heard."""
        return bool(self._publisher.matching_status.matching)  # type: ignore[attr-defined]  # its stub says bool


class Latest(Generic[M]):
    """The newest messages of one key, as many as the channel's depth: older ones that nobody took are dropped."""

    def __init__(
        self, subscriber: "zenoh.Subscriber[zenoh.handlers.Handler[zenoh.Sample]]", channel: Channel[M]
    ) -> None:
        self._subscriber = subscriber
        self._channel = channel
        self._cap = RateCap(channel.most_hz, channel.depth + 1)

    def take(self) -> M | None:
        """The oldest message kept and not taken yet, None without one; MessageError for a payload that is none."""
        sample = self._subscriber.try_recv()
        return None if sample is None else self._decode(sample)

    def wait(self) -> M:
        """Block until a message comes; MessageError for a payload that is none, TransportError once closed.

        In a flood it pauses, so that no more than the channel's `most_hz` are taken; Zenoh keeps the newest meanwhile.
        """
        self._hold_back()
        try:
            sample = self._subscriber.recv()
        except zenoh.ZError as error:
            raise TransportError("the link was closed") from error
        self._cap.passed(time.monotonic_ns())
        return self._decode(sample)

    def feed(self, take: Callable[[M, int], None]) -> None:
        """Hand on each message with its arrival time (ns) until the link is closed; what is no message passes by."""
        while True:
            try:
                message = self.wait()
            except MessageError:
                continue
            except TransportError:
                return
            take(message, time.monotonic_ns())

    def _hold_back(self) -> None:
        was_flooded, pause_ns = self._cap.flooded, self._cap.pause_ns(time.monotonic_ns())
        if self._cap.flooded and not was_flooded:
            self._warn()
        if pause_ns:
            time.sleep(pause_ns / NS_PER_S)

    def _warn(self) -> None:
        key, most_hz = str(self._subscriber.key_expr), self._channel.most_hz
        sentence = f"somebody floods {key}: {most_hz:g} a second are taken, of the newest; the rest is dropped"
        structlog.get_logger().warning("too many messages", reason=sentence)

    def _decode(self, sample: zenoh.Sample) -> M:
        return decode(sample.payload.to_bytes(), self._channel.message, self._channel.max_bytes)


class Answers(Generic[Q, R]):
    """Answers questions that may be asked again, when polled; what is no question is refused with a sentence."""

    def __init__(
        self,
        queryable: "zenoh.Queryable[zenoh.handlers.Handler[zenoh.Query]]",
        key: str,
        procedure: Procedure[Q, R],
        refused: Refused,
    ) -> None:
        self._queryable = queryable
        self._key = key
        self._procedure = procedure
        self._refused = refused

    def take(self) -> tuple[Q, Callable[[R], None]] | None:
        """A waiting question and what answers it, None without one; never blocks.

        `refused` is called for what could not be understood.
        """
        query = self._queryable.try_recv()
        if query is None:
            return None
        try:
            payload = query.payload.to_bytes() if query.payload is not None else b""
            question = decode(payload, self._procedure.request, self._procedure.max_bytes)
        except MessageError as error:
            self._refused(error)
            with query:
                query.reply_err(REFUSAL + str(error).encode())
            return None

        def reply(answer: R) -> None:
            with query:
                query.reply(self._key, encode(answer))

        return question, reply

    def poll(self, answer: Callable[[Q], R]) -> None:
        """Answer one waiting question, if there is one; never blocks."""
        waiting = self.take()
        if waiting is not None:
            question, reply = waiting
            reply(answer(question))


class Link:
    """One Zenoh session; a context manager, so that nothing is left open.

    With credentials, what their role may not do is a RefusedError here; the other side refuses it besides.
    """

    def __init__(
        self, session: zenoh.Session, outgoing: Sequence[Endpoint] = (), credentials: Credentials | None = None
    ) -> None:
        self._session = session
        self._outgoing = outgoing
        self._credentials = credentials
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
        self._check(channel.sent_by, cell, f"send {channel.key_for(cell, name)}")
        return Publisher(
            self._session.declare_publisher(
                channel.key_for(cell, name),
                priority=PRIORITIES[channel.priority],
                congestion_control=zenoh.CongestionControl.DROP,
                reliability=RELIABILITY[channel.best_effort],
            )
        )

    def latest(self, channel: Channel[M], cell: str, name: str = "*") -> Latest[M]:
        """A subscription that keeps only the newest messages of one key, as many as the channel's depth."""
        self._check(channel.heard_by, cell, f"hear {channel.key_for(cell, name)}")
        handler: zenoh.handlers.RingChannel[zenoh.Sample] = zenoh.handlers.RingChannel(channel.depth)
        return Latest(self._session.declare_subscriber(channel.key_for(cell, name), handler), channel)

    def answer(self, procedure: Procedure[Q, R], cell: str, refused: Refused, name: str = "*") -> Answers[Q, R]:
        """Answer questions in a cell, by polling; `refused` hears of queries that are none."""
        # Where questions pile up the oldest is dropped: a full queue would hold up everything else of its link.
        handler: zenoh.handlers.RingChannel[zenoh.Query] = zenoh.handlers.RingChannel(PENDING_REQUESTS)
        key = procedure.key_for(cell, name)
        self._check(procedure.answered_by, cell, f"answer {key}")
        return Answers(self._session.declare_queryable(key, handler), key, procedure, refused)

    def serve(
        self, procedure: Procedure[Requested, Replied], cell: str, refused: Refused, name: str = "*"
    ) -> Server[Requested, Replied]:
        """Answer requests that must happen once, by polling; `refused` hears of queries that are none."""
        return Server(self.answer(procedure, cell, refused, name).take, procedure.reply)

    def ask(self, procedure: Procedure[Q, R], cell: str, question: Q, name: str = "*") -> R | None:
        """Ask once; None when nobody answers in time, RefusedError when the sites do not understand each other."""
        key = procedure.key_for(cell, name)
        self._check(procedure.asked_by, cell, f"ask {key}")
        replies = self._session.get(key, payload=encode(question), timeout=REQUEST_TIMEOUT_S)
        for reply in replies:
            if reply.ok is not None:
                self._has_met = True
                return _understood(reply.ok.payload.to_bytes(), procedure)
            if reply.err is not None and (why := reply.err.payload.to_bytes()).startswith(REFUSAL):
                raise RefusedError(f"the other site {why.decode(errors='replace')}")
        return None

    def request(
        self, procedure: Procedure[Requested, Replied], cell: str, request: Requested, give_up_ns: int, name: str = "*"
    ) -> Replied:
        """Ask until `give_up_ns` by our clock, always with the same id; TransportError when nobody answered."""
        while time.monotonic_ns() < give_up_ns:
            attempt_ends = time.monotonic() + REQUEST_TIMEOUT_S
            reply = self.ask(procedure, cell, request, name)
            if reply is not None:
                return reply
            time.sleep(max(0.0, min(attempt_ends, give_up_ns / NS_PER_S) - time.monotonic()))
        raise TransportError(f"nobody answered at cell {cell}: is the site that is asked running?")

    def round_trip(self, cell: str) -> RoundTrip | None:
        """Ask the remote site's clock once; None when nobody answers in time."""
        asked_ns = time.monotonic_ns()
        answer = self.ask(CLOCK, cell, ClockQuestion())
        heard_ns = time.monotonic_ns()
        return None if answer is None else RoundTrip(asked_ns, answer.received_ns, answer.answered_ns, heard_ns)

    def may_hear(self, channel: Channel[M]) -> bool:
        """Whether our certificate lets us; everybody may where there are none."""
        return self._credentials is None or self._credentials.identity.role in channel.heard_by

    def check_connected(self) -> None:
        """RefusedError with a sentence when one of our endpoints and this side refuse each other; nothing otherwise.

        Where nobody listens yet, that is no refusal. Takes up to two seconds.
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
        """Why there was never a link by QUIC where TLS has answered for so long; after an outage one comes back."""
        if not endpoint.is_quic or self._has_met or not answers(endpoint):
            self._answering_since = None
            return None
        now = time.monotonic()
        self._answering_since = self._answering_since or now
        if now - self._answering_since < QUIC_PATIENCE_S:
            return None
        return (
            f"{endpoint} answers by TLS, but not by QUIC: let UDP through to port {endpoint.port}, or write the "
            f"endpoint as tls/{endpoint.place} at both sites"
        )

    def _check(self, allowed: frozenset[Role], cell: str, what: str) -> None:
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
    """Names become addresses on the way, so the port tells."""
    place = link.dst.partition("?")[0]
    return place.startswith(f"{endpoint.protocol}/") and place.endswith(f":{endpoint.port}")


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
    send_buffer_bytes: int | None = None,
    through_router: bool = False,
    given_up: Callable[[], bool] = lambda: False,
) -> Link:
    """Open a session at explicit endpoints; TransportError when one is not allowed or cannot be opened.

    `send_buffer_bytes` is how much may wait in each connection, None for the system's choice, which is megabytes.
    Listening fails at once when the port is taken; connecting goes on in the background until the other side is there,
    but a side that is there and refuses us, or that we refuse, is a RefusedError. `through_router` is for who answers
    where nobody can reach it: everything comes and goes by the router at `connect`, waited for until `given_up`.
    """
    listening = _listening(listen, security)
    outgoing = tuple(check_endpoint(endpoint, security) for endpoint in connect)
    _check_buffer((*listening, *outgoing), send_buffer_bytes)
    credentials = _credentials((*listening, *outgoing), security)
    cells = [credentials.identity.cell] if credentials and credentials.identity.cell else []
    mode = Mode.CLIENT if through_router else Mode.PEER
    places = Places(mode, listening, outgoing, send_buffer_bytes)
    session = (
        _open_when_met(places, credentials, cells, given_up) if through_router else _open(places, credentials, cells)
    )
    link = Link(session, outgoing, credentials)
    try:
        link.check_connected()
    except RefusedError:
        link.close()
        raise
    return link


def open_router(*, listen: tuple[str, ...], cells: Sequence[str], security: LinkSecurity) -> Link:
    """Open the meeting point of sites that cannot reach each other; it passes on what the cells' roles may send."""
    listening = _listening(listen, security)
    credentials = _credentials(listening, security)
    return Link(_open(Places(Mode.ROUTER, listening), credentials, cells), (), credentials)


def _listening(endpoints: tuple[str, ...], security: LinkSecurity) -> tuple[Endpoint, ...]:
    return tuple(check_free(endpoint, security) for endpoint in endpoints)


def _check_buffer(places: Sequence[Endpoint], send_buffer_bytes: int | None) -> None:
    for place in places:
        if place.is_quic and send_buffer_bytes is not None:
            raise TransportError(
                f"endpoint '{place}' is refused: what waits in a connection of QUIC cannot be bounded, and old "
                f"pictures would; write it as tls/{place.place}"
            )


def _credentials(places: Sequence[Endpoint], security: LinkSecurity) -> Credentials | None:
    return load_credentials(security.tls) if any(place.is_secured for place in places) else None


def _open_when_met(
    places: Places, credentials: Credentials | None, cells: Sequence[str], given_up: Callable[[], bool]
) -> zenoh.Session:
    """Open a client's session as soon as its router is there; TransportError when it does not come."""
    give_up = time.monotonic() + ROUTER_PATIENCE_S
    while True:
        try:
            return _open(places, credentials, cells)
        except TransportError as error:
            why = next((why for endpoint in places.connect if (why := refusal(endpoint, credentials))), None)
            if why is not None:
                raise RefusedError(why) from error
            if given_up() or time.monotonic() > give_up:
                raise TransportError(f"no router answers at {places}: start it there with 'farhand router'") from error
            time.sleep(ROUTER_POLL_S)


def _open(places: Places, credentials: Credentials | None, cells: Sequence[str]) -> zenoh.Session:
    config = zenoh.Config()
    for key, value in session_settings(places, credentials, cells).items():
        config.insert_json5(key, json.dumps(value))
    try:
        return zenoh.open(config)
    except zenoh.ZError as error:
        raise TransportError(f"cannot open {places}: {str(error).partition(' at /')[0].strip(' .[')}") from error
