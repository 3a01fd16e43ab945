"""Endpoints: which are allowed with what protection, and whether this host can listen there."""

import re
import socket
from dataclasses import dataclass

from common.errors import TransportError
from common.link.config import LinkSecurity
from common.link.port_holders import why_not_bound

ENDPOINT = re.compile(r"(tcp|tls|quic)/(\[[0-9a-fA-F:.]+\]|[A-Za-z0-9._-]+):(\d{1,5})")
LAST_PORT = 65535
SECURED = ("tls", "quic")
LOOPBACK = ("127.0.0.1", "::1", "localhost")
EVERYWHERE = {"0.0.0.0": "127.0.0.1", "::": "::1"}  # noqa: S104  # recognised here, never bound


@dataclass(frozen=True, slots=True)
class Endpoint:
    """An address to listen on or to connect to."""

    protocol: str
    host: str
    port: int

    @property
    def is_loopback(self) -> bool:
        """Return whether its traffic stays on this host."""
        return self.host in LOOPBACK

    @property
    def is_secured(self) -> bool:
        """Return whether both sides show certificates."""
        return self.protocol in SECURED

    @property
    def is_quic(self) -> bool:
        """Return whether best-effort messages go in datagrams, so that none waits for a lost one before it."""
        return self.protocol == "quic"

    @property
    def address(self) -> str:
        """Host and port, as an endpoint writes them."""
        return f"[{self.host}]:{self.port}" if ":" in self.host else f"{self.host}:{self.port}"

    def __str__(self) -> str:
        return f"{self.protocol}/{self.address}"


def check_endpoint(endpoint: str, security: LinkSecurity) -> Endpoint:
    """The endpoint if its traffic is protected or stays on this host, else TransportError with the cure."""
    match = ENDPOINT.fullmatch(endpoint)
    if match is None or not 0 < int(match[3]) <= LAST_PORT:
        raise TransportError(
            f"endpoint {endpoint!r} is refused: write it as tls/HOST:PORT, quic/HOST:PORT or tcp/127.0.0.1:PORT, with "
            f"a port from 1 to {LAST_PORT}"
        )
    found = Endpoint(match[1], match[2].strip("[]"), int(match[3]))
    if found.is_secured and not security.tls.is_given:
        raise TransportError(
            f"endpoint {endpoint!r} is refused: {found.protocol} needs certificates; make them with 'farhand "
            "certificates create CELL' and name them in the table [links.tls], in a router's file [tls]"
        )
    if not (found.is_secured or found.is_loopback or security.plain_text_beyond_loopback):
        raise TransportError(
            f"endpoint {endpoint!r} is refused: plain tcp beyond this host would let anybody move the arm; write it "
            f"as tls/{endpoint.removeprefix('tcp/')} with certificates from 'farhand certificates create CELL', or "
            "stay at tcp/127.0.0.1:PORT"
        )
    return found


def check_free(endpoint: str, security: LinkSecurity) -> Endpoint:
    """The endpoint if it is allowed and free; TransportError immediately if not; Zenoh would try for seconds."""
    checked = check_endpoint(endpoint, security)
    family = socket.AF_INET6 if ":" in checked.host else socket.AF_INET
    for kind in (socket.SOCK_STREAM, socket.SOCK_DGRAM) if checked.is_quic else (socket.SOCK_STREAM,):
        with socket.socket(family, kind) as probe:
            if kind is socket.SOCK_STREAM:
                probe.setsockopt(socket.SOL_SOCKET, socket.SO_REUSEADDR, 1)
            try:
                probe.bind((checked.host, checked.port))
            except OSError as error:
                why = why_not_bound(error, checked.port)
                raise TransportError(f"cannot listen at {endpoint}: {why}") from error
    return checked


def stays_here(endpoint: str) -> bool:
    """Return whether the traffic of an endpoint stays on this host, unless somebody forwards its port."""
    match = ENDPOINT.fullmatch(endpoint)
    return match is not None and match[2].strip("[]") in LOOPBACK


def from_this_host(endpoint: str) -> str:
    """Return where a program of this host reaches a listener: one on all interfaces includes the loopback interface."""
    match = ENDPOINT.fullmatch(endpoint)
    if match is None:
        return endpoint
    host = match[2].strip("[]")
    return str(Endpoint(match[1], EVERYWHERE.get(host, host), int(match[3])))
