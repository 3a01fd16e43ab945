"""Setup of the bench's sites: certificates, QUIC for control, TLS for pictures; all else default."""

from dataclasses import dataclass
from datetime import UTC, datetime
from pathlib import Path

import msgspec

from common.link.config import LinkSecurity, TlsConfig
from farhand.certificates.folder import CertificateOrder, create
from farhand.loopback.site_process import free_ports
from remote_site.video.config import VideoConfig

CELL, OPERATOR = "wan", "anna"
HOST = "localhost"  # both hosts know the remote site's by this name
PLAYED = tuple(camera.name for camera in VideoConfig().cameras)


@dataclass(frozen=True, slots=True)
class WanSetup:
    """The endpoints, and the folder of certificates, sockets and records."""

    folder: Path
    control: str
    video: str
    viewers: str
    listen: str
    page_port: int

    @classmethod
    def make(cls, folder: Path) -> "WanSetup":
        """Choose free ports, and make the certificates."""
        create(folder, CertificateOrder(CELL, (HOST,), 1, (OPERATOR,)), datetime.now(UTC))
        control, video, viewers, listen, page = free_ports(5)
        served = f"quic/{HOST}:{control}", f"tls/{HOST}:{video}", f"tls/{HOST}:{viewers}"
        return cls(folder, *served, f"tcp/127.0.0.1:{listen}", page)

    @property
    def security(self) -> LinkSecurity:
        """The security of the bench's own link: that of the operator."""
        return LinkSecurity(tls=self._tls(f"operator.{OPERATOR}"))

    @property
    def security_of_viewer(self) -> LinkSecurity:
        """The security of a viewer's link."""
        return LinkSecurity(tls=self._tls("viewer"))

    @property
    def remote(self) -> tuple[str, ...]:
        """The settings of the remote site."""
        cameras = ",".join(f'{{name="{name}",source="played"}}' for name in PLAYED)
        links = f"links.control={self.control}", f"links.video={self.video}", f'links.operators=["{OPERATOR}"]'
        return *self._cell("remote"), *links, "driver.name=kinematic", f"video.cameras=[{cameras}]"

    @property
    def watched(self) -> tuple[str, ...]:
        """The settings of a remote site that lets viewers in, beyond `remote`."""
        return f"links.viewers.listen={self.viewers}", *self._certificate("viewers-remote", "links.viewers.tls")

    @property
    def local(self) -> tuple[str, ...]:
        """The settings of the local site, whose hand is scripted."""
        links = f"links.remote={self.control}", f"links.listen={self.listen}"
        return *self._cell(f"operator.{OPERATOR}"), *links, "tracking.method=markers", f"authority.operator={OPERATOR}"

    @property
    def console(self) -> tuple[str, ...]:
        """The settings of the console."""
        links = f"links.control={self.control}", f"links.video={self.video}", f"links.local={self.listen}"
        return *self._cell(f"operator.{OPERATOR}"), *links, f"operator={OPERATOR}", f"serve.port={self.page_port}"

    def _cell(self, who: str) -> tuple[str, ...]:
        return f"cell={CELL}", *self._certificate(who, "links.tls")

    def _certificate(self, who: str, table: str) -> tuple[str, ...]:
        shown = msgspec.structs.asdict(self._tls(who))
        return tuple(f"{table}.{key}={value}" for key, value in shown.items())

    def _tls(self, who: str) -> TlsConfig:
        pair, authority = self.folder / CELL / who, "viewers-ca" if who.startswith("viewer") else "ca"
        return TlsConfig(ca=str(self.folder / f"{authority}.pem"), certificate=f"{pair}.pem", key=f"{pair}.key")
