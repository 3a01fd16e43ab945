"""The authorities' folder: a pair of files for each site, operator and listener of a cell, and how to use them."""

import re
from collections.abc import Sequence
from dataclasses import dataclass
from datetime import datetime, timedelta
from pathlib import Path

from cryptography import x509

from common.errors import ConfigError
from common.link.channels import check_cell_name
from common.link.roles import CELL_NAME, MAX_COMMON_NAME, Identity, Role
from common.text import toml_string
from farhand.certificates.authorities import (
    SITES,
    VIEWERS,
    CertificateAuthority,
    ensure_authority,
    load_authority,
    read_certificate,
    write_pair,
)
from farhand.certificates.issuing import Issued, issue

LOOPBACK_HOSTS = ("127.0.0.1", "::1", "localhost")
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


@dataclass(frozen=True, slots=True)
class Pair:
    """A certificate and its key: the stem of both files, whom they name, and the authority that issues them."""

    stem: str
    identity: Identity
    authority: CertificateAuthority = SITES

    def path(self, theirs: Path) -> Path:
        """The certificate's file in a cell's folder."""
        return theirs / f"{self.stem}.pem"


def create(folder: Path, order: CertificateOrder, now: datetime) -> list[Path]:
    """Make what a cell needs, with the folder's authorities or new ones; ConfigError when the cell has certificates."""
    theirs = folder / order.cell
    if theirs.exists():
        raise ConfigError(
            f"{theirs} exists already and is not changed; to make new certificates for the same sites: farhand "
            f"certificates renew {order.cell} --dir {folder}; to start again, delete {theirs} first"
        )
    ensure_authority(folder, SITES, now)
    ensure_authority(folder, VIEWERS, now)
    theirs.mkdir(mode=0o700, parents=True)
    hosts = tuple(dict.fromkeys((*LOOPBACK_HOSTS, *order.hosts)))
    pairs = [*_always(order.cell), *(_operator(order.cell, name) for name in order.operators)]
    return sorted(_issue(folder, pair, hosts, order, now) for pair in pairs)


def guidance(folder: Path, order: CertificateOrder) -> str:
    """Say what to do with the new files."""
    cell, theirs, names = order.cell, folder / order.cell, order.operators or ("NAME",)
    where = order.hosts[0] if order.hosts else "127.0.0.1"
    made = ["remote", "maintenance", *(f"operator.{name}" for name in order.operators), "viewer", "viewers-remote"]
    return (
        f"made in {theirs}: a certificate and key each for {', '.join(made)}\n"
        f"for every further operator: farhand certificates operator {cell} NAME --dir {folder}\n"
        f"for a router, where the sites cannot reach each other: farhand certificates router {cell} --dir {folder}\n"
        f"keep {folder / SITES.stem}.key secret: anybody who has it can become an operator\n"
        "give each host ca.pem and its own pair, keys for the service's user only, for the robot's side:\n"
        f'  cell = "{cell}"\n'
        "  [links]\n"
        '  control = "tls/0.0.0.0:7447"\n'
        '  video = "tls/0.0.0.0:7448"\n'
        f"  operators = [{', '.join(toml_string(name) for name in names)}]\n"
        "  [links.tls]\n"
        f'  ca = "/etc/farhand/{SITES.stem}.pem"\n'
        '  certificate = "/etc/farhand/remote.pem"\n'
        '  key = "/etc/farhand/remote.key"\n'
        "where others are to watch, it needs the viewers' authority too, and a pair of that for their listener:\n"
        "  [links.viewers]\n"
        '  listen = "tls/0.0.0.0:7449"\n'
        "  [links.viewers.tls]\n"
        f'  ca = "/etc/farhand/{VIEWERS.stem}.pem"\n'
        '  certificate = "/etc/farhand/viewers-remote.pem"\n'
        '  key = "/etc/farhand/viewers-remote.key"\n'
        f"a host that only watches has {VIEWERS.stem}.pem, viewer.pem and viewer.key, and that endpoint for "
        "control and video\n"
        f'and for an operator\'s, with operator.{names[0]}.pem and .key: the same cell, remote = "tls/{where}:7447", '
        f'and in [authority] operator = "{names[0]}"'
    )


