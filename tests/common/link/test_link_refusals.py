"""Links with real certificates: a refused side gets the reason, and an impostor is not believed."""

import time
from contextlib import ExitStack
from datetime import UTC, datetime, timedelta
from pathlib import Path

import pytest
import zenoh

from common.errors import RefusedError, TransportError
from common.link.channels import CLOCK, HAND, OWN_CLOCK, STATE
from common.link.config import ON_THIS_HOST, LinkSecurity, TlsConfig
from common.link.endpoints import SECURED
from common.link.roles import Identity, Role
from common.link.transport import Link, open_link
from common.messages.codec import encode
from common.messages.requests import ClockQuestion
from farhand.certificates.authorities import load_authority
from farhand.certificates.issuing import issue
from lab.stage.waiting import until
from tests.common.link.secured_cell import (
    ANNA,
    CELL,
    HAND_SAMPLE,
    ROBOT_STATE,
    Cell,
    commands_arrive,
    dishonest,
    free_port,
    keep,
    running,
    secured,
)

KNOWN_WITHIN_S = 10.0  # until who is refused knows why; three where a machine has nothing else to do


def why_refused(endpoint: str, security: LinkSecurity) -> str:
    """The reason that the refused side gets, in good time."""
    began = time.monotonic()
    with pytest.raises(TransportError) as caught:
        open_link(connect=(endpoint,), security=security)
    assert time.monotonic() - began < KNOWN_WITHIN_S
    return str(caught.value)


@pytest.mark.slow
def test_without_a_certificate(pki: Path, cell: Cell) -> None:
    assert "needs certificates" in why_refused(cell.endpoint, ON_THIS_HOST)
    with dishonest(cell.endpoint, pki, None) as session:
        assert not commands_arrive(session, cell)
        assert session.info.links() == []


@pytest.mark.slow
def test_another_authority_with_the_same_names(pki: Path, cell: Cell) -> None:
    foreign = pki / "foreign"
    assert "comes from another authority" in why_refused(cell.endpoint, secured(foreign, "operator.anna"))
    with dishonest(cell.endpoint, foreign, "operator.anna") as session:
        assert not commands_arrive(session, cell)


def test_a_stranger_who_trusts_us_is_told_that_we_do_not_trust_it(pki: Path, cell: Cell) -> None:
    pair = pki / "foreign" / CELL / "operator.anna"
    mixed = TlsConfig(ca=str(pki / "ca.pem"), certificate=f"{pair}.pem", key=f"{pair}.key")
    assert "comes from another authority" in why_refused(cell.endpoint, LinkSecurity(tls=mixed))


