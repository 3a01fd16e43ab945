"""Why no site answers at an endpoint: Zenoh does not report why a session fails; a handshake of our own finds out."""

import socket
import ssl

from common.link.credentials import Credentials, client_context, common_name, verdict
from common.link.endpoints import Endpoint
from common.link.roles import Identity, Role, read_common_name

TIMEOUT_S = 0.9
NO_MESSAGE = bytes(8)  # zenoh hangs up on an empty message; within TLS, once it has accepted our certificate
TLS_ALERT = b"\x15"
LISTENERS = (Role.REMOTE, Role.OPERATOR, Role.ROUTER)
ALERTS = {
    "CERTIFICATE_REQUIRED": "asks for a certificate",
    "CERTIFICATE_EXPIRED": "reports that it has expired; renew it where the authority is kept: farhand certificates "
    "renew CELL",
    "UNKNOWN_CA": "reports that it comes from another authority",
    "DECRYPT_ERROR": "reports that it comes from another authority of the same name",
    "BAD_CERTIFICATE": "reports that it is invalid: do both sites have certificates of one authority?",
    "CERTIFICATE_UNKNOWN": "reports that it is invalid: do both sites have certificates of one authority?",
    "UNSUPPORTED_CERTIFICATE": "reports that it is not made for this use",
}


def refusal(endpoint: Endpoint, credentials: Credentials | None) -> str | None:
    """Why the listener and this side refuse each other, a sentence; None when they do not, or no site listens.

    Takes a few round trips, up to two seconds when the listener is silent.
    """
    try:
        has_tls = _speaks_tls(endpoint)
        if endpoint.is_secured and credentials is not None and has_tls:
            return _tls_refusal(endpoint, credentials)
    except OSError:
        return None  # nothing listens there, or the listener is silent
    if endpoint.is_secured and has_tls is False:
        return f"{endpoint} does not speak TLS: the listener there has no protection; nothing is sent to it"
    if not endpoint.is_secured and has_tls:
        return (
            f"{endpoint} refuses plain tcp: the listener there speaks TLS only; write the endpoint as "
            f"tls/{endpoint.address} and name certificates in the table [links.tls]"
        )
    return None


def speaks_tls(endpoint: Endpoint) -> bool:
    """Whether a listener at the port speaks TLS."""
    try:
        return _speaks_tls(endpoint) is True
    except OSError:
        return False


def identity_refusal(shown: str, endpoint: str, own: Identity) -> str | None:
    """Why a listener with this common name is the wrong one; None for a site of our cell, and for a router."""
    identity = read_common_name(shown)
    if identity is not None and identity.role in LISTENERS and identity.cell in (own.cell, None):
        return None
    whose = f"the remote site of cell {own.cell}" if own.cell else "a site"
    return (
        f"{endpoint} is not {whose}: the listener there shows the certificate of {shown or 'nobody'}; nothing is sent "
        "to it. Is the endpoint right, or does somebody impersonate that site?"
    )


def _speaks_tls(endpoint: Endpoint) -> bool | None:
    """Whether a site takes meaningless bytes for broken TLS or for a broken plain message; None when it is silent."""
    with socket.create_connection((endpoint.host, endpoint.port), TIMEOUT_S) as connection:
        connection.sendall(NO_MESSAGE)
        first = connection.recv(1)
    return first == TLS_ALERT if first else None


def _tls_refusal(endpoint: Endpoint, credentials: Credentials) -> str | None:
    context = client_context(credentials.tls)
    try:
        with (
            socket.create_connection((endpoint.host, endpoint.port), TIMEOUT_S) as connection,
            context.wrap_socket(connection, server_hostname=endpoint.host) as secured,
        ):
            shown = common_name(secured.getpeercert())
            impostor = identity_refusal(shown, str(endpoint), credentials.identity)
            if impostor is not None:
                return impostor
            secured.sendall(NO_MESSAGE)
            secured.recv(1)
    except ssl.SSLCertVerificationError as error:
        return f"{endpoint} is refused: the certificate shown there {verdict(error)}"
    except ssl.SSLError as error:
        return _alert(error.reason or "", endpoint, credentials)
    return None


def _alert(reason: str, endpoint: Endpoint, credentials: Credentials) -> str | None:
    """What the other side's TLS alert means for our certificate; a broken connection is no refusal."""
    if "ALERT" not in reason:
        return None
    why = next((sentence for name, sentence in ALERTS.items() if reason.endswith(name)), f"reports {reason}")
    return f"{endpoint} refuses the certificate {credentials.tls.certificate}: it {why}"
