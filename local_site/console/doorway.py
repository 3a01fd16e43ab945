"""Connections on their way to the page: few, none for long, so that half-open ones never keep anybody out."""

import asyncio
import ssl
from collections import Counter
from collections.abc import Callable
from ipaddress import IPv6Address, ip_address
from typing import Any

import h11
from uvicorn.protocols.http.h11_impl import H11Protocol

IPV6_HOST_BITS = 64
MOST_AT_ONCE = 128  # a browser opens six
ANSWERED_WITHIN_S = 20.0  # from the connection, or the last answer, to the end of the next answer


class Doorway:
    """The connections that are no page yet, each with its time; beyond `most` one of them goes for each that comes.

    That is the oldest of the address with the most, so that nobody displaces the connections of another address.
    """

    def __init__(self, most: int = MOST_AT_ONCE, patience_s: float = ANSWERED_WITHIN_S) -> None:
        self._most, self._patience_s = most, patience_s
        self._open: dict[asyncio.Transport, asyncio.TimerHandle] = {}  # the oldest first

    def __len__(self) -> int:
        return len(self._open)

    def enter(self, transport: asyncio.Transport) -> None:
        """A connection begins to wait for an answer; it is closed unless it leaves, or enters again, in time."""
        self.leave(transport)
        if len(self._open) >= self._most:
            oldest = self._oldest_of_the_most()
            self.leave(oldest)
            oldest.abort()
        closing = asyncio.get_running_loop().call_later(self._patience_s, transport.abort)
        self._open[transport] = closing

    def leave(self, transport: asyncio.Transport) -> None:
        """It has ended, or has become a page."""
        closing = self._open.pop(transport, None)
        if closing is not None:
            closing.cancel()

    def _oldest_of_the_most(self) -> asyncio.Transport:
        counted = Counter(map(_address, self._open))
        most = max(counted.values())
        return next(transport for transport in self._open if counted[_address(transport)] == most)


def _address(transport: asyncio.Transport) -> str:
    """Of IPv6 its network of 64 bits: a host has all of them."""
    peer = transport.get_extra_info("peername")
    try:
        address = ip_address(peer[0].partition("%")[0]) if peer else None
    except ValueError:
        return str(peer[0])
    if isinstance(address, IPv6Address) and address.ipv4_mapped is None:
        return str(int(address) >> IPV6_HOST_BITS)
    return str(address)


class DoorwayProtocol(H11Protocol):
    """HTTP as the library has it, in a doorway until it becomes a page's WebSocket."""

    def __init__(self, doorway: Doorway, **of_library: Any) -> None:
        super().__init__(**of_library)
        self._doorway = doorway
        self._early = b""

    def connection_made(self, transport: asyncio.Transport) -> None:  # type: ignore[override]  # as the library has it
        """A connection, with TLS after its handshake."""
        super().connection_made(transport)
        self._doorway.enter(transport)
        if self._early:
            super().data_received(self._early)

    def data_received(self, data: bytes) -> None:
        """Pass data on, or keep it: what comes with the end of a handshake is there before the connection is."""
        if self.transport is None:
            self._early += data
        else:
            super().data_received(data)

    def connection_lost(self, exc: Exception | None) -> None:
        """It has ended, perhaps in its handshake."""
        if self.transport is not None:
            self._doorway.leave(self.transport)
            super().connection_lost(exc)

    def on_response_complete(self) -> None:
        """An answer was sent whole; the time of the next one begins."""
        super().on_response_complete()
        if not self.transport.is_closing():
            self._doorway.enter(self.transport)

    def handle_websocket_upgrade(self, event: h11.Request) -> None:
        """It is a page from now on, or is refused at once."""
        self._doorway.leave(self.transport)
        super().handle_websocket_upgrade(event)


class Handshake(asyncio.Protocol):
    """A connection during its TLS handshake, in the doorway too; then it is the protocol's that `make` makes."""

    def __init__(self, doorway: Doorway, context: ssl.SSLContext, make: Callable[[], DoorwayProtocol]) -> None:
        self._doorway, self._context, self._make = doorway, context, make
        self._task: asyncio.Task[None] | None = None

    def connection_made(self, transport: asyncio.BaseTransport) -> None:
        """Begin the handshake; what has come is left to it."""
        if isinstance(transport, asyncio.Transport):
            transport.pause_reading()
            self._doorway.enter(transport)
            self._task = asyncio.get_running_loop().create_task(self._shake_hands(transport))

    async def _shake_hands(self, transport: asyncio.Transport) -> None:
        protocol = self._make()
        try:
            secured = await asyncio.get_running_loop().start_tls(
                transport, protocol, self._context, server_side=True, ssl_handshake_timeout=ANSWERED_WITHIN_S
            )
        except OSError:  # ssl's errors are among these: it goes, as it came
            return
        finally:
            self._doorway.leave(transport)
        if secured is not None:
            protocol.connection_made(secured)
