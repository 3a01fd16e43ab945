"""Links with real certificates: each role sends, receives and requests what it may, and nothing else arrives."""

from datetime import UTC, datetime, timedelta
from pathlib import Path

import pytest
from cryptography.hazmat.primitives import serialization

from common.errors import RefusedError, TransportError
from common.link.channels import ENGAGEMENT, HAND, STATE
from common.link.config import ON_THIS_HOST, PLAIN_TEXT_WORDS, LinkSecurity, TlsConfig
from common.link.credentials import load_credentials
from common.link.endpoints import check_endpoint, from_this_host
from common.link.roles import Identity, Role
from common.link.transport import open_link
from common.messages.requests import EngagementAction
from farhand.certificates.authorities import load_authority
from farhand.certificates.issuing import issue
from lab.stage.waiting import until
from tests.common.link.secured_cell import (
    ANNA,
    CELL,
    HAND_SAMPLE,
    Cell,
    commands_arrive,
    dishonest,
    free_port,
    keep,
    reply_to,
    request,
    secured,
)


def test_an_operator_commands_and_hears(pki: Path, cell: Cell) -> None:
    with open_link(connect=(cell.endpoint,), security=secured(pki, "operator.anna")) as link:
        hand, state = link.publisher(HAND, CELL, operator=ANNA), link.latest(STATE, CELL)
        before = cell.hands
        until(lambda: hand.put(HAND_SAMPLE) or cell.hands > before)
        until(state.take)
        assert reply_to(link, EngagementAction.ENGAGE).done
        with dishonest(cell.endpoint, pki, "operator.anna") as session:
            until(lambda: commands_arrive(session, cell))


def test_maintenance_stops_and_resets_but_never_engages(pki: Path, cell: Cell) -> None:
    with open_link(connect=(cell.endpoint,), security=secured(pki, "maintenance")) as link:
        assert reply_to(link, EngagementAction.STOP, maintenance=True).done
        with pytest.raises(RefusedError, match=r"maintenance\.lab may not ask .*engagement"):
            link.ask(ENGAGEMENT, CELL, request(), operator=ANNA)


@pytest.mark.slow
@pytest.mark.parametrize("of", [CELL, "other"])
def test_a_routers_certificate_commands_nothing_where_no_router_is_used(pki: Path, cell: Cell, of: str) -> None:
    with dishonest(cell.endpoint, pki, "router", cell=of) as session:
        assert not commands_arrive(session, cell)


def test_pictures_do_not_go_by_quic(pki: Path) -> None:
    endpoint = f"quic/127.0.0.1:{free_port()}"
    with pytest.raises(TransportError, match=r"write it as tls/127\.0\.0\.1:"):
        open_link(listen=(endpoint,), security=secured(pki, "remote"), send_buffer_bytes=1 << 18)


def test_a_certificate_is_of_no_use_for_another_cell(pki: Path, cell: Cell) -> None:
    with (
        open_link(connect=(cell.endpoint,), security=secured(pki, "operator.anna")) as link,
        pytest.raises(
            RefusedError, match=r"operator\.lab\.anna is for cell lab; it may not send farhand/other/hand/anna"
        ),
    ):
        link.publisher(HAND, "other", operator=ANNA)


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
    stranger = issue(load_authority(pki), Identity(Role.VIEWER, "x.y"), ("localhost",), datetime.now(UTC), timedelta(1))
    keep(tmp_path / "stranger", stranger)
    nameless = Identity(Role.OPERATOR, CELL)
    keep(tmp_path / "old", issue(load_authority(pki), nameless, ("localhost",), datetime.now(UTC), timedelta(1)))
    for why, files in {
        "is not the key of": (ca, f"{ours}/remote.pem", f"{ours}/operator.anna.key"),
        "comes from another authority": (f"{pki}/foreign/ca.pem", f"{ours}/remote.pem", f"{ours}/remote.key"),
        "cannot read": (ca, f"{ours}/nobody.pem", f"{ours}/remote.key"),
        "are they PEM files": (ca, str(tmp_path / "noise.pem"), f"{ours}/remote.key"),
        "no role at a cell": (ca, f"{tmp_path}/stranger.pem", f"{tmp_path}/stranger.key"),
        "farhand certificates operator lab NAME": (ca, f"{tmp_path}/old.pem", f"{tmp_path}/old.key"),
    }.items():
        with pytest.raises(TransportError, match=why):
            load_credentials(TlsConfig(ca=files[0], certificate=files[1], key=files[2]))


def test_a_key_with_a_password_is_refused_instead_of_asked_for(pki: Path, tmp_path: Path) -> None:
    key = serialization.load_pem_private_key((pki / CELL / "remote.key").read_bytes(), None)
    formats = (serialization.PrivateFormat.PKCS8, serialization.PrivateFormat.TraditionalOpenSSL)
    for number, written in enumerate(formats):
        path = tmp_path / f"{number}.key"
        locked = serialization.BestAvailableEncryption(b"secret")
        path.write_bytes(key.private_bytes(serialization.Encoding.PEM, written, locked))
        tls = TlsConfig(ca=str(pki / "ca.pem"), certificate=str(pki / CELL / "remote.pem"), key=str(path))
        with pytest.raises(TransportError, match=r"locked with a password.*openssl pkey -in"):
            load_credentials(tls)


def test_who_listens_everywhere_is_reached_on_the_loopback_interface() -> None:
    assert from_this_host("tls/0.0.0.0:7447") == "tls/127.0.0.1:7447"
    assert from_this_host("tls/[::]:7447") == "tls/[::1]:7447"
    assert from_this_host("tcp/10.0.0.4:7447") == "tcp/10.0.0.4:7447"


@pytest.mark.slow
def test_local_programs_need_no_certificate_where_the_local_site_has_one(pki: Path, cell: Cell) -> None:
    here = f"tcp/127.0.0.1:{free_port()}"
    with (
        open_link(listen=(here,), connect=(cell.endpoint,), security=secured(pki, "operator.anna")) as local,
        open_link(connect=(here,)) as program,
    ):
        hand, heard = local.publisher(HAND, CELL, operator=ANNA), program.latest(HAND, CELL, operator=ANNA)
        until(lambda: hand.put(HAND_SAMPLE) or heard.take())
