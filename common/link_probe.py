"""Why nobody answers at an endpoint: a zenoh session opens in silence, so a handshake of our own finds it out."""

import socket
import ssl

from common.credentials import Credentials, client_context, common_name, verdict
from common.endpoints import Endpoint
from common.roles import Identity, Role, read_common_name

TIMEOUT_S = 0.9
NO_MESSAGE = b"\0\0"  # zenoh hangs up on an empty message, once it has accepted our certificate
LISTENERS = (Role.REMOTE, Role.OPERATOR, Role.ROUTER)
ALERTS = {
    "CERTIFICATE_REQUIRED": "asks for a certificate",
    "CERTIFICATE_EXPIRED": "says that it has expired; renew it where the authority is kept: farhand certificates "
    "renew CELL",
    "UNKNOWN_CA": "says that it comes from another authority",
    "DECRYPT_ERROR": "says that it comes from another authority of the same name",
    "BAD_CERTIFICATE": "says that it is no good: do both sites have certificates of one authority?",
    "CERTIFICATE_UNKNOWN": "says that it is no good: do both sites have certificates of one authority?",
    "UNSUPPORTED_CERTIFICATE": "says that it is not made for this use",
}


def refusal(endpoint: Endpoint, credentials: Credentials | None) -> str | None:
    """A sentence on why whoever listens there and this side refuse each other; None when they do not, or nobody does.

    Takes a few milliseconds, at most some two seconds where the other side says nothing.
    """
    try:
        with socket.create_connection((endpoint.host, endpoint.port), TIMEOUT_S) as wire:
            if endpoint.is_tls and credentials is not None:
                return _tls_refusal(wire, endpoint, credentials)
            return _plain_refusal(wire, endpoint)
    except OSError:
        return None  # nobody is there: that is no refusal


def identity_refusal(shown: str, endpoint: str, own: Identity) -> str | None:
    """Why who listens under this common name is not who should; None for a site of our cell, and for a router."""
    identity = read_common_name(shown)
    if identity is not None and identity.role in LISTENERS and identity.cell in (own.cell, None):
        return None
    whose = f"the remote site of cell {own.cell}" if own.cell else "a site"
    return (
        f"{endpoint} is not {whose}: who listens there shows the certificate of {shown or 'nobody'}; nothing is sent "
        "to it. Is the endpoint right, or does somebody pass for that site?"
    )


def _tls_refusal(wire: socket.socket, endpoint: Endpoint, credentials: Credentials) -> str | None:
    context = client_context(credentials.tls)
    try:
        with context.wrap_socket(wire, server_hostname=endpoint.host) as secured:
            shown = common_name(secured.getpeercert())
            impostor = identity_refusal(shown, str(endpoint), credentials.identity)
            if impostor is not None:
                return impostor
            secured.sendall(NO_MESSAGE)
            secured.recv(1)
    except ssl.SSLCertVerificationError as error:
        return f"{endpoint} is refused: the certificate shown there {verdict(error)}"
    except ssl.SSLError as error:
        if "ALERT" in (error.reason or ""):
            return _alert(error.reason, endpoint, credentials)
        return _if_plain(endpoint)
    except TimeoutError:
        return _if_plain(endpoint)
    return None


def _alert(reason: str, endpoint: Endpoint, credentials: Credentials) -> str:
    told = next((sentence for name, sentence in ALERTS.items() if reason.endswith(name)), f"says {reason}")
    return f"{endpoint} refuses the certificate {credentials.tls.certificate}: it {told}"


def _if_plain(endpoint: Endpoint) -> str | None:
    """A plain site hangs up on an empty message with a word; whoever is only slow or silent refuses nobody."""
    try:
        with socket.create_connection((endpoint.host, endpoint.port), TIMEOUT_S) as wire:
            wire.sendall(NO_MESSAGE)
            if not wire.recv(1):
                return None
    except OSError:
        return None
    return f"{endpoint} does not speak TLS: who listens there is without protection; nothing is sent to it"


def _plain_refusal(wire: socket.socket, endpoint: Endpoint) -> str | None:
    """A site with certificates answers to TLS alone."""
    context = ssl.SSLContext(ssl.PROTOCOL_TLS_CLIENT)
    context.check_hostname, context.verify_mode = False, ssl.CERT_NONE
    try:
        with context.wrap_socket(wire, server_hostname=endpoint.host):
            pass
    except (OSError, ssl.SSLError) as error:
        if "ALERT" not in (getattr(error, "reason", None) or ""):
            return None
    return (
        f"{endpoint} refuses plain tcp: who listens there speaks TLS only; write the endpoint as "
        f"tls/{str(endpoint).partition('/')[2]} and name certificates in the table [links.tls]"
    )
