"""What the measurements of the page rest on: a link that carries no more than it should, and a clock that is read."""

import socket
import threading
import time

import numpy as np

from bench.narrow_link import NarrowLink
from bench.painted_clock import PageClock, ages_ms
from common.clock import NS_PER_MS
from farhand.loopback import free_ports
from remote_site.video.clock_strip import draw_clock

MBIT_S = 4.0
SENT = bytes(range(256)) * 500
EXPOSED_MS = 4_000_000


def test_a_narrow_link_hands_back_everything_and_no_faster_than_it_may():
    port, to_port = free_ports(2)
    with (
        socket.create_server(("127.0.0.1", to_port)) as far,
        NarrowLink(port, to_port, MBIT_S) as link,
        socket.create_connection(("127.0.0.1", port)) as near,
    ):
        near.sendall(b"give")
        sender, _ = far.accept()
        assert sender.recv(4) == b"give"
        began = time.monotonic()
        threading.Thread(target=lambda: (sender.sendall(SENT), sender.close()), daemon=True).start()
        heard = b""
        while part := near.recv(65536):
            heard += part
        took_s = time.monotonic() - began
    assert heard == SENT
    assert link.carried_bytes == len(SENT)
    assert took_s > 0.9 * 8e-6 * len(SENT) / MBIT_S


class Page:
    """Has painted two pictures, of which one cannot be read."""

    def evaluate(self, _script: str) -> list[list[object]]:
        image = np.zeros((240, 44 * 4, 3), np.uint8)
        draw_clock(image, EXPOSED_MS * NS_PER_MS)
        cells = "".join("1" if level > 128 else "0" for level in image[2, 2::4, 1])
        return [["side", 130.5, cells], ["side", 140.5, cells.replace("1", "?", 1)]]


def test_the_age_of_a_painted_picture_is_read_from_the_clock_in_it():
    assert ages_ms(Page(), PageClock(EXPOSED_MS - 100.0, 0.5)) == {"side": [30.5]}
