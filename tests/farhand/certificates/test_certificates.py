"""The authority's folder: what is made, for whom, never over what is there; and what the doctor reports about it."""

import stat
import time
from datetime import UTC, datetime, timedelta
from pathlib import Path
from types import SimpleNamespace
from typing import cast

import pytest
from cryptography import x509
from cryptography.x509.oid import ExtendedKeyUsageOID

from common.errors import ConfigError, TransportError
from common.link.config import LinkSecurity, TlsConfig
from common.link.credentials import CertificateValidity, check_links, load_credentials
from common.link.roles import Identity, Role, read_common_name
from farhand.certificates.authorities import VIEWERS, load_authority, read_certificate
from farhand.certificates.folder import (
    CertificateOrder,
    add_operators,
    add_router,
    create,
    hosts_of,
    renew,
)
from farhand.certificates.issuing import issue
from farhand.doctor.findings import Severity, worst
from farhand.doctor.site import CertificateFacts, check_certificate, probe_certificate

NOW = datetime.now(UTC)
ORDER = CertificateOrder("lab", ("robot.example.org", "10.0.0.3"), 90, ("anna", "ben"))
PAIRS = ("remote", "viewer", "viewers-remote", "maintenance", "operator.anna", "operator.ben")


@pytest.fixture
def folder(tmp_path: Path) -> Path:
    create(tmp_path / "pki", ORDER, NOW)
    return tmp_path / "pki"


def files(folder: Path, who: str = "remote", cell: str = "lab") -> TlsConfig:
    pair = folder / cell / who
    authority = "viewers-ca" if who.startswith("viewer") else "ca"
    return TlsConfig(ca=str(folder / f"{authority}.pem"), certificate=f"{pair}.pem", key=f"{pair}.key")


def test_every_role_has_a_certificate_for_all_hosts_and_is_a_server_only_where_it_listens(folder: Path) -> None:
    assert {path.stem for path in (folder / "lab").glob("*.pem")} == set(PAIRS)
    for name in PAIRS:
        certificate = read_certificate(folder / "lab" / f"{name}.pem")
        uses = certificate.extensions.get_extension_for_class(x509.ExtendedKeyUsage).value
        as_server = set() if name in ("viewer", "maintenance") else {ExtendedKeyUsageOID.SERVER_AUTH}
        assert set(uses) == as_server | {ExtendedKeyUsageOID.CLIENT_AUTH}
        assert hosts_of(certificate) == ["127.0.0.1", "::1", "localhost", "robot.example.org", "10.0.0.3"]
        assert certificate.not_valid_after_utc - NOW <= timedelta(days=90)
        identity = load_credentials(files(folder, name)).identity
        assert name.removeprefix("viewers-") == ".".join(filter(None, (identity.role.value, identity.operator)))


def test_keys_are_for_their_owner_only(folder: Path) -> None:
    keys = sorted(folder.rglob("*.key"))
    assert len(keys) == 2 + len(PAIRS)
    assert {stat.S_IMODE(key.stat().st_mode) for key in keys} == {0o600}
    assert list(folder.rglob("*.part")) == []


def test_nothing_is_written_over_what_is_there(folder: Path) -> None:
    before = {path: path.read_bytes() for path in folder.rglob("*.*")}
    with pytest.raises(ConfigError, match="farhand certificates renew lab"):
        create(folder, ORDER, NOW)
    assert {path: path.read_bytes() for path in folder.rglob("*.*")} == before


