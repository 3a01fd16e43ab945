"""Half-open connections keep nobody from the page: they are few, and none stays for long."""

import asyncio
import socket
import ssl
import threading
import time
from collections.abc import Iterator
from contextlib import ExitStack, contextmanager
from datetime import UTC, datetime
from pathlib import Path

import pytest

from farhand.certificates.folder import CertificateOrder, create
from lab.stage.waiting import until
from local_site.console.config import ServeConfig
from local_site.console.doorway import MOST_AT_ONCE, Doorway
from local_site.console.server import bind, make_server

HALF_OPEN = 200
SOON_S = 1.0
PATIENCE_S = 5.0
TOKEN = "0123456789abcdef"  # noqa: S105  # opens nothing but these tests


@contextmanager
def served(serve: ServeConfig) -> Iterator[tuple[str, int]]:
    """The page's server, without a cell behind it."""
    with bind(serve) as listening:
        port = listening.getsockname()[1]
        server = make_server(None, serve, port)  # type: ignore[arg-type]  # nobody comes as far as the hub
        thread = threading.Thread(target=lambda: asyncio.run(server.serve(sockets=[listening])))
        thread.start()
        try:
            yield "127.0.0.1", port
        finally:
            server.should_exit = True
            thread.join()


def half_open(address: tuple[str, int], said: bytes, stack: ExitStack) -> list[socket.socket]:
    """Connections that say this much, and no more."""
    made = []
    for _ in range(HALF_OPEN):
        connection = stack.enter_context(socket.create_connection(address))
        connection.sendall(said)
        connection.setblocking(False)
        made.append(connection)
    return made


def answer(address: tuple[str, int], context: ssl.SSLContext | None = None) -> bytes:
    """The first line of the page's answer, in good time."""
    began = time.monotonic()
    with ExitStack() as stack:
        connection = stack.enter_context(socket.create_connection(address, SOON_S))
        if context is not None:
            connection = stack.enter_context(context.wrap_socket(connection, server_hostname=address[0]))
        connection.sendall(f"GET / HTTP/1.1\r\nHost: {address[0]}:{address[1]}\r\n\r\n".encode())
        line = connection.recv(4096).partition(b"\r\n")[0]
    assert time.monotonic() - began < SOON_S
    return line


def still_open(connections: list[socket.socket]) -> int:
    """How many the server has not closed."""
    return sum(map(_is_open, connections))


def _is_open(connection: socket.socket) -> bool:
    try:
        while connection.recv(65536):
            pass
    except BlockingIOError:
        return True
    except OSError:
        return False
    return False


@pytest.mark.slow
@pytest.mark.parametrize("said", [b"", b"GET / HTTP/1.1\r\nHost: 127", b"GET / HTTP/1.1\r\nHost: x\r\n\r\nGET"])
def test_the_page_answers_beside_half_open_requests_and_few_of_them_stay(said: bytes) -> None:
    with served(ServeConfig(port=0)) as address, ExitStack() as stack:
        connections = half_open(address, said, stack)
        assert answer(address) == b"HTTP/1.1 200 OK"
        _few_stay(connections)


@pytest.mark.slow
def test_the_page_answers_beside_half_open_handshakes(tmp_path: Path) -> None:
    create(tmp_path, CertificateOrder("lab", (), 30), datetime.now(UTC))
    pair = tmp_path / "lab/remote"
    serve = ServeConfig(port=0, token=TOKEN, certificate=f"{pair}.pem", key=f"{pair}.key")
    context = ssl.create_default_context(cafile=str(tmp_path / "ca.pem"))
    with served(serve) as address, ExitStack() as stack:
        connections = half_open(address, b"\x16\x03\x01", stack)
        assert answer(address, context) == b"HTTP/1.1 401 Unauthorized"
        _few_stay(connections)


def _few_stay(connections: list[socket.socket]) -> None:
    until(lambda: still_open(connections) <= MOST_AT_ONCE, "the others to be closed", PATIENCE_S)


class _Connection(asyncio.Transport):
    """A transport that is only ever aborted."""

    def __init__(self, host: str) -> None:
        super().__init__()
        self.host, self.aborted = host, False

    def get_extra_info(self, _name: str, _default: object = None) -> tuple[str, int]:
        return self.host, 1

    def abort(self) -> None:
        self.aborted = True


FLOODS = {
    "one address": ["192.0.2.2"] * 5,
    "one host's network of IPv6": [f"2001:db8:0:7::{k}" for k in range(5)],
    "one link's": [f"fe80::{k}%eth0" for k in range(5)],
}


@pytest.mark.parametrize("hosts", FLOODS.values(), ids=FLOODS)
@pytest.mark.parametrize("own", ["192.0.2.1", "2001:db8:0:8::1"])
def test_who_comes_displaces_the_oldest_of_the_address_with_the_most(own: str, hosts: list[str]) -> None:
    async def play() -> list[bool]:
        doorway = Doorway(most=4)
        operator, *flood = _Connection(own), *map(_Connection, hosts)
        for connection in (operator, *flood):
            doorway.enter(connection)
        assert len(doorway) == 4
        return [connection.aborted for connection in (operator, *flood)]

    assert asyncio.run(play()) == [False, True, True, False, False, False]


def test_none_stays_without_an_answer_and_one_that_left_does() -> None:
    async def play() -> tuple[bool, bool]:
        doorway = Doorway(patience_s=0.01)
        slow, page = _Connection("192.0.2.1"), _Connection("192.0.2.1")
        doorway.enter(slow)
        doorway.enter(page)
        doorway.leave(page)
        await asyncio.sleep(0.05)
        return slow.aborted, page.aborted

    assert asyncio.run(play()) == (True, False)
