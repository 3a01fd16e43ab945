"""A cell's link with real certificates, and neighbours that do not keep to the rules."""

import contextlib
import itertools
import json
import os
import socket
import threading
import time
from collections import Counter
from collections.abc import Iterator
from contextlib import contextmanager
from pathlib import Path

import msgspec
import zenoh

import tests.common.messages.golden_examples as golden
from common.link.channels import ANY, CLOCK, ENGAGEMENT, HAND, MAINTENANCE, MAINTENANCE_STOP, OWN_CLOCK, STATE, STOP
from common.link.config import LinkSecurity, TlsConfig
from common.link.engagement_client import ask_engagement
from common.link.request_client import RequestClient
from common.link.transport import Link, open_link
from common.messages.codec import encode
from common.messages.hand import HandArm
from common.messages.requests import ClockAnswer, EngagementAction, EngagementRequest, Reply, StopRequest
from farhand.certificates.issuing import Issued

HAND_SAMPLE, ROBOT_STATE = golden.HAND, golden.STATE
CELL = "lab"
ANNA, BEN = "anna", "ben"
OPERATORS = ANNA, BEN
PATIENCE_S = 9.0
QUIET_S = 0.25  # enough for what is passed immediately to arrive


def keep(stem: Path, issued: Issued) -> None:
    stem.with_suffix(".pem").write_bytes(issued.certificate_pem)
    stem.with_suffix(".key").write_bytes(issued.key_pem)


def authority(folder: Path, who: str | None) -> str:
    """The authority that this certificate is of: viewers, and the listener for them, have one of their own."""
    return str(folder / ("viewers-ca.pem" if (who or "").startswith("viewer") else "ca.pem"))


def secured(folder: Path, who: str, cell: str = CELL) -> LinkSecurity:
    pair = folder / cell / who
    tls = TlsConfig(ca=authority(folder, who), certificate=f"{pair}.pem", key=f"{pair}.key")
    return LinkSecurity(tls=tls)


# Below the range that outgoing connections get their ports from, and elsewhere in each process that runs tests.
_PORTS = itertools.count(20_000 + 97 * os.getpid() % 10_000)


def free_port() -> int:
    for port in _PORTS:
        with socket.socket() as probe, contextlib.suppress(OSError):
            probe.bind(("127.0.0.1", port))
            return port
    raise AssertionError("no port is free")


_SEQS = itertools.count()


def another_sample() -> HandArm:
    """A hand sample that is no copy of one before."""
    return msgspec.structs.replace(HAND_SAMPLE, seq=next(_SEQS))


class Cell:
    """A remote site's link: publishes its state, counts what reaches it, answers every request."""

    def __init__(self, endpoint: str, link: Link) -> None:
        self.endpoint, self.link = endpoint, link
        self.hands, self.asked = 0, 0
        self.heard: Counter[str] = Counter()  # by the name in the key
        self._stop = threading.Event()
        self._thread = threading.Thread(target=self._run)
        self._thread.start()

    def _run(self) -> None:
        state = self.link.publisher(STATE, CELL)
        hands = [self.link.latest(HAND, CELL, operator=name) for name in OPERATORS]
        servers = [self.link.serve(ENGAGEMENT, CELL, print, operator=name) for name in OPERATORS]
        servers.append(self.link.serve(MAINTENANCE, CELL, print))
        stops = [self.link.answer(STOP, CELL, print, operator=name) for name in OPERATORS]
        stops.append(self.link.answer(MAINTENANCE_STOP, CELL, print))
        clocks = [self.link.answer(OWN_CLOCK, CELL, print, operator=name) for name in OPERATORS]
        clocks.append(self.link.answer(CLOCK, CELL, print))
        while not self._stop.wait(0.005):
            state.put(ROBOT_STATE)
            for hand in hands:
                named = hand.take_named()
                if named is not None:
                    self.hands += 1
                    self.heard[named[0]] += 1
            for clock in clocks:
                clock.poll(lambda _: ClockAnswer(received_ns=1, answered_ns=2))
            for asked in (*(server.take(time.monotonic_ns()) for server in servers), *(stop.take() for stop in stops)):
                if asked is not None:
                    self.asked += 1
                    self.heard[asked.operator] += 1
                    asked.reply(Reply(id=0, done=True, code="ok", reason=""))

    def close(self) -> None:
        self._stop.set()
        self._thread.join()


