"""Which endpoints the doctor tries, and what it states of those that do not answer."""

from pathlib import Path

import msgspec
import pytest

from common.errors import RefusedError, TransportError
from common.link.config import LinkSecurity, TlsConfig
from farhand.doctor.examination import examine_link_of
from farhand.doctor.link.figures import LinkFigures, WayFigures
from farhand.doctor.link.protocols import examine_link
from local_site.config import LocalConfig, LocalLinksConfig
from local_site.console.config import ConsoleConfig, ConsoleLinksConfig

WAY = WayFigures(jitter_ms=1.0, excess_p99_ms=4.0, loss=0.0, stalls=0.0, mbit_s=60.0)
GIVEN = TlsConfig(ca="ca.pem", certificate="anna.pem", key="anna.key")


class Measuring:
    """Measures what answers; keeps what it was asked."""

    def __init__(self, *silent: str) -> None:
        self.silent, self.asked = silent, list[tuple[str, str, str]]()

    def __call__(self, endpoint: str, _security: LinkSecurity, cell: str, operator: str) -> LinkFigures:
        self.asked.append((endpoint, cell, operator))
        if endpoint.startswith(self.silent):
            raise TransportError(f"{endpoint} does not answer")
        return LinkFigures(endpoint, 20.0, 21.0, 22.0, WAY, WAY)


def local(remote: str) -> LocalConfig:
    links = LocalLinksConfig(remote=remote, tls=GIVEN)
    config = LocalConfig(cell="lab", links=links)
    return msgspec.structs.replace(config, authority=msgspec.structs.replace(config.authority, operator="anna"))


@pytest.mark.parametrize(("configured", "other"), [("tls", "quic"), ("quic", "tls")])
def test_the_configured_endpoint_is_measured_and_then_the_other_protocol(configured: str, other: str) -> None:
    measuring = Measuring("nothing")
    found = examine_link(local(f"{configured}/cell:7447"), measuring)
    assert measuring.asked == [(f"{protocol}/cell:7447", "lab", "anna") for protocol in (configured, other)]
    assert [finding.check for finding in found][:2] == [f"link {configured}", f"link {other}"]


def test_a_consoles_file_will_do_too() -> None:
    measuring = Measuring("nothing")
    links = ConsoleLinksConfig(control="tls/cell:7447", video="tls/cell:7448", tls=GIVEN)
    examine_link(ConsoleConfig(cell="lab", operator="ben", links=links), measuring)
    assert measuring.asked[0] == ("tls/cell:7447", "lab", "ben")


def test_quic_that_does_not_answer_is_no_mistake_where_tls_is_configured() -> None:
    found = examine_link(local("tls/cell:7447"), Measuring("quic/"))
    quic = next(finding for finding in found if finding.check == "link quic")
    assert quic.level == "ok"
    assert "tried and not measured" in quic.sentence


def test_a_configured_endpoint_that_does_not_answer_is_an_error() -> None:
    found = examine_link(local("quic/cell:7447"), Measuring("quic/"))
    assert (found[1].check, found[1].level) == ("link quic", "error")
    assert found[0].check == "link tls"
    assert len(found) == 2


def test_without_certificates_only_plain_tcp_is_measured_and_it_says_so() -> None:
    measuring = Measuring("nothing")
    found = examine_link(LocalConfig(), measuring)
    assert [asked[0] for asked in measuring.asked] == ["tcp/127.0.0.1:7447"]
    assert "TLS and QUIC were not tried" in next(f for f in found if f.check == "link tls, quic").sentence


def test_a_certificate_that_may_not_probe_is_reported() -> None:
    def refusing(*_: object) -> LinkFigures:
        raise RefusedError("the certificate of viewer.lab may not send farhand/lab/probe/anna")

    assert "may not send" in examine_link(LocalConfig(), refusing)[0].sentence


def test_the_remote_sites_own_file_is_not_for_it(tmp_path: Path) -> None:
    path = tmp_path / "remote.toml"
    path.write_text('[driver]\nname = "kinematic"\n')
    assert "operator's host" in examine_link_of(path, ())[0].sentence
