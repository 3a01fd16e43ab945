"""Passes on what viewers may see and ask between their own endpoint and the site; no viewer can delay the site."""

import contextlib
import threading
import time
from collections import deque
from collections.abc import Callable, Sequence
from dataclasses import replace
from types import TracebackType
from typing import Any, Generic, NamedTuple, Self, TypeVar

import zenoh

from common.clock import NS_PER_S
from common.link.access import Serves
from common.link.channels import CHANNELS, PROCEDURES, Channel
from common.link.config import LinkSecurity, ViewersConfig
from common.link.credentials import load_credentials
from common.link.endpoints import Endpoint, check_endpoint, check_free, from_this_host
from common.link.rate_cap import RateCap
from common.link.roles import Role
from common.link.session_settings import PICTURES_SEND_BUFFER_BYTES, Mode, Served, SessionEndpoints
from common.link.transport import PENDING_REQUESTS, PRIORITIES, REQUEST_TIMEOUT_S, Link, open_session

SEEN = tuple(channel for channel in CHANNELS if Role.VIEWER in channel.received_by)
SENT = tuple(channel for channel in CHANNELS if Role.VIEWER in channel.sent_by)
ASKED = tuple(procedure for procedure in PROCEDURES if Role.VIEWER in procedure.asked_by)
SENT_HZ = 10.0
CAMERAS = 4  # more lose pictures sooner, when this process has to wait
QUESTIONS_APART_S = 0.02  # control answers one in each tick of 4 ms

T = TypeVar("T")


class Site(NamedTuple):
    """The site, or router, that viewers watch: its cell, and its endpoints with what protects them."""

    cell: str
    endpoints: Sequence[str]
    security: LinkSecurity


class Waiting(Generic[T]):
    """The newest of what waits to be passed on, at most `depth`; who adds never waits for who takes."""

    def __init__(self, depth: int) -> None:
        self._kept: deque[T] = deque(maxlen=depth)
        self._ready = threading.Condition()

    def add(self, one: T) -> None:
        """Keep one more, instead of the oldest if there are too many."""
        with self._ready:
            self._kept.append(one)
            self._ready.notify()

    def take(self) -> T:
        """The oldest that is kept, as soon as there is one."""
        with self._ready:
            self._ready.wait_for(lambda: self._kept)
            return self._kept.popleft()


class _Shown:
    """A channel that viewers see: received from the site only while one of them listens."""

    def __init__(self, channel: Channel[Any], inside: zenoh.Session, outside: zenoh.Session, cell: str) -> None:
        self._key, self._inside = channel.key_for(cell), inside
        self._outside = outside.declare_publisher(self._key)
        self._subscriber: zenoh.Subscriber[None] | None = None
        depth = channel.depth * (CAMERAS if channel.key_for(cell, "one") != self._key else 1)
        self._waiting = Waiting[zenoh.Sample](depth)
        _start(f"show {self._key}", lambda: _put(outside, channel, self._waiting.take()))

    def follow(self) -> None:
        """Listen to the site while a viewer listens to us."""
        wanted = bool(self._outside.matching_status.matching)  # type: ignore[attr-defined]  # its stub says bool
        if wanted and self._subscriber is None:
            self._subscriber = self._inside.declare_subscriber(self._key, self._waiting.add)
        elif not wanted and self._subscriber is not None:
            self._subscriber.undeclare()  # type: ignore[no-untyped-call]  # zenoh leaves it unannotated
            self._subscriber = None