def test_another_cell_shares_the_authority_and_not_the_names(folder: Path) -> None:
    authority = (folder / "ca.pem").read_bytes()
    create(folder, CertificateOrder("other", (), 90, ("anna",)), NOW)
    assert (folder / "ca.pem").read_bytes() == authority
    anna = Identity(Role.OPERATOR, "lab", "anna")
    hers = Identity(Role.OPERATOR, "other", "anna")
    assert load_credentials(files(folder, "operator.anna", "other")).identity == hers
    theirs = LinkSecurity(tls=files(folder, "operator.anna", "other"))
    with pytest.raises(ConfigError, match=r"is for operator\.other\.anna, not for .*lab\.anna; set cell = \"other\""):
        check_links((), theirs, anna)
    with pytest.raises(ConfigError, match=r"is for operator\.other\.anna, not for .*\.ben; set operator = \"anna\""):
        check_links((), theirs, Identity(Role.OPERATOR, "other", "ben"))
    with pytest.raises(ConfigError, match=r"is for operator\.other\.anna, not for viewer\.other$"):
        check_links((), theirs, Identity(Role.VIEWER, "other"))
    with pytest.raises(ConfigError, match="tls needs certificates"):
        check_links(("tls/127.0.0.1:1",), LinkSecurity(), anna)
    check_links(("tcp/127.0.0.1:1",), LinkSecurity(), anna)


def test_a_further_operator_gets_a_certificate_for_the_same_hosts_and_nobody_loses_one(folder: Path) -> None:
    before = {path: path.read_bytes() for path in folder.rglob("*.*")}
    made = add_operators(folder, CertificateOrder("lab", (), 90, ("carl",)), NOW)
    assert [path.name for path in made] == ["operator.carl.pem"]
    assert hosts_of(read_certificate(made[0]))[-2:] == ["robot.example.org", "10.0.0.3"]
    assert load_credentials(files(folder, "operator.carl")).identity == Identity(Role.OPERATOR, "lab", "carl")
    assert before.items() <= {path: path.read_bytes() for path in folder.rglob("*.*")}.items()
    with pytest.raises(ConfigError, match="carl has a certificate"):
        add_operators(folder, CertificateOrder("lab", (), 90, ("carl",)), NOW)
    with pytest.raises(ConfigError, match="make it first: farhand certificates create other"):
        add_operators(folder, CertificateOrder("other", (), 90, ("carl",)), NOW)


@pytest.mark.parametrize(("cell", "name"), [("lab", "Anna"), ("lab", "a.b"), ("lab", "*"), ("c" * 32, "o" * 32)])
def test_a_name_that_no_key_or_certificate_can_hold_is_refused(cell: str, name: str) -> None:
    with pytest.raises(ConfigError, match=r"small letters|too long for a certificate"):
        CertificateOrder(cell, (), 90, (name,))


def test_a_certificate_that_names_no_operator_is_refused_with_the_cure(folder: Path) -> None:
    nameless = issue(load_authority(folder), Identity(Role.OPERATOR, "lab"), ("::1",), NOW, timedelta(days=1))
    for name, pem in (("operator.pem", nameless.certificate_pem), ("operator.key", nameless.key_pem)):
        (folder / "lab" / name).write_bytes(pem)
    with pytest.raises(TransportError, match=r"'operator\.lab', .*: farhand certificates operator lab NAME"):
        load_credentials(files(folder, "operator"))


def test_a_router_has_a_certificate_only_where_it_is_asked_for_of_one_cell_and_for_its_own_hosts(folder: Path) -> None:
    made = add_router(folder, CertificateOrder("lab", ("meet.example.org",), 90), NOW)
    assert [path.name for path in made] == ["router.pem", "viewers-router.pem"]
    assert load_credentials(files(folder, "viewers-router")).identity == Identity(Role.ROUTER, "lab")
    assert load_credentials(files(folder, "router")).identity == Identity(Role.ROUTER, "lab")
    assert "meet.example.org" in hosts_of(read_certificate(made[0]))
    with pytest.raises(ConfigError, match="router has a certificate"):
        add_router(folder, CertificateOrder("lab", (), 90), NOW)
    with pytest.raises(ConfigError, match="make it first: farhand certificates create other"):
        add_router(folder, CertificateOrder("other", (), 90), NOW)
    renew(folder, CertificateOrder("lab", (), 200), NOW)
    assert all("meet.example.org" in hosts_of(read_certificate(path)) for path in made)
    assert "meet.example.org" not in hosts_of(read_certificate(folder / "lab" / "remote.pem"))


