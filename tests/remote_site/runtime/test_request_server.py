"""What everybody may ask: an operator's flood delays nobody else's answer. Real certificates, ticks one by one."""

import threading
import time
from collections.abc import Iterator
from contextlib import ExitStack
from datetime import UTC, datetime
from pathlib import Path
from typing import NamedTuple

import pytest

import tests.common.messages.golden_examples as golden
from common.clock import NS_PER_S
from common.host_clock import MonotonicClock
from common.link.channels import CLOCK, DESCRIBE, Procedure
from common.link.transport import PENDING_REQUESTS, open_link, open_router
from common.messages.base import Message
from common.messages.codec import encode
from common.messages.requests import ClockAnswer, ClockQuestion, DescribeQuestion, Description
from farhand.certificates.folder import CertificateOrder, add_router, create
from lab.stage.waiting import until
from remote_site.runtime.request_server import RequestServer
from remote_site.session.lease import LeaseServer
from tests.common.link.secured_cell import OPERATORS, PATIENCE_S, QUIET_S, dishonest, free_port, secured

CELL = golden.DESCRIPTION.cell
FLOOD_S = 5 * PENDING_REQUESTS / CLOCK.max_hz  # as fast as the cap of one session lets it: far more than may wait
QUESTIONS = {CLOCK: ClockQuestion(), DESCRIBE: DescribeQuestion()}
ASKED = list(QUESTIONS)


@pytest.fixture(scope="module")
def pki(tmp_path_factory: pytest.TempPathFactory) -> Path:
    folder = tmp_path_factory.mktemp("pki")
    create(folder, CertificateOrder(CELL, (), 30, OPERATORS), datetime.now(UTC))
    add_router(folder, CertificateOrder(CELL, (), 30), datetime.now(UTC))
    return folder


class Served(NamedTuple):
    """Where a request server can be asked; it answers only when it is polled."""

    endpoint: str
    server: RequestServer


@pytest.fixture(scope="module", params=["direct", "by a router"])
def served(pki: Path, request: pytest.FixtureRequest) -> Iterator[Served]:
    where, routed = f"tls/127.0.0.1:{free_port()}", request.param == "by a router"
    with ExitStack() as stack:
        if routed:
            router = open_router(listen=(where,), security=secured(pki, "router", CELL), operators=OPERATORS)
            stack.enter_context(router)
        ends = {"connect": (where,), "through_router": True} if routed else {"listen": (where,)}
        link = stack.enter_context(open_link(security=secured(pki, "remote", CELL), operators=OPERATORS, **ends))
        leases = LeaseServer(2 * NS_PER_S, 1)
        yield Served(where, RequestServer(link, golden.DESCRIPTION, leases, MonotonicClock(), print, OPERATORS))


@pytest.mark.slow
@pytest.mark.parametrize("who", ["operator.anna", "maintenance"])
@pytest.mark.parametrize("asked", ASKED, ids=["clock", "description"])
def test_an_operators_flood_displaces_nobody_elses_question(
    pki: Path, served: Served, who: str, asked: Procedure[Message, ClockAnswer | Description]
) -> None:
    answers: list[Message | None] = []
    key, question = asked.key_for(CELL), QUESTIONS[asked]
    with (
        open_link(connect=(served.endpoint,), security=secured(pki, who, CELL)) as link,
        dishonest(served.endpoint, pki, "operator.ben", cell=CELL, mode="client") as ben,
    ):

        def ask() -> None:
            answers.append(link.ask(asked, CELL, question, timeout_s=PATIENCE_S))

        until(lambda: list(link._session.info.links()))
        time.sleep(QUIET_S)
        asking = threading.Thread(target=ask)
        asking.start()
        time.sleep(QUIET_S)
        until_s = time.monotonic() + FLOOD_S
        while time.monotonic() < until_s:
            for flooded in (key, f"{key}/ben"):
                ben.get(flooded, lambda _reply: None, payload=encode(question), timeout=QUIET_S)
            time.sleep(1.2 / asked.max_hz)
        time.sleep(QUIET_S)
        for _ in range(len(OPERATORS) + 1):  # each has had a turn
            served.server.poll(engaged=True)
        asking.join()
    assert isinstance(answers[0], asked.reply)
