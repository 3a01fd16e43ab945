"""The folder of an authority: its own certificate and key, and a folder per cell with a pair of files per role."""

import json
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
from common.link.roles import CELL_NAME, MAX_COMMON_NAME, Identity, Role
from farhand.certificates.issuing import Issued, issue, make_authority

LOOPBACK_HOSTS = ("127.0.0.1", "::1", "localhost")
AUTHORITY = "ca"
SITES = Role.REMOTE, Role.VIEWER, Role.MAINTENANCE
PRIVATE, PUBLIC = 0o600, 0o644
OPERATORS_FILE = re.compile(rf"{Role.OPERATOR.value}\.({CELL_NAME.pattern})\.pem")
HOST = re.compile(r"[0-9a-zA-Z.:-]{1,253}")


@dataclass(frozen=True, slots=True)
class CertificateOrder:
    """A request for certificates: the hosts besides loopback under which sites are reached, and days of validity.

    `operators` get one each. ConfigError for an invalid name of a cell, host or operator, before anything is written.
    """

    cell: str
    hosts: tuple[str, ...]
    days: int
    operators: tuple[str, ...] = ()

    def __post_init__(self) -> None:
        check_cell_name(self.cell)
        for operator in self.operators:
            named = Identity(Role.OPERATOR, self.cell, check_cell_name(operator, "operator")).common_name
            if len(named) > MAX_COMMON_NAME:
                raise ConfigError(f"{named} is too long for a certificate: at most {MAX_COMMON_NAME} characters")
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
    theirs.mkdir(mode=0o700, parents=True)
    bearers = [*_sites(order.cell), *(_operator(order.cell, name) for name in order.operators)]
    hosts = tuple(dict.fromkeys((*LOOPBACK_HOSTS, *order.hosts)))
    return sorted(_issue(theirs, authority, bearers, hosts, now, order.days))


def renew(folder: Path, order: CertificateOrder, now: datetime) -> list[Path]:
    """New keys and certificates of the same authority for the same bearers and hosts, and for those in the order."""
    known, theirs = _known_hosts(folder, order), folder / order.cell
    operators = dict.fromkeys((*operators_of(theirs), *order.operators))
    bearers = [*_sites(order.cell), *(_operator(order.cell, name) for name in operators)]
    if _path(theirs, _router(order.cell)).exists():
        bearers.append(_router(order.cell))
    authority = load_authority(folder)
    made = []
    for bearer in bearers:
        path = _path(theirs, bearer)
        hosts = (*hosts_of(read_certificate(path)), *order.hosts) if path.exists() else known
        made += _issue(theirs, authority, [bearer], tuple(dict.fromkeys(hosts)), now, order.days)
    return sorted(made)


def add_operators(folder: Path, order: CertificateOrder, now: datetime) -> list[Path]:
    """Make certificates for further operators of a cell; ConfigError for one who has a certificate."""
    return _add(folder, order, [_operator(order.cell, name) for name in order.operators], now)


def add_router(folder: Path, order: CertificateOrder, now: datetime) -> list[Path]:
    """Make a certificate for the router of a cell; ConfigError when there is one."""
    return _add(folder, order, [_router(order.cell)], now)


def _add(folder: Path, order: CertificateOrder, bearers: Sequence[Identity], now: datetime) -> list[Path]:
    hosts, theirs = _known_hosts(folder, order), folder / order.cell
    for bearer in bearers:
        if _path(theirs, bearer).exists():
            raise ConfigError(
                f"{bearer.operator or bearer.role.value} has a certificate in {theirs}; to make a new one: farhand "
                f"certificates renew {order.cell} --dir {folder}"
            )
    return _issue(theirs, load_authority(folder), bearers, hosts, now, order.days)


def operators_of(theirs: Path) -> list[str]:
    """The operators who have a certificate in a cell's folder."""
    return sorted(match[1] for path in theirs.glob("*.pem") if (match := OPERATORS_FILE.fullmatch(path.name)))


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
    _write(folder / f"{AUTHORITY}.pem", authority)
    return authority


def _issue(
    theirs: Path, authority: Issued, bearers: Sequence[Identity], hosts: Sequence[str], now: datetime, days: int
) -> list[Path]:
    """Make certificates and keys; the paths of the certificates."""
    valid = _valid(authority, now, days)
    for bearer in bearers:
        _write(_path(theirs, bearer), issue(authority, bearer, hosts, now, valid))
    return [_path(theirs, bearer) for bearer in bearers]


def _sites(cell: str) -> list[Identity]:
    """Who has a certificate at every cell."""
    return [Identity(role, cell) for role in SITES]


def _operator(cell: str, name: str) -> Identity:
    return Identity(Role.OPERATOR, cell, name)


def _router(cell: str) -> Identity:
    return Identity(Role.ROUTER, cell)


def _path(theirs: Path, bearer: Identity) -> Path:
    """The certificate's file."""
    name = bearer.role.value if bearer.operator is None else f"{bearer.role.value}.{bearer.operator}"
    return theirs / f"{name}.pem"


def _known_hosts(folder: Path, order: CertificateOrder) -> tuple[str, ...]:
    """The hosts of a cell that has certificates, and those in the order."""
    known = folder / order.cell / f"{Role.REMOTE.value}.pem"
    if not known.exists():
        raise ConfigError(
            f"{known} does not exist; make it first: farhand certificates create {order.cell} --dir {folder}"
        )
    return tuple(dict.fromkeys((*hosts_of(read_certificate(known)), *order.hosts)))


def _valid(authority: Issued, now: datetime, days: int) -> timedelta:
    """The requested days, but not beyond the authority's own end."""
    left = authority.certificate.not_valid_after_utc - now
    if left <= timedelta(0):
        raise ConfigError("the authority has expired: delete its folder and create all certificates again")
    return min(timedelta(days=days), left)


def _write(certificate: Path, issued: Issued) -> None:
    """Write the key first: a certificate is useless without it."""
    write_atomically(certificate.with_suffix(".key"), issued.key_pem, PRIVATE)
    write_atomically(certificate, issued.certificate_pem, PUBLIC)


def guidance(folder: Path, order: CertificateOrder) -> str:
    """What to do with the new files."""
    cell, theirs, names = order.cell, folder / order.cell, order.operators or ("NAME",)
    where = order.hosts[0] if order.hosts else "127.0.0.1"
    made = [*SITES, *(f"operator.{name}" for name in order.operators)]
    return (
        f"made in {theirs}: a certificate and key each for {', '.join(made)}\n"
        f"for every further operator: farhand certificates operator {cell} NAME --dir {folder}\n"
        f"for a router, where the sites cannot reach each other: farhand certificates router {cell} --dir {folder}\n"
        f"keep {folder / AUTHORITY}.key secret: anybody who has it can become an operator\n"
        "give each host ca.pem and its own pair, keys for the service's user only, for the robot's side:\n"
        f'  cell = "{cell}"\n'
        "  [links]\n"
        '  control = "tls/0.0.0.0:7447"\n'
        '  video = "tls/0.0.0.0:7448"\n'
        f"  operators = [{', '.join(json.dumps(name) for name in names)}]\n"
        "  [links.tls]\n"
        f'  ca = "/etc/farhand/{AUTHORITY}.pem"\n'
        '  certificate = "/etc/farhand/remote.pem"\n'
        '  key = "/etc/farhand/remote.key"\n'
        f'and for an operator\'s, with operator.{names[0]}.pem and .key: the same cell, remote = "tls/{where}:7447", '
        f'and in [authority] operator = "{names[0]}"'
    )