def test_a_routers_certificate_that_names_no_cell_is_refused_with_the_cure(folder: Path) -> None:
    anywhere = issue(
        load_authority(folder),
        cast("Identity", SimpleNamespace(common_name="router", role=Role.ROUTER)),  # which none can have
        ("::1",),
        NOW,
        timedelta(days=1),
    )
    for name, pem in (("router.pem", anywhere.certificate_pem), ("router.key", anywhere.key_pem)):
        (folder / "lab" / name).write_bytes(pem)
    with pytest.raises(TransportError, match=r"'router', .*: farhand certificates router CELL"):
        load_credentials(files(folder, "router"))


@pytest.mark.slow
def test_a_certificate_that_expires_while_a_site_runs_is_found(folder: Path) -> None:
    soon = issue(
        load_authority(folder), Identity(Role.REMOTE, "lab"), ("127.0.0.1",), datetime.now(UTC), timedelta(seconds=2)
    )
    for name, pem in (("soon.pem", soon.certificate_pem), ("soon.key", soon.key_pem)):
        (folder / name).write_bytes(pem)
    tls = TlsConfig(ca=str(folder / "ca.pem"), certificate=str(folder / "soon.pem"), key=str(folder / "soon.key"))
    validity = CertificateValidity(tls)
    validity.check()
    (folder / "soon.pem").write_bytes(b"being renewed")
    validity.check()
    time.sleep(3.1)  # a certificate is good for whole seconds
    with pytest.raises(TransportError, match=r"soon\.pem has expired; renew it"):
        validity.check()
    CertificateValidity(TlsConfig()).check()


def test_renewing_keeps_authority_and_hosts_and_makes_new_keys(folder: Path) -> None:
    authority, key = (folder / "ca.pem").read_bytes(), (folder / "lab" / "remote.key").read_bytes()
    renew(folder, CertificateOrder("lab", ("10.0.0.9",), 200), NOW)
    renewed = read_certificate(folder / "lab" / "remote.pem")
    assert (folder / "ca.pem").read_bytes() == authority
    assert (folder / "lab" / "remote.key").read_bytes() != key
    assert hosts_of(renewed)[-3:] == ["robot.example.org", "10.0.0.3", "10.0.0.9"]
    assert renewed.not_valid_after_utc - NOW > timedelta(days=199)
    assert load_credentials(files(folder)).identity.common_name == "remote.lab"
    anna = read_certificate(folder / "lab" / "operator.anna.pem")
    assert (hosts_of(anna), anna.not_valid_after_utc) == (hosts_of(renewed), renewed.not_valid_after_utc)


@pytest.mark.parametrize("who", ["viewer", "viewers-remote"])
def test_what_viewers_have_is_worth_nothing_to_the_sites_authority(folder: Path, who: str) -> None:
    pair = files(folder, who)
    mixed = TlsConfig(ca=str(folder / "ca.pem"), certificate=pair.certificate, key=pair.key)
    with pytest.raises(TransportError, match="comes from another authority"):
        load_credentials(mixed)


def test_renewing_a_folder_of_before_makes_the_viewers_authority_and_issues_theirs_anew(folder: Path) -> None:
    add_router(folder, CertificateOrder("lab", ("meet.example.org",), 90), NOW)
    theirs, before = folder / "lab", (folder / "ca.pem").read_bytes()
    for gone in (*folder.glob("viewers-ca.*"), *theirs.glob("viewers-*")):
        gone.unlink()
    old = issue(load_authority(folder), Identity(Role.VIEWER, "lab"), ("::1", "old.org"), NOW, timedelta(days=9))
    (theirs / "viewer.pem").write_bytes(old.certificate_pem)
    made = renew(folder, CertificateOrder("lab", (), 90), NOW)
    assert {"viewer.pem", "viewers-remote.pem", "viewers-router.pem"} <= {path.name for path in made}
    for name in ("viewer", "viewers-remote", "viewers-router", "remote"):
        load_credentials(files(folder, name))
    assert "old.org" in hosts_of(read_certificate(theirs / "viewer.pem"))
    assert "robot.example.org" in hosts_of(read_certificate(theirs / "viewers-remote.pem"))
    assert "meet.example.org" in hosts_of(read_certificate(theirs / "viewers-router.pem"))
    assert (folder / "ca.pem").read_bytes() == before
    authority = load_authority(folder, VIEWERS).certificate
    renew(folder, CertificateOrder("lab", (), 90), NOW)
    assert load_authority(folder, VIEWERS).certificate == authority


