"""The settings of a Zenoh session: key by key, and those of its threads, which it reads in the environment alone."""

import os
from dataclasses import dataclass, replace
from enum import StrEnum
from typing import Any

from common.errors import TransportError
from common.link.access import Serves, access_control, no_waiting, payload_caps, rate_caps
from common.link.channels import CHANNELS
from common.link.config import TlsConfig
from common.link.credentials import Credentials
from common.link.endpoints import Endpoint

LEASE_MS = 2000  # longer than most outages: to connect again takes a second more where QUIC loses its first packet
KEEP_ALIVES_PER_LEASE = 4
OPEN_TIMEOUT_MS = 2500  # five round trips of 500 ms; a longer one would delay the return after a partition
RETRY = {"period_init_ms": 100, "period_max_ms": 500, "period_increase_factor": 2}
LANE_RETRY = {"period_init_ms": 1000, "period_max_ms": 2000, "period_increase_factor": 2}  # a listener takes one by one
AT_ONCE = "open/return_conditions/connect_scouted", "open/return_conditions/declares"  # False: opened without waiting
FOR_EVER = -1  # in the background; a client would block
CLIENT_TIMEOUT_MS = 500
MAX_MESSAGE_BYTES = 2 * max(channel.max_bytes for channel in CHANNELS)  # of fragments, before a check
DEAF_AFTER_US = 10_000  # a neighbour that takes nothing for so long is disconnected: all others wait meanwhile
MAX_NEIGHBOURS, MAX_AT_ROUTER = 64, 1024
PICTURES_SEND_BUFFER_BYTES = 1 << 17  # Linux takes twice that: 8 Mbit/s over 240 ms; what waits in more is old
# Closing a TCP or TLS connection, Zenoh waits until the other side has acknowledged what was sent last, for ten seconds
# if need be. It does so in a thread of which there is one for all connections that are accepted, with all of QUIC, one
# for those that are made, and one for all sending. A far site that asked by TLS why it got no answer by QUIC so held up
# the hand samples for a round trip and more; one that vanished meanwhile would for ten seconds.
THREADS = 3  # of each kind: so many connections may be closing at once and hold up no other
LINGER_S = 1
STACK_BYTES = 32 << 20  # a neighbour's names are forgotten chunk by chunk, one call within another
ENVIRONMENT = {
    "ZENOH_RUNTIME": f"({', '.join(f'{kind}: (worker_threads: {THREADS})' for kind in ('acc', 'net', 'tx', 'rx'))})",
    "TCP_LINGER_TIMEOUT": str(LINGER_S),
    "TLS_LINGER_TIMEOUT": str(LINGER_S),
    "RUST_MIN_STACK": str(STACK_BYTES),
}


class Mode(StrEnum):
    """The kind of a session: a peer speaks for itself, a client has all from a router, a router passes on."""

    PEER = "peer"
    CLIENT = "client"
    ROUTER = "router"


@dataclass(frozen=True, slots=True)
class SessionEndpoints:
    """The endpoints where a session listens and connects to; `send_buffer_bytes` None is the system's choice.

    TransportError when QUIC is to have a bounded buffer.
    """

    mode: Mode
    listen: tuple[Endpoint, ...] = ()
    connect: tuple[Endpoint, ...] = ()
    send_buffer_bytes: int | None = None

    def __post_init__(self) -> None:
        for endpoint in (*self.listen, *self.connect):
            if endpoint.is_quic and self.send_buffer_bytes is not None:
                raise TransportError(
                    f"endpoint '{endpoint}' is refused: what waits in a connection of QUIC cannot be bounded, and old "
                    f"pictures would wait there; write it as tls/{endpoint.address}"
                )

    def __str__(self) -> str:
        return ", ".join(map(str, (*self.listen, *self.connect)))