def renew(folder: Path, order: CertificateOrder, now: datetime) -> list[Path]:
    """New keys and certificates of the same authorities for the same bearers and hosts, and for those in the order.

    Where a folder has no authority for viewers, it is made.
    """
    known, theirs = _known_hosts(folder, order), folder / order.cell
    load_authority(folder)
    ensure_authority(folder, VIEWERS, now)
    operators = dict.fromkeys((*operators_of(theirs), *order.operators))
    pairs = [*_always(order.cell), *(_operator(order.cell, name) for name in operators)]
    router, viewers_router = _router(order.cell)
    if router.path(theirs).exists():
        pairs += [router, viewers_router]
    made = []
    for pair in pairs:
        there = next((path for path in (pair.path(theirs), _beside(pair, theirs)) if path.exists()), None)
        hosts = (*hosts_of(read_certificate(there)), *order.hosts) if there is not None else known
        made.append(_issue(folder, pair, tuple(dict.fromkeys(hosts)), order, now))
    return sorted(made)


def add_operators(folder: Path, order: CertificateOrder, now: datetime) -> list[Path]:
    """Make certificates for further operators of a cell; ConfigError for one who has a certificate."""
    return _add(folder, order, [_operator(order.cell, name) for name in order.operators], now)


def add_router(folder: Path, order: CertificateOrder, now: datetime) -> list[Path]:
    """Make certificates for the router of a cell and its viewers' listener; ConfigError when there are some."""
    return _add(folder, order, _router(order.cell), now)


def _add(folder: Path, order: CertificateOrder, pairs: Sequence[Pair], now: datetime) -> list[Path]:
    hosts, theirs = _known_hosts(folder, order), folder / order.cell
    for pair in pairs:
        if pair.path(theirs).exists():
            raise ConfigError(
                f"{pair.identity.operator or pair.stem} has a certificate in {theirs}; to make a new one: farhand "
                f"certificates renew {order.cell} --dir {folder}"
            )
    for authority in {pair.authority for pair in pairs} - {SITES}:
        ensure_authority(folder, authority, now)
    return [_issue(folder, pair, hosts, order, now) for pair in pairs]


def operators_of(theirs: Path) -> list[str]:
    """The operators who have a certificate in a cell's folder."""
    return sorted(match[1] for path in theirs.glob("*.pem") if (match := OPERATORS_FILE.fullmatch(path.name)))


def hosts_of(certificate: x509.Certificate) -> list[str]:
    """The names and addresses that a certificate is for."""
    names = certificate.extensions.get_extension_for_class(x509.SubjectAlternativeName).value
    return [str(name.value) for name in names]


def _issue(folder: Path, pair: Pair, hosts: Sequence[str], order: CertificateOrder, now: datetime) -> Path:
    """Make a certificate and its key; the path of the certificate."""
    authority, path = load_authority(folder, pair.authority), pair.path(folder / order.cell)
    write_pair(path, issue(authority, pair.identity, hosts, now, _valid(authority, now, order.days)))
    return path


def _always(cell: str) -> list[Pair]:
    """List the pairs of every cell: viewers, and the listener that they connect to, have an authority of their own."""
    return [
        Pair("remote", Identity(Role.REMOTE, cell)),
        Pair("maintenance", Identity(Role.MAINTENANCE, cell)),
        Pair("viewer", Identity(Role.VIEWER, cell), VIEWERS),
        Pair("viewers-remote", Identity(Role.REMOTE, cell), VIEWERS),
    ]


def _operator(cell: str, name: str) -> Pair:
    return Pair(f"{Role.OPERATOR.value}.{name}", Identity(Role.OPERATOR, cell, name))


def _router(cell: str) -> tuple[Pair, Pair]:
    router = Identity(Role.ROUTER, cell)
    return Pair("router", router), Pair("viewers-router", router, VIEWERS)


def _beside(pair: Pair, theirs: Path) -> Path:
    """The certificate of the same site at its other endpoints, whose hosts a viewers' listener has too."""
    return theirs / f"{pair.identity.role.value}.pem"


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
