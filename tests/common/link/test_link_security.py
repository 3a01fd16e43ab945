"""Links with real certificates: who is refused hears why, and what is refused never arrives."""

import time
from collections.abc import Iterator
from contextlib import ExitStack, contextmanager
from datetime import UTC, datetime, timedelta
from pathlib import Path

import pytest
import zenoh

from common.errors import RefusedError, TransportError
from common.link.channels import CLOCK, ENGAGEMENT, HAND, MAINTENANCE, STATE
from common.link.config import ON_THIS_HOST, PLAIN_TEXT_WORDS, LinkSecurity, TlsConfig
from common.link.credentials import load_credentials
from common.link.endpoints import SECURED, check_endpoint, from_this_host
from common.link.roles import Identity, Role
from common.link.transport import Link, open_link
from common.messages.codec import encode
from common.messages.requests import ClockQuestion, EngagementAction
from farhand.certificates.folder import CertificateOrder, create, load_authority
from farhand.certificates.issuing import issue
from tests.common.link.secured_cell import (
    CELL,
    HAND_SAMPLE,
    QUIET_S,
    ROBOT_STATE,
    Cell,
    commands_arrive,
    dishonest,
    free_port,
    keep,
    reply_to,
    request,
    secured,
    until,
)

PROMISED_S = 3.0  # until who is refused knows why


@pytest.fixture(scope="module")
def pki(tmp_path_factory: pytest.TempPathFactory) -> Path:
    """Two cells of one authority, and a cell of another authority with the same names."""
    folder = tmp_path_factory.mktemp("pki")
    now = datetime.now(UTC)
    create(folder, CertificateOrder(CELL, (), 30), now)
    create(folder, CertificateOrder("other", (), 30), now)
    create(folder / "foreign", CertificateOrder(CELL, (), 30), now)
    authority = load_authority(folder)
    aged = issue(authority, Identity(Role.OPERATOR, CELL), ("127.0.0.1",), now - timedelta(days=9), timedelta(days=1))
    keep(folder / CELL / "aged", aged)
    return folder


@contextmanager
def running(security: LinkSecurity, protocol: str = "tls", port: int | None = None) -> Iterator[Cell]:
    endpoint = f"{protocol}/127.0.0.1:{port or free_port()}"
    with open_link(listen=(endpoint,), security=security) as link:
        cell = Cell(endpoint, link)
        try:
            yield cell
        finally:
            cell.close()


@pytest.fixture(scope="module", params=SECURED)
def cell(pki: Path, request: pytest.FixtureRequest) -> Iterator[Cell]:
    with running(secured(pki, "remote"), request.param) as cell:
        yield cell


def why_refused(endpoint: str, security: LinkSecurity) -> str:
    """The sentence that the refused side hears, in the time that is promised."""
    began = time.monotonic()
    with pytest.raises(TransportError) as caught:
        open_link(connect=(endpoint,), security=security)
    assert time.monotonic() - began < PROMISED_S
    return str(caught.value)


def test_an_operator_commands_and_hears(pki: Path, cell: Cell) -> None:
    with open_link(connect=(cell.endpoint,), security=secured(pki, "operator")) as link:
        hand, state = link.publisher(HAND, CELL), link.latest(STATE, CELL)
        before = cell.hands
        until(lambda: hand.put(HAND_SAMPLE) or cell.hands > before)
        until(state.take)
        assert reply_to(link, ENGAGEMENT, EngagementAction.ENGAGE).done
        with dishonest(cell.endpoint, pki, "operator") as session:
            assert commands_arrive(session, cell)


def test_a_viewer_hears_and_asks_the_time_but_commands_nothing(pki: Path, cell: Cell) -> None:
    with open_link(connect=(cell.endpoint,), security=secured(pki, "viewer")) as link:
        until(link.latest(STATE, CELL).take)
        until(lambda: link.ask(CLOCK, CELL, ClockQuestion()))
        with pytest.raises(RefusedError, match=r"viewer\.lab may not send .*/hand: that takes one of operator"):
            link.publisher(HAND, CELL)
        with pytest.raises(RefusedError, match=r"may not ask .*engagement"):
            link.ask(ENGAGEMENT, CELL, request())
        with pytest.raises(RefusedError, match=r"may not hear .*/hand"):
            link.latest(HAND, CELL)
    with dishonest(cell.endpoint, pki, "viewer") as session:
        assert not commands_arrive(session, cell)


def test_a_viewer_who_listens_to_everything_hears_no_hand(pki: Path, cell: Cell) -> None:
    with (
        open_link(connect=(cell.endpoint,), security=secured(pki, "operator")) as operator,
        dishonest(cell.endpoint, pki, "viewer") as viewer,
    ):
        heard: set[str] = set()
        for key in ("**", HAND.key_for(CELL)):
            viewer.declare_subscriber(key, lambda sample: heard.add(str(sample.key_expr)))
        hand, before = operator.publisher(HAND, CELL), cell.hands
        until(lambda: hand.put(HAND_SAMPLE) or cell.hands > before)
        time.sleep(QUIET_S)
        assert heard <= {STATE.key_for(CELL)}  # which it may hear


