"""The folder of an authority: its own certificate and key, and a folder per cell with a pair of files per role."""

import re
from collections.abc import Sequence
from dataclasses import dataclass
from datetime import datetime, timedelta
from pathlib import Path

from cryptography import x509
from cryptography.hazmat.primitives import serialization
from cryptography.hazmat.primitives.asymmetric import ec

from common.atomic_file import write_atomically
from common.errors import ConfigError
from common.link.channels import check_cell_name
from common.link.roles import Identity, Role
from farhand.certificates.issuing import Issued, issue, make_authority

LOOPBACK_HOSTS = ("127.0.0.1", "::1", "localhost")
AUTHORITY = "ca"
PRIVATE, PUBLIC = 0o600, 0o644
HOST = re.compile(r"[0-9a-zA-Z.:-]{1,253}")


@dataclass(frozen=True, slots=True)
class CertificateOrder:
    """A request for certificates: the hosts besides loopback under which sites are reached, and days of validity.

    ConfigError for an invalid name of a cell or host, before anything is written.
    """

    cell: str
    hosts: tuple[str, ...]
    days: int

    def __post_init__(self) -> None:
        check_cell_name(self.cell)
        for host in self.hosts:
            if HOST.fullmatch(host) is None:
                raise ConfigError(f"--host {host!r}: give a host name or an address, without port")


def create(folder: Path, order: CertificateOrder, now: datetime) -> list[Path]:
    """Make what a cell needs, with the folder's authority, or a new one; ConfigError when the cell has certificates."""
    theirs = folder / order.cell
    if theirs.exists():
        raise ConfigError(
            f"{theirs} exists already and is not changed; to make new certificates for the same sites: farhand "
            f"certificates renew {order.cell} --dir {folder}; to start again, delete {theirs} first"
        )
    authority = load_authority(folder) if (folder / f"{AUTHORITY}.key").exists() else _new_authority(folder, now)
    return _issue_all(folder, authority, order, now)


def renew(folder: Path, order: CertificateOrder, now: datetime) -> list[Path]:
    """New keys and certificates of the same authority for the same hosts, and for those in the order."""
    known = folder / order.cell / f"{Role.REMOTE.value}.pem"
    if not known.exists():
        raise ConfigError(
            f"{known} does not exist; make it first: farhand certificates create {order.cell} --dir {folder}"
        )
    hosts = tuple(dict.fromkeys((*hosts_of(read_certificate(known)), *order.hosts)))
    return _issue_all(folder, load_authority(folder), CertificateOrder(order.cell, hosts, order.days), now)


def load_authority(folder: Path) -> Issued:
    """The authority kept in a folder; ConfigError when its files are missing or do not belong together."""
    certificate, path = read_certificate(folder / f"{AUTHORITY}.pem"), folder / f"{AUTHORITY}.key"
    try:
        key = serialization.load_pem_private_key(path.read_bytes(), password=None)
    except OSError as error:
        raise ConfigError(f"cannot read {path}: {error.strerror}; it stays where the certificates were made") from error
    except (ValueError, TypeError) as error:
        raise ConfigError(f"{path} is not a private key: delete {folder} and create all certificates again") from error
    if not isinstance(key, ec.EllipticCurvePrivateKey) or key.public_key() != certificate.public_key():
        raise ConfigError(f"{path} is not the key of {folder / AUTHORITY}.pem: restore the one that is")
    return Issued(certificate, key)


def read_certificate(path: Path) -> x509.Certificate:
    """The certificate in a PEM file, else ConfigError."""
    try:
        return x509.load_pem_x509_certificate(path.read_bytes())
    except OSError as error:
        raise ConfigError(f"cannot read {path}: {error.strerror}") from error
    except ValueError as error:
        raise ConfigError(f"{path} is not a certificate (PEM)") from error


def hosts_of(certificate: x509.Certificate) -> list[str]:
    """The names and addresses that a certificate is for."""
    names = certificate.extensions.get_extension_for_class(x509.SubjectAlternativeName).value
    return [str(name.value) for name in names]


def _new_authority(folder: Path, now: datetime) -> Issued:
    if (folder / f"{AUTHORITY}.pem").exists():
        raise ConfigError(f"{folder} holds an authority's certificate but not its key: create where the key is kept")
    folder.mkdir(mode=0o700, parents=True, exist_ok=True)
    authority = make_authority("Farhand certificate authority", now)
    _write(folder / AUTHORITY, authority)
    return authority


def _issue_all(folder: Path, authority: Issued, order: CertificateOrder, now: datetime) -> list[Path]:
    hosts = tuple(dict.fromkeys((*LOOPBACK_HOSTS, *order.hosts)))
    theirs = folder / order.cell
    theirs.mkdir(mode=0o700, parents=True, exist_ok=True)
    valid = _valid(authority, now, order.days)
    for role in Role:
        identity = Identity(role, None if role is Role.ROUTER else order.cell)
        _write(theirs / role.value, issue(authority, identity, hosts, now, valid))
    return sorted(theirs.glob("*.pem"))


def _valid(authority: Issued, now: datetime, days: int) -> timedelta:
    """The requested days, but not beyond the authority's own end."""
    left = authority.certificate.not_valid_after_utc - now
    if left <= timedelta(0):
        raise ConfigError("the authority has expired: delete its folder and create all certificates again")
    return min(timedelta(days=days), left)


def _write(stem: Path, issued: Issued) -> None:
    """Write the key first: a certificate is useless without it."""
    write_atomically(stem.with_name(f"{stem.name}.key"), issued.key_pem, PRIVATE)
    write_atomically(stem.with_name(f"{stem.name}.pem"), issued.certificate_pem, PUBLIC)


def guidance(folder: Path, cell: str, hosts: Sequence[str]) -> str:
    """What to do with the new files."""
    theirs = folder / cell
    where = hosts[0] if hosts else "127.0.0.1"
    return (
        f"made in {theirs}: a certificate and key each for {', '.join(role.value for role in Role)}\n"
        f"keep {folder / AUTHORITY}.key secret: anybody who has it can become an operator\n"
        "give each host ca.pem and its own pair, keys for the service's user only, for the robot's side:\n"
        f'  cell = "{cell}"\n'
        "  [links]\n"
        '  control = "tls/0.0.0.0:7447"\n'
        '  video = "tls/0.0.0.0:7448"\n'
        "  [links.tls]\n"
        f'  ca = "/etc/farhand/{AUTHORITY}.pem"\n'
        '  certificate = "/etc/farhand/remote.pem"\n'
        '  key = "/etc/farhand/remote.key"\n'
        f'and for the operator\'s, with operator.pem and operator.key: the same cell, and remote = "tls/{where}:7447"'
    )
