"""A site's certificate: whether it is valid, and which identity it has, found by a TLS handshake with itself."""

import ssl
from collections.abc import Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import Any

from common.errors import ConfigError, TransportError
from common.link.config import LinkSecurity, TlsConfig, ViewersConfig
from common.link.endpoints import check_endpoint
from common.link.roles import Identity, Role, read_common_name

RENEW = "where the authority is kept: farhand certificates renew CELL"
VERDICTS = {  # by OpenSSL's verification code, X509_V_ERR_*
    2: "comes from another authority",
    7: "comes from another authority of the same name",
    9: "is not valid yet: are the clocks of both hosts right?",
    10: f"has expired; renew it {RENEW}",
    18: "comes from another authority",
    19: "comes from another authority",
    20: "comes from another authority",
    21: "comes from another authority",
    26: "is not made for this use",
    62: f"is for other hosts; renew it with this one {RENEW} --host NAME",
    64: f"is for other hosts; renew it with this one {RENEW} --host ADDRESS",
}
TABLE = "links.tls"
MISSING = (
    "correct the path, or make the certificates on the host that keeps the authority, and copy ca.pem and the pair "
    "here: farhand certificates create CELL, and for a router then farhand certificates router CELL"
)
UNREAD = "let this user read it, or be the service's: sudo -u farhand farhand ..."
UNLOCK = "is locked with a password, and no service can type one; write it without: openssl pkey -in KEY -out NEW"
HANDSHAKE_ROUNDS = 8  # more than any TLS handshake takes


@dataclass(frozen=True, slots=True)
class Credentials:
    """The files of a certificate that was valid when they were loaded, and its identity."""

    tls: TlsConfig
    identity: Identity


def load_credentials(tls: TlsConfig, table: str = TABLE) -> Credentials:
    """Load the credentials, checked by a TLS handshake with themselves; TransportError names the invalid file and why.

    `table` is the configuration's that names the files.
    """
    for what, path in (("ca", tls.ca), ("certificate", tls.certificate), ("key", tls.key)):
        try:
            Path(path).read_bytes()
        except OSError as error:
            cure = UNREAD if isinstance(error, PermissionError) else MISSING
            raise TransportError(f"{table}.{what}: cannot read {path}: {error.strerror}; {cure}") from error
    if is_locked(tls.key):
        raise TransportError(f"{table}.key: {tls.key} {UNLOCK}")
    try:
        certificate = _shake_hands(*_own_contexts(tls))
    except ssl.SSLCertVerificationError as error:
        raise TransportError(f"{table}.certificate: {tls.certificate} {verdict(error)}") from error
    except ssl.SSLError as error:
        raise TransportError(f"{table}: {_unusable(error, tls)}") from error
    named = common_name(certificate)
    identity = read_common_name(named)
    if identity is None:
        raise TransportError(f"{table}.certificate: {tls.certificate} names {named!r}, which {_why_no_identity(named)}")
    return Credentials(tls, identity)


def is_locked(key: str) -> bool:
    """Tell whether a key file (PEM) needs a password: OpenSSL would ask for it at the terminal, and wait for ever."""
    return b"ENCRYPTED" in Path(key).read_bytes()


def _why_no_identity(named: str) -> str:
    """Say why a common name is no identity, as the end of a sentence."""
    role, _, cell = named.partition(".")
    if named == Role.ROUTER:
        return (
            "does not tell cells apart; make one for this cell, where the authority is kept: farhand certificates "
            "router CELL"
        )
    if role == Role.OPERATOR and "." not in cell:
        return (
            "does not tell operators apart; make one for each, where the authority is kept: farhand certificates "
            f"operator {cell or 'CELL'} NAME"
        )
    return "is no role at a cell; make one with: farhand certificates create CELL"


def check_links(endpoints: Sequence[str], security: LinkSecurity, *bearers: Identity, table: str = TABLE) -> None:
    """Raise ConfigError when an endpoint is not allowed, or the certificate is invalid or of none of `bearers`."""
    try:
        for endpoint in endpoints:
            check_endpoint(endpoint, security)
        bearer = load_credentials(security.tls, table).identity if security.tls.is_given else None
    except TransportError as error:
        raise ConfigError(str(error)) from error
    if bearer is None or bearer in bearers:
        return
    names = " or ".join(identity.common_name for identity in bearers)
    mismatch = f"{table}.certificate: {security.tls.certificate} is for {bearer.common_name}, not for {names}"
    raise ConfigError(mismatch + _cure(bearer, bearers))


