"""A far host that vanishes while its connection is closed holds up nobody else."""

import multiprocessing
import subprocess
import sys
import threading
import time
from collections.abc import Iterator
from contextlib import contextmanager
from itertools import pairwise
from multiprocessing.connection import Connection
from pathlib import Path

import pytest

from common.link.channels import STATE
from common.link.transport import Link, open_link
from lab.stage.network.namespaces import HERE, LinkedHosts, why_not
from lab.stage.waiting import until
from tests.common.link.secured_cell import ANNA, CELL, OPERATORS, ROBOT_STATE, free_port, secured

DELAY_MS, CUT_AFTER_S = 100.0, 0.2  # from what it was closed for to the end of the link: what closes it is under way
WATCHED_S, EACH_S = 2.5, 0.02
LONGEST_GAP_S = 1.0  # it was ten seconds
# By TLS, with a certificate; then what Zenoh closes a connection for.
VANISHING = """
import socket, ssl, sys, time
host, port, ca, certificate, key = sys.argv[1:]
context = ssl.create_default_context(cafile=ca)
context.load_cert_chain(certificate, key)
connection = socket.create_connection((host, int(port)))
connection.setsockopt(socket.IPPROTO_TCP, socket.TCP_NODELAY, 1)
connection = context.wrap_socket(connection, server_hostname="localhost")
connection.sendall(bytes(8))
print("sent", flush=True)
time.sleep(60)
"""


@contextmanager
def states_watched(link: Link, near: Link) -> Iterator[list[float]]:
    """When the states came that the link sends meanwhile, s."""
    states, came, stop = link.publisher(STATE, CELL), near.latest(STATE, CELL), threading.Event()
    arrivals: list[float] = []

    def send() -> None:
        while not stop.wait(EACH_S):
            states.put(ROBOT_STATE)

    def receive() -> None:
        while not stop.wait(EACH_S / 10):
            if came.take() is not None:
                arrivals.append(time.monotonic())

    threads = [threading.Thread(target=act) for act in (send, receive)]
    for thread in threads:
        thread.start()
    yield arrivals
    stop.set()
    for thread in threads:
        thread.join()


def play(pki: Path, answer: Connection) -> None:
    """Close a far connection and cut the link to it; tell the longest gap between the states of a near one, s."""
    hosts, port = LinkedHosts(), free_port()
    hosts.enter()
    operator, endpoint = secured(pki, f"operator.{ANNA}"), f"quic/localhost:{port}"
    with (
        open_link(listen=(endpoint,), security=secured(pki, "remote"), operators=OPERATORS) as link,
        open_link(connect=(endpoint,), security=operator) as near,
        states_watched(link, near) as arrivals,
    ):
        until(lambda: arrivals)
        hosts.impair(delay_ms=DELAY_MS)
        words = (HERE, str(port), operator.tls.ca, operator.tls.certificate, operator.tls.key)
        command = [*hosts.beyond, sys.executable, "-c", VANISHING, *words]
        with subprocess.Popen(command, stdout=subprocess.PIPE, text=True) as far:
            assert far.stdout is not None
            assert far.stdout.readline() == "sent\n"
            time.sleep(CUT_AFTER_S)
            hosts.impair(cut=True)
            time.sleep(WATCHED_S)
            far.kill()
    answer.send(max(b - a for a, b in pairwise([*arrivals, time.monotonic()])))
    hosts.close()


def test_one_that_vanishes_while_it_is_closed_holds_up_no_other(pki: Path) -> None:
    if missing := why_not():
        pytest.skip(f"no two hosts on this machine: {missing}")
    here, there = multiprocessing.Pipe()
    player = multiprocessing.get_context("spawn").Process(target=play, args=(pki, there))
    player.start()
    there.close()
    assert here.poll(60.0)
    assert here.recv() < LONGEST_GAP_S
    player.join()