def test_maintenance_stops_and_resets_but_never_engages(pki: Path, cell: Cell) -> None:
    with open_link(connect=(cell.endpoint,), security=secured(pki, "maintenance")) as link:
        assert reply_to(link, MAINTENANCE, EngagementAction.STOP).done
        with pytest.raises(RefusedError, match=r"maintenance\.lab may not ask .*engagement"):
            link.ask(ENGAGEMENT, CELL, request())


def test_without_a_certificate(pki: Path, cell: Cell) -> None:
    assert "needs certificates" in why_refused(cell.endpoint, ON_THIS_HOST)
    with dishonest(cell.endpoint, pki, None) as session:
        assert not commands_arrive(session, cell)
        assert session.info.links() == []


def test_another_authority_with_the_same_names(pki: Path, cell: Cell) -> None:
    foreign = pki / "foreign"
    assert "comes from another authority" in why_refused(cell.endpoint, secured(foreign, "operator"))
    with dishonest(cell.endpoint, foreign, "operator") as session:
        assert not commands_arrive(session, cell)


def test_a_stranger_who_trusts_us_is_told_that_we_do_not_trust_it(pki: Path, cell: Cell) -> None:
    pair = pki / "foreign" / CELL / "operator"
    mixed = TlsConfig(ca=str(pki / "ca.pem"), certificate=f"{pair}.pem", key=f"{pair}.key")
    assert "comes from another authority" in why_refused(cell.endpoint, LinkSecurity(tls=mixed))


def test_quic_where_only_tls_comes_through_says_what_is_blocked(pki: Path) -> None:
    with running(secured(pki, "remote"), "tls") as cell:
        endpoint = cell.endpoint.replace("tls/", "quic/")
        with open_link(connect=(endpoint,), security=secured(pki, "operator")) as link:
            until(lambda: f"let UDP through to port {endpoint.rpartition(':')[2]}" in told(link))


