"""Setup of the bench's sites: certificates, QUIC for control, TLS for pictures; all else default."""

from dataclasses import dataclass
from datetime import UTC, datetime
from pathlib import Path

from common.link.config import LinkSecurity
from farhand.certificates.folder import CertificateOrder, create
from farhand.loopback.site_process import free_ports
from lab.stage.cell_certificates import CellCertificates
from lab.stage.cell_endpoints import CellEndpoints
from remote_site.video.config import VideoConfig

CELL, OPERATOR = "wan", "anna"
HOST = "localhost"  # both hosts know the remote site's by this name
PLAYED = tuple(camera.name for camera in VideoConfig().cameras)


@dataclass(frozen=True, slots=True)
class WanSetup:
    """Where the programs meet, and with which certificates."""

    certificates: CellCertificates
    endpoints: CellEndpoints
    viewers: str
    page_port: int

    @classmethod
    def make(cls, folder: Path) -> "WanSetup":
        """Choose free ports, and make the certificates."""
        create(folder, CertificateOrder(CELL, (HOST,), 1, (OPERATOR,)), datetime.now(UTC))
        control, video, viewers, listen, page = free_ports(5)
        served = f"quic/{HOST}:{control}", f"tls/{HOST}:{video}", f"tcp/127.0.0.1:{listen}"
        return cls(CellCertificates(folder, CELL), CellEndpoints(CELL, *served), f"tls/{HOST}:{viewers}", page)

    @property
    def security(self) -> LinkSecurity:
        """The security of the bench's own link: that of the operator."""
        return self.certificates.security_of(f"operator.{OPERATOR}")

    @property
    def security_of_viewer(self) -> LinkSecurity:
        """The security of a viewer's link."""
        return self.certificates.security_of("viewer")

    @property
    def remote(self) -> tuple[str, ...]:
        """The settings of the remote site."""
        cameras = ",".join(f'{{name="{name}",source="played"}}' for name in PLAYED)
        robot = f'links.operators=["{OPERATOR}"]', "driver.name=kinematic", f"video.cameras=[{cameras}]"
        return *self.endpoints.remote, *self.certificates.settings_of("remote"), *robot

    @property
    def watched(self) -> tuple[str, ...]:
        """The settings of a remote site that lets viewers in, beyond `remote`."""
        shown = self.certificates.settings_of("viewers-remote", "links.viewers.tls")
        return f"links.viewers.listen={self.viewers}", *shown

    @property
    def local(self) -> tuple[str, ...]:
        """The settings of the local site, whose hand is scripted."""
        return *self.endpoints.local, *self._shown, "tracking.method=markers", f"authority.operator={OPERATOR}"

    @property
    def console(self) -> tuple[str, ...]:
        """The settings of the console."""
        return *self.endpoints.console, *self._shown, f"operator={OPERATOR}", f"serve.port={self.page_port}"

    @property
    def _shown(self) -> tuple[str, ...]:
        return self.certificates.settings_of(f"operator.{OPERATOR}")
