"""Links with real certificates: each operator passes under the own name only, and nobody who is not on the list."""

import time
from collections.abc import Iterator
from contextlib import ExitStack, contextmanager
from pathlib import Path

import pytest
import zenoh

from common.errors import RefusedError
from common.link.channels import CLOCK, HAND, INTENT, LEASE, OPERATE, OWN_CLOCK, STATE
from common.link.endpoints import SECURED
from common.link.transport import open_link, open_router
from common.messages.codec import encode
from common.messages.requests import ClockQuestion, EngagementAction
from lab.stage.waiting import until
from tests.common.link.secured_cell import (
    ANNA,
    BEN,
    CELL,
    OPERATORS,
    QUIET_S,
    Cell,
    another_sample,
    dishonest,
    free_port,
    names_heard,
    reply_to,
    request,
    running,
    secured,
)


@pytest.fixture(scope="module", params=SECURED)
def routed(pki: Path, request: pytest.FixtureRequest) -> Iterator[Cell]:
    """A cell behind a router."""
    with behind_router(pki, request.param, OPERATORS) as cell:
        yield cell


@pytest.fixture(scope="module", params=[(place, protocol) for place in ("direct", "routed") for protocol in SECURED])
def anywhere(pki: Path, request: pytest.FixtureRequest) -> Iterator[Cell]:
    """A cell that is reached directly, or by a router."""
    place, protocol = request.param
    with (
        behind_router(pki, protocol, OPERATORS) if place == "routed" else running(secured(pki, "remote"), protocol)
    ) as cell:
        yield cell


@contextmanager
def behind_router(pki: Path, protocol: str, listed: tuple[str, ...]) -> Iterator[Cell]:
    """A cell that knows both operators, behind a router that lists these."""
    endpoint = f"{protocol}/127.0.0.1:{free_port()}"
    with ExitStack() as stack:
        security = secured(pki, "router")
        stack.enter_context(open_router(listen=(endpoint,), security=security, operators=listed))
        site = open_link(connect=(endpoint,), security=secured(pki, "remote"), operators=OPERATORS, through_router=True)
        cell = Cell(endpoint, stack.enter_context(site))
        stack.callback(cell.close)
        yield cell


@pytest.mark.slow
@pytest.mark.parametrize("mode", ["peer", "client"])
@pytest.mark.parametrize("name", OPERATORS)
def test_an_operator_is_heard_under_the_own_name_and_no_other(pki: Path, anywhere: Cell, name: str, mode: str) -> None:
    with dishonest(anywhere.endpoint, pki, f"operator.{name}", mode=mode) as session:
        key, before = HAND.key_for(CELL, operator=name), anywhere.heard[name]
        until(lambda: session.put(key, encode(another_sample())) or anywhere.heard[name] > before)
        heard = set[str]()
        until(lambda: heard.update(names_heard(session, anywhere)) or heard)
        assert heard == {name}


@pytest.mark.slow
def test_an_operator_who_listens_to_everything_hears_no_other(pki: Path, anywhere: Cell) -> None:
    cell = anywhere
    with (
        open_link(connect=(cell.endpoint,), security=secured(pki, "operator.anna")) as anna,
        dishonest(cell.endpoint, pki, "operator.ben", mode="client") as ben,
    ):
        heard: set[str] = set()
        for key in ("**", HAND.key_for(CELL), HAND.key_for(CELL, operator=ANNA)):
            ben.declare_subscriber(key, lambda sample: heard.add(str(sample.key_expr)))
        hand, before = anna.publisher(HAND, CELL, operator=ANNA), cell.hands
        until(lambda: hand.put(another_sample()) or cell.hands > before + 10)
        time.sleep(QUIET_S)
        assert heard <= {STATE.key_for(CELL)}


@pytest.mark.slow
def test_an_operator_cannot_speak_to_anothers_local_site_through_a_router(pki: Path, routed: Cell) -> None:
    with (
        open_link(connect=(routed.endpoint,), security=secured(pki, "operator.anna")) as anna,
        dishonest(routed.endpoint, pki, "operator.anna", mode="client") as page,
        dishonest(routed.endpoint, pki, "operator.ben", mode="client") as ben,
    ):
        intents = anna._session.declare_subscriber(
            INTENT.key_for(CELL, operator=ANNA), zenoh.handlers.RingChannel(8), allowed_origin=zenoh.Locality.REMOTE
        )
        asked = anna._session.declare_queryable(OPERATE.key_for(CELL, operator=ANNA), zenoh.handlers.RingChannel(8))
        until(lambda: page.put(INTENT.key_for(CELL, operator=ANNA), b"hers") or intents.try_recv())
        time.sleep(QUIET_S)
        while intents.try_recv() is not None:
            pass
        for key in (INTENT.key_for(CELL, operator=ANNA), f"farhand/{CELL}/operator/**"):
            ben.put(key, b"forged")
            list(ben.get(OPERATE.key_for(CELL, operator=ANNA), payload=encode(request()), timeout=QUIET_S))
        time.sleep(QUIET_S)
        assert [intents.try_recv(), asked.try_recv()] == [None, None]


