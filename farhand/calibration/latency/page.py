"""The page that shows the pattern: served on this host alone, it reads this host's clock and reports what it drew."""

import json
import queue
import threading
from http import HTTPStatus
from http.server import BaseHTTPRequestHandler, ThreadingHTTPServer
from pathlib import Path
from typing import Protocol, Self

import msgspec

from common.clock import Clock
from common.errors import ConfigError
from common.link.port_holders import why_not_bound
from farhand.calibration.latency.pattern import HOLD_MS, PageReport, sequence

HOST = "127.0.0.1"
PAGE = Path(__file__).with_name("page.html")
REQUEST_S = 10.0  # a request that takes longer is no page's: its thread ends
MAX_BYTES = 4_000_000  # half a minute at 240 Hz takes a quarter of it


class PatternScreen(Protocol):
    """A screen that shows the pattern once a person starts it."""

    def wait(self, timeout_s: float) -> PageReport | None:
        """Wait for the report of what was drawn; None after the time-out."""


class PatternPage:
    """Serves the page at `url`, of which `token` is a part that no other page can guess.

    ConfigError when nothing can be served at the port; 0 takes a free one.
    """

    def __init__(self, clock: Clock, token: str, port: int = 0) -> None:
        self._reports: queue.Queue[PageReport] = queue.Queue()
        handler = _handler(clock, f"/{token}/", self._reports)
        try:
            self._server = ThreadingHTTPServer((HOST, port), handler)
        except OSError as error:
            raise ConfigError(f"--port {port}: {why_not_bound(error, port)}, or leave it out") from error
        self.url = f"http://{HOST}:{self._server.server_port}/{token}/"
        self._thread = threading.Thread(target=self._server.serve_forever, daemon=True, name="pattern page")
        self._thread.start()

    def wait(self, timeout_s: float) -> PageReport | None:
        """The report of the page when it has shown the pattern; None after the time-out."""
        try:
            return self._reports.get(timeout=timeout_s)
        except queue.Empty:
            return None

    def close(self) -> None:
        """Serve no more."""
        self._server.shutdown()
        self._server.server_close()
        self._thread.join()

    def __enter__(self) -> Self:
        return self

    def __exit__(self, *_: object) -> None:
        self.close()


def page_text() -> str:
    """The page, with the pattern in it."""
    text = PAGE.read_text(encoding="utf-8")
    return text.replace("__LEVELS__", json.dumps(sequence())).replace("__HOLD_MS__", str(HOLD_MS))


def _handler(clock: Clock, root: str, reports: queue.Queue[PageReport]) -> type[BaseHTTPRequestHandler]:
    class Handler(BaseHTTPRequestHandler):
        """One request: the page, the clock, or the report."""

        protocol_version = "HTTP/1.1"
        timeout = REQUEST_S

        def do_GET(self) -> None:
            if self.path == f"{root}clock":
                self._answer(HTTPStatus.OK, str(clock.now_ns()))  # as text: numbers of a page have 53 bits
            elif self.path == root:
                self._answer(HTTPStatus.OK, page_text(), "text/html; charset=utf-8")
            else:
                self._answer(HTTPStatus.NOT_FOUND, "not found")

        def do_POST(self) -> None:
            length = self.headers.get("Content-Length", "")
            if self.path != f"{root}report" or not length.isdecimal() or int(length) > MAX_BYTES:
                self.close_connection = True
                self._answer(HTTPStatus.NOT_FOUND, "not found")
                return
            try:
                report = msgspec.json.decode(self.rfile.read(int(length)), type=PageReport, strict=False)
            except msgspec.MsgspecError as wrong:
                self._answer(HTTPStatus.BAD_REQUEST, f"not a report: {wrong}")
                return
            self._answer(HTTPStatus.OK, "taken")
            reports.put(report)

        def _answer(self, status: HTTPStatus, text: str, kind: str = "text/plain; charset=utf-8") -> None:
            content = text.encode()
            self.send_response(status)
            self.send_header("Content-Type", kind)
            self.send_header("Content-Length", str(len(content)))
            self.send_header("Cache-Control", "no-store")
            self.end_headers()
            self.wfile.write(content)

        def log_message(self, format: str, *args: object) -> None:  # noqa: A002  # the base class's name
            """The terminal is for the measurement."""

    return Handler
