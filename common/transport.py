"""The only importer of zenoh: sessions with explicit endpoints; publish, latest and request."""

import json
import re
import socket
import time
from collections.abc import Callable
from types import TracebackType
from typing import Generic, Self, TypeVar

import zenoh

from common.channels import CLOCK, Channel, Priority, Procedure
from common.clock import NS_PER_S, RoundTrip
from common.codec import decode, encode
from common.errors import MessageError, RefusedError, TransportError
from common.messages import Message
from common.requests import ClockQuestion, Reply, Request

M = TypeVar("M", bound=Message)
Q = TypeVar("Q", bound=Message)
R = TypeVar("R", bound=Message)
Requested = TypeVar("Requested", bound=Request)
Replied = TypeVar("Replied", bound=Reply)
Refused = Callable[[MessageError], None]

LOOPBACK_ENDPOINT = re.compile(r"tcp/(127\.0\.0\.1|\[::1\]|localhost):\d{1,5}")
LEASE_MS = 1000
KEEP_ALIVES_PER_LEASE = 4
OPEN_TIMEOUT_MS = 1000
RETRY = {"period_init_ms": 100, "period_max_ms": 500, "period_increase_factor": 2}
REQUEST_TIMEOUT_S = 0.3
PENDING_REQUESTS = 16
REFUSAL = b"refused: "  # begins our own error replies; zenoh has others, such as for a time-out
MAX_DEADLINE_NS = 10 * NS_PER_S  # a request is remembered so long that no repetition can outlive it
PRIORITIES = {
    Priority.REAL_TIME: zenoh.Priority.REAL_TIME,
    Priority.INTERACTIVE: zenoh.Priority.INTERACTIVE_HIGH,
    Priority.DATA: zenoh.Priority.DATA,
}


def check_endpoint(endpoint: str) -> str:
    """The endpoint if it stays on this host, else TransportError: links beyond it wait for certificates."""
    if LOOPBACK_ENDPOINT.fullmatch(endpoint) is None:
        raise TransportError(
            f"endpoint {endpoint!r} is refused: without certificates Farhand speaks only on the loopback interface; "
            "write it as tcp/127.0.0.1:PORT"
        )
    return endpoint


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

    def take(self) -> M | None:
        """The oldest message kept and not taken yet, None without one; MessageError for a payload that is none."""
        sample = self._subscriber.try_recv()
        return None if sample is None else self._decode(sample)

    def wait(self) -> M:
        """Block until a message comes; MessageError for a payload that is none, TransportError once closed."""
        try:
            sample = self._subscriber.recv()
        except zenoh.ZError as error:
            raise TransportError("the link was closed") from error
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

    def poll(self, answer: Callable[[Q], R]) -> None:
        """Answer one waiting question, if there is one; never blocks. `refused` hears what could not be understood."""
        query = self._queryable.try_recv()
        if query is None:
            return
        with query:
            try:
                payload = query.payload.to_bytes() if query.payload is not None else b""
                question = decode(payload, self._procedure.request, self._procedure.max_bytes)
            except MessageError as error:
                self._refused(error)
                query.reply_err(REFUSAL + str(error).encode())
                return
            query.reply(self._key, encode(answer(question)))


class Server(Generic[Requested, Replied]):
    """Answers one procedure when polled; a repeated id gets the first answer, an expired one is refused."""

    def __init__(self, answers: Answers[Requested, Replied], reply: type[Replied]) -> None:
        self._answers = answers
        self._reply = reply
        self._done: dict[int, tuple[int, Replied]] = {}

    def poll(self, now_ns: int, handle: Callable[[Requested], Replied]) -> None:
        """Answer one waiting request, if there is one; never blocks."""
        self._answers.poll(lambda request: self._answer(request, now_ns, handle))

    def _answer(self, request: Requested, now_ns: int, handle: Callable[[Requested], Replied]) -> Replied:
        known = self._done.get(request.id)
        if known is not None:
            return known[1]
        if now_ns > request.deadline_ns:
            return self._refuse(request, "expired", "the request came after its deadline; ask again")
        if request.deadline_ns - now_ns > MAX_DEADLINE_NS:
            return self._refuse(request, "deadline", "the deadline is too far ahead: the clocks disagree; ask again")
        self._done = {known: kept for known, kept in self._done.items() if kept[0] >= now_ns}
        reply = handle(request)
        self._done[request.id] = (request.deadline_ns, reply)
        return reply

    def _refuse(self, request: Requested, code: str, reason: str) -> Replied:
        return self._reply(id=request.id, done=False, code=code, reason=reason)