@dataclass(frozen=True, slots=True)
class Served:
    """Whose session it is (None without certificates), whom it serves, and the operators among them."""

    credentials: Credentials | None
    operators: tuple[str, ...] = ()
    serves: Serves = Serves.SITES


def session_settings(endpoints: SessionEndpoints, served: Served) -> dict[str, Any]:
    """Zenoh's settings by path; without credentials no neighbour is refused."""
    listening = [locator for endpoint in endpoints.listen for locator in _listening(endpoint)]
    connecting = [_locator(endpoint) for endpoint in endpoints.connect]
    settings = {
        "mode": endpoints.mode.value,
        "listen/endpoints": listening,
        "connect/endpoints": connecting,
        "connect/retry": LANE_RETRY if served.serves is Serves.LANE else RETRY,
        "connect/timeout_ms": CLIENT_TIMEOUT_MS if endpoints.mode is Mode.CLIENT else FOR_EVER,
        "connect/exit_on_failure": False,
        "scouting/multicast/enabled": False,
        "scouting/gossip/enabled": False,
        "transport/shared_memory/enabled": False,  # on one host pictures would bypass the link and its limits
        "transport/link/protocols": sorted({locator.partition("/")[0] for locator in (*listening, *connecting)}),
        "transport/link/tcp/so_sndbuf": endpoints.send_buffer_bytes,
        "transport/link/tls/so_sndbuf": endpoints.send_buffer_bytes,
        "transport/link/tx/lease": LEASE_MS,
        "transport/link/tx/keep_alive": KEEP_ALIVES_PER_LEASE,
        "transport/link/tx/queue/congestion_control/block/wait_before_close": DEAF_AFTER_US,
        "transport/link/rx/max_message_size": MAX_MESSAGE_BYTES,
        "transport/unicast/open_timeout": OPEN_TIMEOUT_MS,
        "transport/unicast/accept_timeout": OPEN_TIMEOUT_MS,
        "transport/unicast/max_sessions": MAX_AT_ROUTER if endpoints.mode is Mode.ROUTER else MAX_NEIGHBOURS,
        "low_pass_filter": payload_caps(),
        "downsampling": rate_caps(served.operators),
        "qos/network": no_waiting(),
    }
    if served.serves is Serves.LANE:
        settings |= dict.fromkeys(AT_ONCE, False)
    if (credentials := served.credentials) is not None:
        plain = not all(endpoint.is_secured for endpoint in (*endpoints.listen, *endpoints.connect))
        routed = endpoints.mode is Mode.CLIENT
        settings["access_control"] = access_control(
            credentials.identity, served.operators, routed=routed, plain=plain, serves=served.serves
        )
        settings |= {f"transport/link/tls/{key}": value for key, value in _tls_settings(credentials.tls).items()}
    return settings


def _locator(endpoint: Endpoint) -> str:
    """With QUIC, best-effort messages go in datagrams of the same connection."""
    return f"{endpoint}?mixed_rel=1" if endpoint.is_quic else str(endpoint)


def _listening(endpoint: Endpoint) -> tuple[str, ...]:
    """A listener for QUIC also listens for TLS at the same port number, where it can be asked why it refuses."""
    return (_locator(endpoint), str(replace(endpoint, protocol="tls"))) if endpoint.is_quic else (str(endpoint),)


def _tls_settings(tls: TlsConfig) -> dict[str, Any]:
    """One certificate, to listen with and to connect with; both sides show theirs."""
    return {
        "root_ca_certificate": tls.ca,
        "listen_certificate": tls.certificate,
        "listen_private_key": tls.key,
        "connect_certificate": tls.certificate,
        "connect_private_key": tls.key,
        "enable_mtls": True,
        "verify_name_on_connect": True,
        "close_link_on_expiration": True,
    }


def prepare_environment() -> None:
    """Set the environment, which Zenoh reads when a process opens its first session; what is set there stays."""
    for name, value in ENVIRONMENT.items():
        os.environ.setdefault(name, value)