@pytest.mark.slow
def test_quic_where_only_tls_comes_through_says_what_is_blocked(pki: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr("common.link.probe.QUIC_PATIENCE_S", 1.0)
    with running(secured(pki, "remote"), "tls") as cell:
        endpoint = cell.endpoint.replace("tls/", "quic/")
        with open_link(connect=(endpoint,), security=secured(pki, "operator.anna")) as link:
            until(lambda: f"let UDP through to port {endpoint.rpartition(':')[2]}" in told(link))


@pytest.mark.slow
def test_quic_that_has_been_there_is_not_said_to_be_blocked(pki: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr("common.link.probe.QUIC_PATIENCE_S", 0.2)
    with ExitStack() as stack:
        with running(secured(pki, "remote"), "quic") as cell:
            link = stack.enter_context(open_link(connect=(cell.endpoint,), security=secured(pki, "operator.anna")))
            until(lambda: link.ask(CLOCK, CELL, ClockQuestion()))
        port = int(cell.endpoint.rpartition(":")[2])
        stack.enter_context(running(secured(pki, "remote"), "tls", port))
        until(lambda: not link._session.info.links())
        for _ in range(3):
            assert told(link) == ""
            time.sleep(0.2)


def test_an_operator_of_another_cell(pki: Path, cell: Cell) -> None:
    why = why_refused(cell.endpoint, secured(pki, "operator.anna", "other"))
    assert "is not the remote site of cell other" in why
    assert "certificate of remote.lab" in why


@pytest.mark.slow
def test_an_expired_certificate(pki: Path, cell: Cell) -> None:
    assert "aged.pem has expired; renew it" in why_refused(cell.endpoint, secured(pki, "aged"))
    with dishonest(cell.endpoint, pki, "aged") as session:
        assert not commands_arrive(session, cell)


@pytest.mark.slow
def test_a_certificate_that_expires_ends_the_link_and_says_so(pki: Path, cell: Cell) -> None:
    brief = Identity(Role.OPERATOR, CELL, ANNA)
    keep(
        pki / CELL / "brief", issue(load_authority(pki), brief, ("127.0.0.1",), datetime.now(UTC), timedelta(seconds=3))
    )
    with open_link(connect=(cell.endpoint,), security=secured(pki, "brief")) as link:
        assert link._session.info.links()
        until(lambda: "reports that it has expired; renew it" in told(link))
        until(lambda: not link._session.info.links())


def told(link: Link) -> str:
    try:
        link.check_connected()
    except RefusedError as error:
        return str(error)
    return ""


@pytest.mark.slow
def test_plain_tcp_against_tls(cell: Cell) -> None:
    plain = f"tcp/{cell.endpoint.partition('/')[2]}"
    assert "refuses plain tcp: the listener there speaks TLS only" in why_refused(plain, ON_THIS_HOST)


@pytest.mark.slow
def test_tls_against_plain_tcp(pki: Path) -> None:
    with running(ON_THIS_HOST, "tcp") as plain:
        why = why_refused(plain.endpoint.replace("tcp/", "tls/"), secured(pki, "operator.anna"))
    assert "does not speak TLS" in why


@pytest.mark.parametrize("protocol", SECURED)
@pytest.mark.parametrize(
    ("who", "why"),
    [
        ("earlier-maintenance", "the listener there shows the certificate of maintenance.lab"),
        ("operator.ben", "the listener there shows the certificate of operator.lab.ben"),
    ],
)
def test_an_impostor_who_is_there_already(pki: Path, protocol: str, who: str, why: str) -> None:
    endpoint = f"{protocol}/127.0.0.1:{free_port()}"
    with dishonest(endpoint, pki, who, listen=True):
        assert why in why_refused(endpoint, secured(pki, "operator.anna"))


def test_a_clients_certificate_is_no_servers(pki: Path) -> None:
    endpoint = f"tls/127.0.0.1:{free_port()}"
    with dishonest(endpoint, pki, "maintenance", listen=True):
        why = why_refused(endpoint, secured(pki, "operator.anna"))
    assert "the certificate shown there is not made for this use" in why


@pytest.mark.slow
@pytest.mark.parametrize("protocol", SECURED)
def test_an_impostor_who_comes_later_hears_nothing_and_is_not_believed(pki: Path, protocol: str) -> None:
    endpoint = f"{protocol}/127.0.0.1:{free_port()}"
    with ExitStack() as stack:
        link = stack.enter_context(open_link(connect=(endpoint,), security=secured(pki, "operator.anna")))
        hand, state = link.publisher(HAND, CELL, operator=ANNA), link.latest(STATE, CELL)
        impostor = stack.enter_context(dishonest(endpoint, pki, "earlier-maintenance", listen=True))
        heard = impostor.declare_subscriber("**", zenoh.handlers.RingChannel(1), allowed_origin=zenoh.Locality.REMOTE)
        answering = impostor.declare_queryable(OWN_CLOCK.key_for(CELL, operator=ANNA), zenoh.handlers.RingChannel(1))
        until(link._session.info.links)
        for _ in range(20):
            hand.put(HAND_SAMPLE)
            impostor.put(STATE.key_for(CELL), encode(ROBOT_STATE))
            time.sleep(0.02)
        assert link.ask(CLOCK, CELL, ClockQuestion()) is None
        assert (heard.try_recv(), answering.try_recv(), state.take()) == (None, None, None)
        with pytest.raises(RefusedError, match=r"does somebody impersonate that site\?"):
            link.check_connected()