@contextmanager
def running(
    security: LinkSecurity, protocol: str = "tls", port: int | None = None, operators: tuple[str, ...] = OPERATORS
) -> Iterator[Cell]:
    endpoint = f"{protocol}/127.0.0.1:{port or free_port()}"
    with open_link(listen=(endpoint,), security=security, operators=operators) as link:
        cell = Cell(endpoint, link)
        try:
            yield cell
        finally:
            cell.close()


@contextmanager
def dishonest(
    endpoint: str,
    folder: Path,
    who: str | None,
    *,
    listen: bool = False,
    cell: str = CELL,
    mode: str = "peer",
    receive_buffer_bytes: int | None = None,
) -> Iterator[zenoh.Session]:
    """A session that checks nothing itself and has no access control of its own."""
    tls = {"root_ca_certificate": authority(folder, who), "verify_name_on_connect": False}
    tls |= {"so_rcvbuf": receive_buffer_bytes}
    if who is not None:
        pair = folder / cell / who
        for end in ("listen", "connect"):
            tls |= {f"{end}_certificate": f"{pair}.pem", f"{end}_private_key": f"{pair}.key"}
    config, locator = zenoh.Config(), f"{endpoint}?mixed_rel=1" if endpoint.startswith("quic/") else endpoint
    settings = {
        "mode": mode,
        "listen/endpoints": [locator] if listen else [],
        "connect/endpoints": [] if listen else [locator],
        "connect/exit_on_failure": False,
        "scouting/multicast/enabled": False,
        "transport/link/tls": tls | {"enable_mtls": who is not None},
    }
    for key, value in settings.items():
        config.insert_json5(key, json.dumps(value))
    with zenoh.open(config) as session:
        yield session


def request(action: EngagementAction = EngagementAction.ENGAGE) -> EngagementRequest:
    deadline_ns = time.monotonic_ns() + 5_000_000_000
    return EngagementRequest(id=1, deadline_ns=deadline_ns, action=action)


def reply_to(link: Link, action: EngagementAction, *, maintenance: bool = False) -> Reply:
    """The cell's reply to an honest request of anna's, or of maintenance."""
    client = RequestClient(link, CELL, operator=ANNA, patience_ns=round(PATIENCE_S * 1e9))
    return ask_engagement(client, action, maintenance=maintenance)


def commands_arrive(session: zenoh.Session, cell: Cell) -> bool:
    """Whether anything that moves or stops the arm reaches the cell from there, under any name."""
    return bool(names_heard(session, cell))


def names_heard(session: zenoh.Session, cell: Cell) -> set[str]:
    """Try everything that moves or stops the arm, in every name: the names under which it reaches the cell."""
    before = Counter(cell.heard)
    hands = [HAND.key_for(CELL, operator=name) for name in OPERATORS]
    for key in (*hands, HAND.key_for(CELL), f"farhand/{CELL}/*", f"farhand/{CELL}/**"):
        session.put(key, encode(another_sample()))
        session.delete(key)
    anything = f"farhand/{CELL}/rpc/**"
    engagements = [ENGAGEMENT.key_for(CELL, operator=name) for name in (*OPERATORS, ANY)]
    for key in (*engagements, MAINTENANCE.key_for(CELL), anything):
        list(session.get(key, payload=encode(request()), timeout=QUIET_S / 2))
    stops = [STOP.key_for(CELL, operator=name) for name in (*OPERATORS, ANY)]
    for key in (*stops, MAINTENANCE_STOP.key_for(CELL), anything):
        list(session.get(key, payload=encode(StopRequest()), timeout=QUIET_S / 2))
    time.sleep(QUIET_S)
    return set(cell.heard - before)
