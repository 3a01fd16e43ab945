"""What the doctor finds about the viewers' endpoint: its certificate, whose authority that is of, and its port."""

from datetime import UTC, datetime
from pathlib import Path

import pytest

from common.link.config import TlsConfig, ViewersConfig
from farhand.certificates.folder import CertificateOrder, add_router, create
from farhand.doctor.examination import examine_config
from farhand.doctor.findings import Finding, Severity
from farhand.router import RouterConfig
from tests.common.link.secured_cell import CELL, free_port, secured


@pytest.fixture
def pki(tmp_path: Path) -> Path:
    create(tmp_path, CertificateOrder(CELL, (), 20, ("anna",)), datetime.now(UTC))
    add_router(tmp_path, CertificateOrder(CELL, (), 20), datetime.now(UTC))
    return tmp_path


def findings(pki: Path, viewers: TlsConfig) -> list[Finding]:
    """What is found about a router that shows viewers this certificate."""
    at = ViewersConfig(listen=f"tls/127.0.0.1:{free_port()}", tls=viewers)
    own = secured(pki, "router").tls
    return examine_config(RouterConfig(cell=CELL, tls=own, operators=("anna",), viewers=at))


def test_a_viewers_certificate_that_expires_soon_is_told_and_its_port(pki: Path) -> None:
    found = findings(pki, secured(pki, "viewers-router").tls)
    soon = next(finding for finding in found if "viewers-router.pem" in finding.sentence)
    assert "expires in 20 days" in soon.sentence
    assert soon.level is Severity.WARNING
    assert [finding.level for finding in found if finding.check == "port viewers"] == [Severity.OK]
    assert not [finding for finding in found if finding.level is Severity.ERROR]


def test_the_sites_own_authority_and_a_site_of_another_role_are_found(pki: Path) -> None:
    wrong = [finding for finding in findings(pki, secured(pki, "router").tls) if finding.level is Severity.ERROR]
    assert "viewers need one of their own" in " ".join(finding.sentence for finding in wrong)
    wrong = [f for f in findings(pki, secured(pki, "viewers-remote").tls) if f.level is Severity.ERROR]
    assert "is for remote.lab, not for router.lab" in " ".join(finding.sentence for finding in wrong)
