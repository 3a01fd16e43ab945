"""The narrow link of the benches: carries what goes through whole, at its rate, and leaves nothing open."""

import socket
import threading
import time

import pytest

from farhand.loopback.site_process import free_ports
from lab.measure.page.narrow_link import NarrowLink

SIZE = 125_000  # a megabit


@pytest.mark.filterwarnings("error")
def test_what_comes_back_is_whole_and_takes_the_time_that_the_link_needs() -> None:
    near, far = free_ports(2)
    told = bytes(range(250)) * (SIZE // 250)
    with socket.create_server(("127.0.0.1", far)) as server, NarrowLink(near, far, 4.0) as link:
        threading.Thread(target=lambda: _answer(server, told), daemon=True).start()
        with socket.create_connection(("127.0.0.1", near)) as viewer:
            viewer.settimeout(10)
            viewer.sendall(b"go")
            begun, heard = time.monotonic(), b""
            while len(heard) < SIZE:
                heard += viewer.recv(65536)
        assert heard == told
        assert link.carried_bytes == SIZE
        assert time.monotonic() - begun > 0.9 * 8e-6 * SIZE / 4.0


def _answer(server: socket.socket, told: bytes) -> None:
    connection, _ = server.accept()
    with connection:
        assert connection.recv(16) == b"go"
        connection.sendall(told)
        connection.recv(16)


def test_where_nobody_listens_the_connection_ends() -> None:
    near, far = free_ports(2)
    with NarrowLink(near, far, 4.0), socket.create_connection(("127.0.0.1", near)) as viewer:
        viewer.settimeout(10)
        assert viewer.recv(16) == b""