class Link:
    """One Zenoh session; a context manager, so that nothing is left open."""

    def __init__(self, session: zenoh.Session) -> None:
        self._session = session

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
        return Publisher(
            self._session.declare_publisher(
                channel.key_for(cell, name),
                priority=PRIORITIES[channel.priority],
                congestion_control=zenoh.CongestionControl.DROP,
            )
        )

    def latest(self, channel: Channel[M], cell: str, name: str = "*") -> Latest[M]:
        """A subscription that keeps only the newest messages of one key, as many as the channel's depth."""
        handler: zenoh.handlers.RingChannel[zenoh.Sample] = zenoh.handlers.RingChannel(channel.depth)
        return Latest(self._session.declare_subscriber(channel.key_for(cell, name), handler), channel)

    def answer(self, procedure: Procedure[Q, R], cell: str, refused: Refused, name: str = "*") -> Answers[Q, R]:
        """Answer questions in a cell, by polling; `refused` hears of queries that are none."""
        handler: zenoh.handlers.FifoChannel[zenoh.Query] = zenoh.handlers.FifoChannel(PENDING_REQUESTS)
        key = procedure.key_for(cell, name)
        return Answers(self._session.declare_queryable(key, handler), key, procedure, refused)

    def serve(
        self, procedure: Procedure[Requested, Replied], cell: str, refused: Refused, name: str = "*"
    ) -> Server[Requested, Replied]:
        """Answer requests that must happen once, by polling; `refused` hears of queries that are none."""
        return Server(self.answer(procedure, cell, refused, name), procedure.reply)

    def ask(self, procedure: Procedure[Q, R], cell: str, question: Q, name: str = "*") -> R | None:
        """Ask once; None when nobody answers in time, RefusedError when the sites do not understand each other."""
        replies = self._session.get(procedure.key_for(cell, name), payload=encode(question), timeout=REQUEST_TIMEOUT_S)
        for reply in replies:
            if reply.ok is not None:
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
        raise TransportError(f"nobody answered {procedure.key_for(cell, name)}: is that site of cell {cell} running?")

    def round_trip(self, cell: str) -> RoundTrip | None:
        """Ask the remote site's clock once; None when nobody answers in time."""
        asked_ns = time.monotonic_ns()
        answer = self.ask(CLOCK, cell, ClockQuestion())
        heard_ns = time.monotonic_ns()
        return None if answer is None else RoundTrip(asked_ns, answer.received_ns, answer.answered_ns, heard_ns)


def _understood(payload: bytes, procedure: Procedure[Q, R]) -> R:
    try:
        return decode(payload, procedure.reply, procedure.max_bytes)
    except MessageError as error:
        raise RefusedError(f"the other site's answer is refused: {error}") from error


def check_free(endpoint: str) -> None:
    """TransportError at once when this host cannot listen there; zenoh would try for seconds."""
    check_endpoint(endpoint)
    host, _, port = endpoint.removeprefix("tcp/").rpartition(":")
    family = socket.AF_INET6 if host.startswith("[") else socket.AF_INET
    with socket.socket(family, socket.SOCK_STREAM) as probe:
        probe.setsockopt(socket.SOL_SOCKET, socket.SO_REUSEADDR, 1)
        try:
            probe.bind((host.strip("[]"), int(port)))
        except (OSError, OverflowError) as error:
            raise TransportError(f"cannot listen at {endpoint}: {error}; is the port taken by another site?") from error


def open_link(
    *, listen: tuple[str, ...] = (), connect: tuple[str, ...] = (), send_buffer_bytes: int | None = None
) -> Link:
    """Open a session at explicit endpoints; TransportError when one is refused or cannot be opened.

    `send_buffer_bytes` is how much may wait in each connection, None for the system's choice, which is megabytes.
    Listening fails at once when the port is taken; connecting goes on in the background until the other side is there.
    """
    for endpoint in listen:
        check_free(endpoint)
    config = zenoh.Config()
    for key, value in {
        "mode": "peer",
        "listen/endpoints": list(listen),
        "connect/endpoints": [check_endpoint(e) for e in connect],
        "connect/retry": RETRY,
        "connect/exit_on_failure": False,
        "scouting/multicast/enabled": False,
        "scouting/gossip/enabled": False,
        "transport/link/protocols": ["tcp"],
        "transport/shared_memory/enabled": False,  # on one host pictures would pass the link, and all that limits it
        "transport/link/tcp/so_sndbuf": send_buffer_bytes,
        "transport/link/tx/lease": LEASE_MS,
        "transport/link/tx/keep_alive": KEEP_ALIVES_PER_LEASE,
        "transport/unicast/open_timeout": OPEN_TIMEOUT_MS,
        "transport/unicast/accept_timeout": OPEN_TIMEOUT_MS,
    }.items():
        config.insert_json5(key, json.dumps(value))
    try:
        return Link(zenoh.open(config))
    except zenoh.ZError as error:
        places = ", ".join((*listen, *connect))
        raise TransportError(f"cannot open {places}: {str(error).partition(' at /')[0].strip(' .[')}") from error
