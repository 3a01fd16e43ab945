"""Certificates of two cells and of another authority, and a cell that listens with its own."""

from collections.abc import Iterator
from datetime import UTC, datetime, timedelta
from pathlib import Path

import pytest

from common.link.endpoints import SECURED
from common.link.roles import Identity, Role
from farhand.certificates import issuing
from farhand.certificates.authorities import load_authority
from farhand.certificates.folder import CertificateOrder, add_router, create
from farhand.certificates.issuing import issue
from tests.common.link.secured_cell import (
    ANNA,
    CELL,
    OPERATORS,
    Cell,
    keep,
    running,
    secured,
)


@pytest.fixture(scope="module")
def pki(tmp_path_factory: pytest.TempPathFactory) -> Path:
    """Two cells of one authority, and a cell of another authority with the same names."""
    folder = tmp_path_factory.mktemp("pki")
    now = datetime.now(UTC)
    for name in (CELL, "other"):
        create(folder, CertificateOrder(name, (), 30, OPERATORS), now)
        add_router(folder, CertificateOrder(name, (), 30), now)
    create(folder / "foreign", CertificateOrder(CELL, (), 30, OPERATORS), now)
    authority = load_authority(folder)
    aged = issue(
        authority, Identity(Role.OPERATOR, CELL, ANNA), ("127.0.0.1",), now - timedelta(days=9), timedelta(days=1)
    )
    keep(folder / CELL / "aged", aged)
    with pytest.MonkeyPatch.context() as patch:  # as all certificates were made before 0.3
        patch.setattr(issuing, "LISTENERS", frozenset(Role))
        for_every_use = issue(authority, Identity(Role.MAINTENANCE, CELL), ("127.0.0.1",), now, timedelta(days=1))
    keep(folder / CELL / "earlier-maintenance", for_every_use)
    return folder


@pytest.fixture(scope="module", params=SECURED)
def cell(pki: Path, request: pytest.FixtureRequest) -> Iterator[Cell]:
    with running(secured(pki, "remote"), request.param) as cell:
        yield cell