def test_quic_that_has_been_there_is_not_said_to_be_blocked(pki: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr("common.link.transport.QUIC_PATIENCE_S", 0.2)
    with ExitStack() as stack:
        with running(secured(pki, "remote"), "quic") as cell:
            link = stack.enter_context(open_link(connect=(cell.endpoint,), security=secured(pki, "operator")))
            until(lambda: link.ask(CLOCK, CELL, ClockQuestion()))
        port = int(cell.endpoint.rpartition(":")[2])
        stack.enter_context(running(secured(pki, "remote"), "tls", port))
        until(lambda: not link._session.info.links())
        for _ in range(3):
            assert told(link) == ""
            time.sleep(0.2)


def test_pictures_do_not_go_by_quic(pki: Path) -> None:
    endpoint = f"quic/127.0.0.1:{free_port()}"
    with pytest.raises(TransportError, match=r"write it as tls/127\.0\.0\.1:"):
        open_link(listen=(endpoint,), security=secured(pki, "remote"), send_buffer_bytes=1 << 18)


def test_an_operator_of_another_cell(pki: Path, cell: Cell) -> None:
    why = why_refused(cell.endpoint, secured(pki, "operator", "other"))
    assert "is not the remote site of cell other" in why
    assert "certificate of remote.lab" in why


def test_a_certificate_is_of_no_use_for_another_cell(pki: Path, cell: Cell) -> None:
    with (
        open_link(connect=(cell.endpoint,), security=secured(pki, "operator")) as link,
        pytest.raises(RefusedError, match=r"operator\.lab is for cell lab; it may not send farhand/other/hand"),
    ):
        link.publisher(HAND, "other")


def test_an_expired_certificate(pki: Path, cell: Cell) -> None:
    assert "aged.pem has expired; renew it" in why_refused(cell.endpoint, secured(pki, "aged"))
    with dishonest(cell.endpoint, pki, "aged") as session:
        assert not commands_arrive(session, cell)


def test_a_certificate_that_expires_ends_the_link_and_says_so(pki: Path, cell: Cell) -> None:
    brief = Identity(Role.OPERATOR, CELL)
    keep(
        pki / CELL / "brief", issue(load_authority(pki), brief, ("127.0.0.1",), datetime.now(UTC), timedelta(seconds=3))
    )
    with open_link(connect=(cell.endpoint,), security=secured(pki, "brief")) as link:
        assert link._session.info.links()
        until(lambda: "says that it has expired; renew it" in told(link))
        until(lambda: not link._session.info.links())


def told(link: Link) -> str:
    try:
        link.check_connected()
    except RefusedError as error:
        return str(error)
    return ""


def test_plain_tcp_against_tls(cell: Cell) -> None:
    plain = f"tcp/{cell.endpoint.partition('/')[2]}"
    assert "refuses plain tcp: the listener there speaks TLS only" in why_refused(plain, ON_THIS_HOST)


def test_tls_against_plain_tcp(pki: Path) -> None:
    with running(ON_THIS_HOST, "tcp") as plain:
        why = why_refused(plain.endpoint.replace("tcp/", "tls/"), secured(pki, "operator"))
    assert "does not speak TLS" in why


@pytest.mark.parametrize("protocol", SECURED)
def test_an_impostor_who_is_there_already(pki: Path, protocol: str) -> None:
    endpoint = f"{protocol}/127.0.0.1:{free_port()}"
    with dishonest(endpoint, pki, "viewer", listen=True):
        assert "the listener there shows the certificate of viewer.lab" in why_refused(
            endpoint, secured(pki, "operator")
        )


@pytest.mark.parametrize("protocol", SECURED)
def test_an_impostor_who_comes_later_hears_nothing_and_is_not_believed(pki: Path, protocol: str) -> None:
    endpoint = f"{protocol}/127.0.0.1:{free_port()}"
    with ExitStack() as stack:
        link = stack.enter_context(open_link(connect=(endpoint,), security=secured(pki, "operator")))
        hand, state = link.publisher(HAND, CELL), link.latest(STATE, CELL)
        impostor = stack.enter_context(dishonest(endpoint, pki, "viewer", listen=True))
        heard = impostor.declare_subscriber("**", zenoh.handlers.RingChannel(1), allowed_origin=zenoh.Locality.REMOTE)
        answering = impostor.declare_queryable(CLOCK.key_for(CELL), zenoh.handlers.RingChannel(1))
        until(link._session.info.links)
        for _ in range(20):
            hand.put(HAND_SAMPLE)
            impostor.put(STATE.key_for(CELL), encode(ROBOT_STATE))
            time.sleep(0.02)
        assert link.ask(CLOCK, CELL, ClockQuestion()) is None
        assert (heard.try_recv(), answering.try_recv(), state.take()) == (None, None, None)
        with pytest.raises(RefusedError, match=r"does somebody impersonate that site\?"):
            link.check_connected()


@pytest.mark.parametrize("endpoint", ["tcp/0.0.0.0:7447", "tcp/192.168.1.4:7447", "tcp/robot.example.org:7447"])
def test_plain_tcp_leaves_this_host_only_by_words_that_cannot_be_missed(endpoint: str) -> None:
    with pytest.raises(TransportError, match="would let anybody move the arm"):
        check_endpoint(endpoint, ON_THIS_HOST)
    check_endpoint(endpoint, LinkSecurity(plain_text_beyond_loopback=PLAIN_TEXT_WORDS))
    with pytest.raises(ValueError, match="i accept that anybody"):
        LinkSecurity(plain_text_beyond_loopback="yes")


def test_certificates_without_a_key_are_a_mistake() -> None:
    with pytest.raises(ValueError, match="give all three, or none"):
        TlsConfig(ca="ca.pem", certificate="remote.pem")


def test_files_that_do_not_belong_together_are_told_apart(pki: Path, tmp_path: Path) -> None:
    ours, ca = pki / CELL, str(pki / "ca.pem")
    (tmp_path / "noise.pem").write_text("noise")
    stranger = issue(
        load_authority(pki), Identity(Role.OPERATOR, "x.y"), ("localhost",), datetime.now(UTC), timedelta(1)
    )
    keep(tmp_path / "stranger", stranger)
    for why, files in {
        "is not the key of": (ca, f"{ours}/remote.pem", f"{ours}/operator.key"),
        "comes from another authority": (f"{pki}/foreign/ca.pem", f"{ours}/remote.pem", f"{ours}/remote.key"),
        "cannot read": (ca, f"{ours}/nobody.pem", f"{ours}/remote.key"),
        "are they PEM files": (ca, str(tmp_path / "noise.pem"), f"{ours}/remote.key"),
        "no role at a cell": (ca, f"{tmp_path}/stranger.pem", f"{tmp_path}/stranger.key"),
    }.items():
        with pytest.raises(TransportError, match=why):
            load_credentials(TlsConfig(ca=files[0], certificate=files[1], key=files[2]))


def test_who_listens_everywhere_is_reached_on_the_loopback_interface() -> None:
    assert from_this_host("tls/0.0.0.0:7447") == "tls/127.0.0.1:7447"
    assert from_this_host("tls/[::]:7447") == "tls/[::1]:7447"
    assert from_this_host("tcp/10.0.0.4:7447") == "tcp/10.0.0.4:7447"


def test_local_programs_need_no_certificate_where_the_local_site_has_one(pki: Path, cell: Cell) -> None:
    here = f"tcp/127.0.0.1:{free_port()}"
    with (
        open_link(listen=(here,), connect=(cell.endpoint,), security=secured(pki, "operator")) as local,
        open_link(connect=(here,)) as program,
    ):
        hand, heard = local.publisher(HAND, CELL), program.latest(HAND, CELL)
        until(lambda: hand.put(HAND_SAMPLE) or heard.take())