class Passage:
    """The site's neighbour and what viewers connect to; a context manager that closes both, which are `links` too."""

    def __init__(
        self, site_session: zenoh.Session, viewers_session: zenoh.Session, links: Sequence[Link], cell: str
    ) -> None:
        self._links = links
        self._shown = [_Shown(channel, site_session, viewers_session, cell) for channel in SEEN]
        self._declared: list[Any] = []
        for channel in SENT:
            sent = Waiting[zenoh.Sample](channel.depth)
            self._declared.append(viewers_session.declare_subscriber(channel.key_for(cell), sent.add))
            _start(f"send {channel.key_for(cell)}", _pace(site_session, channel, sent))
        for procedure in ASKED:
            asked = Waiting[zenoh.Query](PENDING_REQUESTS)
            self._declared.append(viewers_session.declare_queryable(procedure.key_for(cell), asked.add))
            _start(f"ask {procedure.key_for(cell)}", _ask(site_session, procedure.key_for(cell), asked))

    def __enter__(self) -> Self:
        return self

    def __exit__(
        self, kind: type[BaseException] | None, error: BaseException | None, trace: TracebackType | None
    ) -> None:
        for link in self._links:
            link.close()

    def follow(self) -> None:
        """Receive from the site what a viewer listens to now, and nothing else; call it several times a second."""
        for shown in self._shown:
            shown.follow()


def open_passage(viewers: ViewersConfig, table: str, site: Site) -> Passage:
    """Let viewers connect, and connect to the site; TransportError as `open_link`, naming the `table` of certificates.

    Inside it is one neighbour, which may do no more than a viewer, however many viewers there are. Outside, messages
    to a viewer that is slow are dropped.
    """
    listening = check_free(viewers.listen, viewers.security)
    reached = tuple(_by_tls(check_endpoint(from_this_host(each), site.security)) for each in site.endpoints)
    own = load_credentials(site.security.tls) if any(endpoint.is_secured for endpoint in reached) else None
    site_session = open_session(SessionEndpoints(Mode.PEER, connect=reached), Served(own, serves=Serves.OWN_SITE))
    inside = Link(site_session, reached, own)
    try:
        inside.check_connected()
        shown = load_credentials(viewers.tls, table)
        endpoints = SessionEndpoints(Mode.PEER, (listening,), send_buffer_bytes=PICTURES_SEND_BUFFER_BYTES)
        viewers_session = open_session(endpoints, Served(shown, serves=Serves.VIEWERS))
    except Exception:
        inside.close()
        raise
    return Passage(site_session, viewers_session, (inside, Link(viewers_session)), site.cell)


def _by_tls(endpoint: Endpoint) -> Endpoint:
    """A listener for QUIC listens for TLS at the same port; on one host no packet is lost."""
    return replace(endpoint, protocol="tls") if endpoint.is_quic else endpoint


def _put(session: zenoh.Session, channel: Channel[Any], sample: zenoh.Sample) -> None:
    drop, priority = zenoh.CongestionControl.DROP, PRIORITIES[channel.priority]
    session.put(sample.key_expr, sample.payload, congestion_control=drop, priority=priority)


def _pace(inside: zenoh.Session, channel: Channel[Any], sent: Waiting[zenoh.Sample]) -> Callable[[], None]:
    """Passes on what viewers send, however many they are at SENT_HZ."""
    cap = RateCap(SENT_HZ, channel.depth)

    def pass_on() -> None:
        sample = sent.take()
        time.sleep(cap.pause_ns(time.monotonic_ns()) / NS_PER_S)
        cap.passed(time.monotonic_ns())
        _put(inside, channel, sample)

    return pass_on


def _ask(inside: zenoh.Session, key: str, asked: Waiting[zenoh.Query]) -> Callable[[], None]:
    """Asks the site what viewers ask, one question after another, and gives its answer back."""

    def ask() -> None:
        with asked.take() as query:
            for reply in inside.get(key, payload=query.payload, timeout=REQUEST_TIMEOUT_S):
                if reply.ok is not None:
                    query.reply(key, reply.ok.payload)
                elif reply.err is not None:
                    query.reply_err(reply.err.payload)
        time.sleep(QUESTIONS_APART_S)

    return ask


def _start(name: str, once: Callable[[], None]) -> None:
    """Call it again and again, on a thread of its own; once its session is closed it only waits."""

    def run() -> None:
        while True:
            with contextlib.suppress(zenoh.ZError):  # who asked may be gone
                once()

    threading.Thread(target=run, name=name, daemon=True).start()
