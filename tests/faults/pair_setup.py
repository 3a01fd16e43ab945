"""What a pair of sites needs before it starts: endpoints, certificates, settings, the environment of its processes."""

import json
import subprocess
from dataclasses import dataclass
from datetime import UTC, datetime
from pathlib import Path

from common.link.config import ON_THIS_HOST, LinkSecurity
from common.link.endpoints import SECURED
from farhand.certificates.folder import CertificateOrder, create
from farhand.loopback.site_process import free_ports
from lab.stage.cell_certificates import CellCertificates
from lab.stage.cell_endpoints import CellEndpoints
from lab.stage.processes import ROOT

A465 = "driver.name=c500c"
CELL, OPERATOR, OTHERS = "faults", "anna", ("ben", "carl")
WALL_CLOCK = Path(__file__).with_name("wall_clock.c")
ENTRY_POINTS = """[farhand.drivers]
recording = tests.faults.recording_driver:RecordingDriver
gripping = tests.faults.gripping_driver:GrippingDriver
recorded_arm = tests.faults.recorded_arm:recorded_arm
"""
VIDEO = 'video.cameras=[{name="side",source="/dev/null-camera"}]'


@dataclass(frozen=True)
class PairSetup:
    """One cell in a folder of its own; `two_hosts` where a network is between its sites.

    Viewers have an endpoint where hand and state go by TLS.
    """

    folder: Path
    two_hosts: bool
    endpoints: CellEndpoints
    viewers: str
    driver_settings: tuple[str, ...]

    @classmethod
    def make(cls, folder: Path, settings: tuple[str, ...], protocol: str, *, two_hosts: bool) -> "PairSetup":
        """Choose free ports, and make the certificates that the protocol needs."""
        if protocol in SECURED:
            create(folder, CertificateOrder(CELL, ("localhost",), 1, (OPERATOR, *OTHERS)), datetime.now(UTC))
        host = "localhost" if two_hosts else "127.0.0.1"
        control, video, listen, watched = free_ports(4)
        places = f"{protocol}/{host}:{control}", f"tcp/{host}:{video}", f"tcp/127.0.0.1:{listen}"
        viewers = f"tls/{host}:{watched}" if protocol == "tls" else ""
        return cls(folder, two_hosts, CellEndpoints(CELL, *places), viewers, _driver(folder, settings))

    @property
    def security(self) -> LinkSecurity:
        """How the test's own link connects: as the operator."""
        return self.security_of(OPERATOR)

    def security_of(self, operator: str) -> LinkSecurity:
        """How an operator's link connects."""
        return self.security_with(f"operator.{operator}")

    def security_with(self, who: str) -> LinkSecurity:
        """How a link connects that shows this certificate, where there are any."""
        return self._certificates.security_of(who) if self._is_secured else ON_THIS_HOST

    @property
    def remote(self) -> tuple[str, ...]:
        """The settings of the remote site."""
        listed = f"links.operators={json.dumps([OPERATOR, *OTHERS])}"
        settings = listed, "engagement.mode=on_request", VIDEO
        viewers = (f"links.viewers.listen={self.viewers}", *self._certificate("viewers-remote", "links.viewers.tls"))
        watched = viewers if self.viewers else ()
        return *self.endpoints.remote, *settings, *self._certificate("remote"), *watched, *self.driver_settings

    @property
    def local(self) -> tuple[str, ...]:
        """The settings of the local site."""
        who = "tracking.method=markers", f"authority.operator={OPERATOR}"
        return *self.endpoints.local, *who, *self._certificate(f"operator.{OPERATOR}")

    def console(self, port: int) -> tuple[str, ...]:
        """The settings of a console whose page is at a port."""
        return *self.endpoints.console, f"operator={OPERATOR}", f"serve.port={port}"

    def environment(self) -> dict[str, str]:
        """Make the environment in which the recording driver is an installed one, and the wall clock can be stepped."""
        package = self.folder / "faults-1.dist-info"
        package.mkdir()
        (package / "METADATA").write_text("Metadata-Version: 2.1\nName: faults\nVersion: 1\n")
        (package / "entry_points.txt").write_text(ENTRY_POINTS)
        wall = self._wall_clock() if self.two_hosts else {}
        return wall | {"PYTHONPATH": f"{self.folder}:{ROOT}", "STATE_DIRECTORY": str(self.folder)}

    @property
    def _is_secured(self) -> bool:
        return self.endpoints.control.partition("/")[0] in SECURED

    @property
    def _certificates(self) -> CellCertificates:
        return CellCertificates(self.folder, CELL)

    def _certificate(self, who: str, table: str = "links.tls") -> tuple[str, ...]:
        """The settings with which a site shows a certificate, where it has to."""
        return self._certificates.settings_of(who, table) if self._is_secured else ()

    def _wall_clock(self) -> dict[str, str]:
        offset, library = self.folder / "wall_offset", self.folder / "wall_clock.so"
        offset.write_bytes(bytes(8))
        compiler = ["cc", "-O2", "-shared", "-fPIC", "-o", str(library), str(WALL_CLOCK), "-ldl"]
        subprocess.run(compiler, check=True)
        return {"LD_PRELOAD": str(library), "FARHAND_WALL_OFFSET": str(offset)}


def _driver(folder: Path, settings: tuple[str, ...]) -> tuple[str, ...]:
    """The recording driver, or the A465's at the line of an emulated controller of its own."""
    if A465 in settings:
        return *settings, f"driver.options.port={folder / 'line'}"
    paths = f"driver.options.record={folder / 'record'}", f"driver.options.orders={folder / 'robot'}"
    return "driver.name=recording", *paths, *settings