def check_viewers(viewers: ViewersConfig, site: TlsConfig, bearer: Identity, table: str) -> None:
    """Raise ConfigError when the viewers' endpoint is not allowed, or the site's others trust the viewers' authority.

    `table` is the configuration's that names the viewers' certificates.
    """
    if not viewers.listen:
        return
    check_links((viewers.listen,), viewers.security, bearer, table=table)
    if site.is_given and _authorities(viewers.tls) & _authorities(site):
        raise ConfigError(
            f"{table}.ca: {viewers.tls.ca} is the authority of the site's own endpoints too, so viewers could take "
            "all sessions there and keep a stop out; viewers need one of their own: viewers-ca.pem, which 'farhand "
            f"certificates renew {bearer.cell}' makes where there is none"
        )


def _authorities(tls: TlsConfig) -> set[bytes]:
    """The authorities that are trusted, as DER."""
    return set(client_context(tls).get_ca_certs(binary_form=True))


def _cure(bearer: Identity, wanted: Sequence[Identity]) -> str:
    """Say what to change where a certificate of the right role is for another cell or operator, else nothing."""
    same = next((identity for identity in wanted if identity.role is bearer.role), None)
    if same is None:
        return ""
    if same.cell != bearer.cell:
        return f'; set cell = "{bearer.cell}" if this site belongs to that cell'
    return f'; set operator = "{bearer.operator}" if {bearer.operator} operates here'


class CertificateValidity:
    """The validity of the certificate that a site started with: an open link may outlive it."""

    def __init__(self, tls: TlsConfig, table: str = TABLE) -> None:
        self._tls, self._table = tls, table
        self._contexts = _own_contexts(tls) if tls.is_given else None

    def check(self) -> None:
        """Raise TransportError once the certificate has expired; takes about 2 ms."""
        if self._contexts is None:
            return
        try:
            _shake_hands(*self._contexts)
        except ssl.SSLCertVerificationError as error:
            raise TransportError(f"{self._table}.certificate: {self._tls.certificate} {verdict(error)}") from error


def client_context(tls: TlsConfig) -> ssl.SSLContext:
    """Make a client's TLS context; it accepts only a server with a certificate of the same authority."""
    context = ssl.SSLContext(ssl.PROTOCOL_TLS_CLIENT)
    context.load_verify_locations(cafile=tls.ca)
    context.load_cert_chain(tls.certificate, tls.key)
    return context


def common_name(certificate: Any) -> str:
    """Return the common name of a certificate, as from `ssl.SSLSocket.getpeercert`; empty if it has none."""
    subject = (certificate or {}).get("subject", ())
    return next((value for group in subject for name, value in group if name == "commonName"), "")


def verdict(error: ssl.SSLCertVerificationError) -> str:
    """Describe what is wrong with a certificate, as the end of a sentence."""
    return VERDICTS.get(error.verify_code, f"is refused: {error.verify_message}")


def _own_contexts(tls: TlsConfig) -> tuple[ssl.SSLContext, ssl.SSLContext]:
    """Client and server of a handshake with itself, in which the server judges: not every certificate is a server's."""
    client = client_context(tls)
    client.check_hostname, client.verify_mode = False, ssl.CERT_NONE
    server = ssl.SSLContext(ssl.PROTOCOL_TLS_SERVER)
    server.verify_mode = ssl.CERT_REQUIRED
    server.load_verify_locations(cafile=tls.ca)
    server.load_cert_chain(tls.certificate, tls.key)
    return client, server


def _shake_hands(client_side: ssl.SSLContext, server_side: ssl.SSLContext) -> Any:
    """The client's certificate as `getpeercert` returns it, after a handshake in memory; SSLError when it fails."""
    to_server, to_client = ssl.MemoryBIO(), ssl.MemoryBIO()
    client = client_side.wrap_bio(to_client, to_server)
    server = server_side.wrap_bio(to_server, to_client, server_side=True)
    done: set[ssl.SSLObject] = set()
    for _ in range(HANDSHAKE_ROUNDS):
        for side in (client, server):
            try:
                side.do_handshake()
                done.add(side)
            except ssl.SSLWantReadError:
                continue
        if len(done) == 2:
            break
    return server.getpeercert()


def _unusable(error: ssl.SSLError, tls: TlsConfig) -> str:
    if error.reason == "KEY_VALUES_MISMATCH":
        return f"{tls.key} is not the key of {tls.certificate}"
    return f"{tls.ca}, {tls.certificate} and {tls.key} cannot be used: {error.reason or error}; are they PEM files?"
