"""The console as a process: it logs its address, and ends immediately whatever a page does."""

import base64
import json
import logging
import signal
import socket
import subprocess
import sys
import time
from contextlib import ExitStack
from urllib.parse import urlsplit

import pytest
import uvicorn
from structlog.testing import capture_logs

from farhand.loopback.site_process import free_ports, options_of
from lab.measure.page.bare_console import BareConsole
from local_site.console.server import LibraryLog
from tests.present import present

READY_S = 60.0
ENDS_WITHIN_S = 10.0  # two where a machine has nothing else to do
KEY = base64.b64encode(b"sixteen bytes...").decode()
MASK = bytes(4)


def frozen_page(port: int) -> socket.socket:
    """A page that asks for a stop, and then reads nothing and answers nothing any more."""
    page = socket.create_connection(("127.0.0.1", port))
    own = f"127.0.0.1:{port}"
    asked = (
        f"GET /page HTTP/1.1\r\nHost: {own}\r\nOrigin: http://{own}\r\nConnection: Upgrade\r\nUpgrade: websocket\r\n"
    )
    page.sendall(f"{asked}Sec-WebSocket-Version: 13\r\nSec-WebSocket-Key: {KEY}\r\n\r\n".encode())
    assert page.recv(64).startswith(b"HTTP/1.1 101")
    stop = b'{"type":"ask","id":1,"action":"stop"}'
    page.sendall(bytes([0x81, 0x80 | len(stop)]) + MASK + stop)
    return page


@pytest.mark.slow
def test_it_ends_in_time_with_a_frozen_page_and_a_stop_that_nobody_answers():
    port, *nobody = free_ports(4)
    links = [f"links.{name}=tcp/127.0.0.1:{n}" for name, n in zip(("control", "video", "local"), nobody, strict=True)]
    settings = options_of([*links, f"serve.port={port}"])
    command = [sys.executable, "-m", "farhand", "console", "--log-format", "json", *settings]
    with subprocess.Popen(command, stdout=subprocess.PIPE, stderr=subprocess.PIPE, text=True) as console:
        try:
            ready = json.loads(present(console.stderr).readline())
            assert (ready["event"], ready["site"], ready["level"]) == ("ready", "console", "info")
            assert f"http://127.0.0.1:{port}/ (for this host only)" in ready["page"]
            with frozen_page(port):
                time.sleep(0.3)  # the stop is under way
                began = time.monotonic()
                console.send_signal(signal.SIGTERM)
                assert console.wait(READY_S) == 0
                assert time.monotonic() - began < ENDS_WITHIN_S
            rest = present(console.stderr).read()
        finally:
            console.kill()
    assert all(json.loads(line)["site"] == "console" for line in rest.splitlines())


def test_more_pages_than_anybody_opens_are_refused(monkeypatch):
    monkeypatch.setattr("local_site.console.server.MOST_PAGES", 2)
    with BareConsole() as console, ExitStack() as stack:
        pages = [stack.enter_context(frozen_page(present(urlsplit(console.address).port))) for _ in range(3)]
        pages[-1].settimeout(ENDS_WITHIN_S)
        told = b""
        while b"2 pages are open" not in told:
            told += pages[-1].recv(4096) or pytest.fail("it was closed without a word")


@pytest.mark.parametrize(("ending", "told"), [(False, ["server"]), (True, [])])
def test_what_the_server_library_says_stands_in_our_log(ending, told):
    with capture_logs() as lines:
        server = uvicorn.Server(uvicorn.Config("none"))
        server.should_exit = ending
        log = LibraryLog(server)
        log.emit(logging.LogRecord("uvicorn.error", logging.ERROR, "", 0, "it broke", None, None))
    assert [line["event"] for line in lines] == told