def test_an_operator_asks_for_the_clock_on_the_own_key_alone(pki: Path, cell: Cell) -> None:
    with dishonest(cell.endpoint, pki, "operator.ben") as ben:

        def answers(key: str) -> list[zenoh.Reply]:
            replies = ben.get(key, payload=encode(ClockQuestion()), timeout=QUIET_S)
            return [reply for reply in replies if reply.ok is not None]

        until(lambda: answers(OWN_CLOCK.key_for(CELL, operator=BEN)))
        for key in (OWN_CLOCK.key_for(CELL, operator=ANNA), OWN_CLOCK.key_for(CELL), CLOCK.key_for(CELL)):
            assert not answers(key)


def test_an_honest_client_refuses_itself_anothers_name(pki: Path, cell: Cell) -> None:
    with open_link(connect=(cell.endpoint,), security=secured(pki, "operator.ben")) as link:
        with pytest.raises(RefusedError, match=r'operator\.lab\.ben may not send .*/hand/anna: .*operator = "ben"'):
            link.publisher(HAND, CELL, operator=ANNA)
        with pytest.raises(RefusedError, match=r"may not ask .*lease/anna"):
            link.ask(LEASE, CELL, None, operator=ANNA)  # type: ignore[misc]  # refused before it is encoded
        with pytest.raises(RefusedError, match=r"may not receive .*/hand/\*"):
            link.latest(HAND, CELL)


@pytest.mark.slow
@pytest.mark.parametrize("protocol", SECURED)
def test_a_name_taken_off_the_list_is_refused_after_a_restart_and_learns_why(pki: Path, protocol: str) -> None:
    with running(secured(pki, "remote"), protocol) as cell, dishonest(cell.endpoint, pki, "operator.ben") as ben:
        until(lambda: names_heard(ben, cell) == {BEN})
    with running(secured(pki, "remote"), protocol, operators=(ANNA,)) as cell:
        with open_link(connect=(cell.endpoint,), security=secured(pki, "operator.ben")) as link:
            assert link.ask(CLOCK, CELL, ClockQuestion()) is None
            assert 'leaves out "ben"; add the name and restart' in link.why_silent()
        with dishonest(cell.endpoint, pki, "operator.ben") as ben:
            assert names_heard(ben, cell) == set()
        with open_link(connect=(cell.endpoint,), security=secured(pki, "operator.anna")) as anna:
            assert reply_to(anna, EngagementAction.ENGAGE).done


@pytest.mark.slow
def test_a_site_that_runs_while_its_name_is_taken_off_learns_why_it_is_answered_no_more(pki: Path) -> None:
    port = free_port()
    with open_link(connect=(f"tls/127.0.0.1:{port}",), security=secured(pki, "operator.ben")) as ben:
        with running(secured(pki, "remote"), port=port):
            until(lambda: ben.ask(CLOCK, CELL, ClockQuestion()) is not None)
        until(lambda: ben.why_silent() == "")  # nobody is there
        with running(secured(pki, "remote"), port=port, operators=(ANNA,)):
            until(lambda: 'leaves out "ben"' in ben.why_silent())
            assert ben.ask(CLOCK, CELL, ClockQuestion()) is None


@pytest.mark.slow
@pytest.mark.parametrize("protocol", SECURED)
def test_a_name_that_the_router_does_not_list_is_refused(pki: Path, protocol: str) -> None:
    with behind_router(pki, protocol, (ANNA,)) as cell:
        with dishonest(cell.endpoint, pki, "operator.ben") as ben:
            assert names_heard(ben, cell) == set()
        with open_link(connect=(cell.endpoint,), security=secured(pki, "operator.anna")) as anna:
            assert reply_to(anna, EngagementAction.ENGAGE).done


def test_without_a_list_nobody_with_a_certificate_operates(pki: Path) -> None:
    with (
        running(secured(pki, "remote"), operators=()) as cell,
        dishonest(cell.endpoint, pki, "operator.anna") as anna,
    ):
        assert names_heard(anna, cell) == set()
