"""The certificates of one cell in a folder: how a link shows one, and the settings with which a program does."""

from dataclasses import dataclass
from pathlib import Path

import msgspec

from common.link.config import LinkSecurity, TlsConfig


@dataclass(frozen=True, slots=True)
class CellCertificates:
    """The certificates of a cell, as `farhand certificates` makes them; viewers have an authority of their own."""

    folder: Path
    cell: str

    def security_of(self, who: str) -> LinkSecurity:
        """The security of a link that shows this certificate."""
        return LinkSecurity(tls=self._tls(who))

    def settings_of(self, who: str, table: str = "links.tls") -> tuple[str, ...]:
        """The settings with which a program shows it."""
        return tuple(f"{table}.{key}={value}" for key, value in msgspec.structs.asdict(self._tls(who)).items())

    def _tls(self, who: str) -> TlsConfig:
        pair = self.folder / self.cell / who
        authority = "viewers-ca" if who.startswith("viewer") else "ca"
        return TlsConfig(ca=str(self.folder / f"{authority}.pem"), certificate=f"{pair}.pem", key=f"{pair}.key")
