"""Bytes that wait in this host's TCP for a neighbour: what is put now is sent only after them."""

import errno
import os
import socket
import struct
import time
from collections.abc import Callable, Iterator
from typing import NamedTuple, TypeVar

import zenoh

from common.clock import NS_PER_S

LOOK_NS = NS_PER_S // 2  # between two searches for the connections
INFO_BYTES = 192
BYTES_ACKED, NOTSENT_BYTES = struct.Struct("=120xQ"), struct.Struct("=144xI")  # of tcp_info (linux/tcp.h)

T = TypeVar("T")


class Ends(NamedTuple):
    """Both addresses of a connection, as Zenoh writes them without the protocol: ours, the neighbour's."""

    ours: str
    theirs: str


class OwnSocket(NamedTuple):
    """A descriptor of this process, and the number that no other socket has while this one lives."""

    descriptor: int
    inode: int


class Taken(NamedTuple):
    """Bytes that a neighbour has acknowledged on a connection: in all, and lately, what is older counting less."""

    bytes: int = 0
    lately: float = 0.0

    def now(self, total: int) -> "Taken":
        """After another look."""
        return Taken(total, total - self.bytes + self.lately / 2)


class SendQueues:
    """The send queues of a session's TCP and TLS connections; those of QUIC cannot be known."""

    def __init__(self, session: zenoh.Session) -> None:
        self._session = session
        self._taken: dict[OwnSocket, Taken] = {}
        self._busiest: OwnSocket | None = None
        self._looked_ns = -LOOK_NS

    def unsent_bytes(self, common_name: str) -> int:
        """Bytes that have not been sent once, in the connection of a neighbour that takes most; 0 where none is known.

        The neighbour is who shows a certificate of this name; where nobody does, as through a router, it is any.
        """
        now_ns = time.monotonic_ns()
        if now_ns - self._looked_ns >= LOOK_NS:
            self._looked_ns = now_ns
            self._look(common_name)
        info = _info_of(self._busiest) if self._busiest is not None else None
        return NOTSENT_BYTES.unpack_from(info)[0] if info is not None else 0

    def _look(self, common_name: str) -> None:
        """Find which connection has taken the most lately: a neighbour may have some that are idle."""
        links = [link for link in self._session.info.links() if link.is_streamed]
        own = [link for link in links if link.auth_identifier == common_name] or links
        wanted, before = {_ends(link) for link in own}, self._taken
        infos = {found: _info_of(found) for ends, found in _own_connections() if ends in wanted}
        self._taken = {
            found: before.get(found, Taken()).now(BYTES_ACKED.unpack_from(info)[0])
            for found, info in infos.items()
            if info is not None
        }
        self._busiest = max(self._taken, key=lambda one: self._taken[one].lately, default=None)


def _ends(link: zenoh.Link) -> Ends:
    return Ends(*(locator.partition("/")[2].partition("?")[0] for locator in (link.src, link.dst)))


def _info_of(own: OwnSocket) -> bytes | None:
    """Read what the kernel knows of a connection; None where it is closed: another file may have its descriptor now."""
    try:
        if os.fstat(own.descriptor).st_ino != own.inode:
            return None
        info = _borrow(own.descriptor, lambda it: it.getsockopt(socket.IPPROTO_TCP, socket.TCP_INFO, INFO_BYTES))
    except OSError:
        return None
    return info if len(info) >= NOTSENT_BYTES.size else None


def _own_connections() -> Iterator[tuple[Ends, OwnSocket]]:
    """Every TCP connection of this process."""
    for descriptor in map(int, os.listdir("/proc/self/fd")):
        try:
            yield _borrow(descriptor, _ends_of), OwnSocket(descriptor, os.fstat(descriptor).st_ino)
        except OSError:
            continue  # no socket, not connected, or closed meanwhile


def _borrow(descriptor: int, read: Callable[[socket.socket], T]) -> T:
    """Read from a socket that stays another's; OSError where it is none."""
    borrowed = socket.socket(fileno=descriptor)
    try:
        return read(borrowed)
    finally:
        borrowed.detach()


def _ends_of(connected: socket.socket) -> Ends:
    if connected.type is not socket.SOCK_STREAM:
        raise OSError(errno.EPROTOTYPE, "no stream")
    return Ends(_written(connected.getsockname()), _written(connected.getpeername()))


def _written(address: object) -> str:
    """As Zenoh writes an address; OSError for one without host and port."""
    match address:
        case (str(host), int(port), *_):
            return f"[{host}]:{port}" if ":" in host else f"{host}:{port}"
    raise OSError(errno.EAFNOSUPPORT, "no address of IP")
