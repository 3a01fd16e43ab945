"""A site sees what waits in its own host on the way to a neighbour, in the connection that takes most."""

import socket
from collections.abc import Iterator
from contextlib import ExitStack
from pathlib import Path
from types import SimpleNamespace
from typing import cast

import pytest
import zenoh

from common.link import send_queues
from common.link.send_queues import SendQueues
from common.link.transport import open_link
from lab.stage.waiting import until
from tests.common.link.secured_cell import ANNA, BEN, CELL, running, secured
from tests.common.link.test_deaf_neighbour import deaf

ANNAS, BENS = f"operator.{CELL}.{ANNA}", f"operator.{CELL}.{BEN}"
SMALL_BYTES = 4096
CHUNK = bytes(20_000)


class Neighbour:
    """One of a session's connections, as Zenoh tells of it; it reads when it is asked to."""

    def __init__(self, stack: ExitStack, host: str, name: str | None) -> None:
        family = socket.AF_INET6 if ":" in host else socket.AF_INET
        listener = stack.enter_context(socket.socket(family))
        listener.setsockopt(socket.SOL_SOCKET, socket.SO_RCVBUF, SMALL_BYTES)
        listener.bind((host, 0))
        listener.listen()
        self.ours = stack.enter_context(socket.create_connection(listener.getsockname()[:2]))
        self._theirs = stack.enter_context(listener.accept()[0])
        self.ours.setblocking(False)
        ours, theirs = (
            f"tls/[{host}]:{port}" if ":" in host else f"tls/{host}:{port}"
            for port in (self.ours.getsockname()[1], self.ours.getpeername()[1])
        )
        self.link = SimpleNamespace(src=ours, dst=f"{theirs}?rel=1", auth_identifier=name, is_streamed=True)

    def put(self) -> None:
        assert self.ours.send(CHUNK) == len(CHUNK)

    def take(self, chunks: int) -> None:
        left = chunks * len(CHUNK)
        while left:
            left -= len(self._theirs.recv(left))


@pytest.fixture
def stack(monkeypatch: pytest.MonkeyPatch) -> Iterator[ExitStack]:
    monkeypatch.setattr(send_queues, "LOOK_NS", 0)  # each time, not twice a second
    with ExitStack() as stack:
        yield stack


def session(*neighbours: Neighbour) -> zenoh.Session:
    links = [each.link for each in neighbours]
    return cast("zenoh.Session", SimpleNamespace(info=SimpleNamespace(links=lambda: links)))


@pytest.mark.parametrize("host", ["127.0.0.1", "::1"])
def test_what_a_neighbour_does_not_take_waits_until_it_does(stack: ExitStack, host: str) -> None:
    anna = Neighbour(stack, host, ANNAS)
    queues = SendQueues(session(anna))
    assert queues.unsent_bytes(ANNAS) == 0
    for _ in range(5):
        anna.put()
    waiting = queues.unsent_bytes(ANNAS)
    assert 3 * len(CHUNK) < waiting < 5 * len(CHUNK)
    anna.take(5)
    until(lambda: queues.unsent_bytes(ANNAS) == 0)


def test_of_a_neighbours_connections_the_one_that_takes_most_counts(stack: ExitStack) -> None:
    pictures, idle, hung = (Neighbour(stack, "127.0.0.1", ANNAS) for _ in range(3))
    queues = SendQueues(session(idle, pictures, hung))
    for _ in range(5):
        hung.put()
    queues.unsent_bytes(ANNAS)
    for _ in range(5):
        pictures.put()
        pictures.take(1)
    until(lambda: queues.unsent_bytes(ANNAS) == 0)


def test_one_that_takes_most_still_counts_while_it_takes_nothing(stack: ExitStack) -> None:
    idle, pictures = Neighbour(stack, "127.0.0.1", ANNAS), Neighbour(stack, "127.0.0.1", ANNAS)
    queues = SendQueues(session(idle, pictures))
    for _ in range(5):
        pictures.put()
        pictures.take(1)
    queues.unsent_bytes(ANNAS)
    for _ in range(5):
        pictures.put()
    for _ in range(3):
        idle.ours.send(b"alive")
        assert queues.unsent_bytes(ANNAS) > 0


def test_another_neighbour_that_takes_nothing_is_not_ours(stack: ExitStack) -> None:
    anna, ben = Neighbour(stack, "127.0.0.1", ANNAS), Neighbour(stack, "127.0.0.1", BENS)
    queues = SendQueues(session(ben, anna))
    for _ in range(5):
        ben.put()
    assert queues.unsent_bytes(ANNAS) == 0
    assert queues.unsent_bytes(BENS) > 0


def test_through_a_router_its_connection_counts_and_none_is_nothing(stack: ExitStack) -> None:
    router = Neighbour(stack, "127.0.0.1", f"router.{CELL}")
    for _ in range(5):
        router.put()
    assert SendQueues(session(router)).unsent_bytes(ANNAS) > 0
    assert SendQueues(session()).unsent_bytes(ANNAS) == 0


def test_a_descriptor_that_is_another_files_now_tells_nothing(
    stack: ExitStack, monkeypatch: pytest.MonkeyPatch
) -> None:
    anna = Neighbour(stack, "127.0.0.1", ANNAS)
    queues = SendQueues(session(anna))
    for _ in range(5):
        anna.put()
    assert queues.unsent_bytes(ANNAS) > 0
    monkeypatch.setattr(send_queues, "LOOK_NS", 10**15)
    descriptor = anna.ours.fileno()
    anna.ours.close()
    assert queues.unsent_bytes(ANNAS) == 0
    with socket.socket() as other:
        assert other.fileno() == descriptor
        assert queues.unsent_bytes(ANNAS) == 0


@pytest.mark.slow
def test_of_a_real_link_too(pki: Path) -> None:
    anna = secured(pki, f"operator.{ANNA}")
    with running(secured(pki, "remote")) as cell, open_link(connect=(cell.endpoint,), security=anna):
        queues = cell.link.send_queues()
        with deaf(cell, pki, sessions=1, every_s=0.05):
            until(lambda: queues.unsent_bytes(BENS) > 0)
            until(lambda: cell.link.send_queues().unsent_bytes(ANNAS) == 0)