def test_no_certificate_outlives_its_authority(folder: Path) -> None:
    late = NOW + timedelta(days=3600)
    renew(folder, CertificateOrder("lab", (), 397), late)
    end = read_certificate(folder / "ca.pem").not_valid_after_utc
    assert read_certificate(folder / "lab" / "remote.pem").not_valid_after_utc == end
    with pytest.raises(ConfigError, match="the authority has expired"):
        renew(folder, ORDER, NOW + timedelta(days=3700))


def test_without_the_authoritys_key_nothing_is_made(folder: Path) -> None:
    (folder / "ca.key").unlink()
    with pytest.raises(ConfigError, match="create where the key is kept"):
        create(folder, CertificateOrder("other", (), 90), NOW)
    with pytest.raises(ConfigError, match=r"ca\.key"):
        renew(folder, ORDER, NOW)


@pytest.mark.parametrize(
    "name", ["", "remote", "remote.lab.anna", "router", "boss.lab", "operator.", "operator.A", "operator.a"]
)
def test_other_names_are_nobodys(name: str) -> None:
    assert read_common_name(name) is None


def test_the_doctor_is_content_with_what_was_made(folder: Path) -> None:
    (finding,) = check_certificate(probe_certificate(files(folder), NOW), "remote.lab")
    assert finding.level is Severity.OK
    assert "of remote.lab expires in 90 days" in finding.sentence


def test_the_doctor_finds_what_is_wrong(folder: Path, tmp_path: Path) -> None:
    (folder / "lab" / "remote.key").chmod(0o644)
    assert "everybody on this host" in worst_of(files(folder), "remote.lab", Severity.ERROR)
    (folder / "lab" / "remote.key").chmod(0o640)
    assert "its group" in worst_of(files(folder), "remote.lab", Severity.WARNING)
    assert "not for operator.lab" in worst_of(files(folder), "operator.lab", Severity.ERROR)
    create(tmp_path / "foreign", ORDER, NOW)
    mixed = TlsConfig(
        ca=str(tmp_path / "foreign" / "ca.pem"), certificate=files(folder).certificate, key=files(folder).key
    )
    assert "comes from another authority" in worst_of(mixed, "remote.lab", Severity.ERROR)
    create(tmp_path / "aged", CertificateOrder("lab", (), 30), NOW - timedelta(days=40))
    assert "has expired" in worst_of(files(tmp_path / "aged"), "remote.lab", Severity.ERROR)


@pytest.mark.parametrize(("days", "authority_days", "levels"), [(31, 400, 1), (29, 400, 1), (20, 29, 2)])
def test_the_doctor_warns_a_month_before(days: float, authority_days: float, levels: int) -> None:
    facts = CertificateFacts("remote.pem", "remote.lab", days, authority_days, 0o600)
    findings = check_certificate(facts, "remote.lab")
    assert len(findings) == levels
    assert worst(findings) is (Severity.OK if days > 30 else Severity.WARNING)
    assert all(bool(finding.cure) is (finding.level is not Severity.OK) for finding in findings)


def worst_of(tls: TlsConfig, expected: str, level: Severity) -> str:
    findings = check_certificate(probe_certificate(tls, NOW), expected)
    assert worst(findings) is level
    return next(finding.sentence for finding in findings if finding.level is level)
