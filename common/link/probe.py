"""Why an endpoint refuses a session, or lets in no QUIC: Zenoh does not report it, so a TLS handshake finds out."""

import socket
import ssl
import time
from collections.abc import Callable

from common.link.credentials import Credentials, client_context, common_name, verdict
from common.link.endpoints import Endpoint
from common.link.roles import LISTENERS, Identity, Role, read_common_name

TIMEOUT_S = 0.9
# Zenoh closes the connection on an empty message; within TLS that shows that it has accepted our certificate.
EMPTY_MESSAGE = bytes(8)
TLS_ALERT = b"\x15"  # the content type of a TLS record (RFC 8446, section 5.1)
VIEWERS_CURE = (
    "viewers connect to links.viewers there (of a router: viewers), with certificates of the viewers' authority"
)
ALERTS = {  # by the end of OpenSSL's reason
    "CERTIFICATE_REQUIRED": "asks for a certificate",
    "CERTIFICATE_EXPIRED": "reports that it has expired; renew it where the authority is kept: farhand certificates "
    "renew CELL",
    "UNKNOWN_CA": "reports that it comes from another authority",
    "DECRYPT_ERROR": "reports that it comes from another authority of the same name",
    "BAD_CERTIFICATE": "reports that it is invalid: do both sites have certificates of one authority?",
    "CERTIFICATE_UNKNOWN": "reports that it is invalid: do both sites have certificates of one authority?",
    "UNSUPPORTED_CERTIFICATE": "reports that it is not made for this use",
}
QUIC_PATIENCE_S = 3.0  # a site that has just started answers by TLS before it does by QUIC
QUIC_ANSWERS = 20.0  # times as long as TLS took to answer: a lost packet of the handshake costs QUIC a second


def refusal(endpoint: Endpoint, credentials: Credentials | None) -> str | None:
    """Why the listener and this side refuse each other, as a sentence; None when they do not, or no site listens.

    Takes a few round trips, and up to two seconds when the listener does not answer.
    """
    try:
        has_tls = _detect_tls(endpoint)
        if endpoint.is_secured and credentials is not None and has_tls:
            return _tls_refusal(endpoint, credentials)
    except OSError:
        return None  # no site listens, or the listener does not answer
    if endpoint.is_secured and has_tls is False:
        return f"{endpoint} does not speak TLS: the listener there has no protection; nothing is sent to it"
    if not endpoint.is_secured and has_tls:
        return (
            f"{endpoint} refuses plain tcp: the listener there speaks TLS only; write the endpoint as "
            f"tls/{endpoint.address} and name certificates in the table [links.tls]"
        )
    return None


def speaks_tls(endpoint: Endpoint) -> bool:
    """Return whether the listener at the endpoint speaks TLS, False if no site listens."""
    try:
        return _detect_tls(endpoint) is True
    except OSError:
        return False


def identity_refusal(listener_name: str, endpoint: str, own: Identity) -> str | None:
    """Why a listener whose certificate has this common name is wrong; None for a site or the router of our cell.

    Of local sites an operator's own alone is right.
    """
    identity = read_common_name(listener_name)
    if (
        identity is not None
        and identity.cell == own.cell
        and identity.role in LISTENERS
        and identity.operator in (None, own.operator)
    ):
        return None
    return (
        f"{endpoint} is not the remote site of cell {own.cell}: the listener there shows the certificate of "
        f"{listener_name or 'nobody'}; nothing is sent to it. Is the endpoint right, or does somebody impersonate that "
        "site?"
    )


def _detect_tls(endpoint: Endpoint) -> bool | None:
    """Return whether the listener answers invalid bytes with a TLS alert; None when it hangs up without an answer.

    OSError when no site listens, or no answer comes in time.
    """
    with socket.create_connection((endpoint.host, endpoint.port), TIMEOUT_S) as connection:
        connection.sendall(EMPTY_MESSAGE)
        first = connection.recv(1)
    return first == TLS_ALERT if first else None


def _tls_refusal(endpoint: Endpoint, credentials: Credentials) -> str | None:
    context = client_context(credentials.tls)
    try:
        with (
            socket.create_connection((endpoint.host, endpoint.port), TIMEOUT_S) as connection,
            context.wrap_socket(connection, server_hostname=endpoint.host) as secured,
        ):
            listener_name = common_name(secured.getpeercert())
            why = identity_refusal(listener_name, str(endpoint), credentials.identity)
            if why is not None:
                return why
            secured.sendall(EMPTY_MESSAGE)
            secured.recv(1)
    except ssl.SSLCertVerificationError as error:
        why = f"{endpoint} is refused: the certificate shown there {verdict(error)}"
        return f"{why}; {VIEWERS_CURE}" if credentials.identity.role is Role.VIEWER else why
    except ssl.SSLError as error:
        return _alert_refusal(error.reason or "", endpoint, credentials)
    return None


def _alert_refusal(reason: str, endpoint: Endpoint, credentials: Credentials) -> str | None:
    """Why the listener refuses our certificate, from its TLS alert; None for a connection that merely broke."""
    if "ALERT" not in reason:
        return None
    why = next((sentence for name, sentence in ALERTS.items() if reason.endswith(name)), f"reports {reason}")
    refused = f"{endpoint} refuses the certificate {credentials.tls.certificate}: it {why}"
    return f"{refused}; {VIEWERS_CURE}" if credentials.identity.role is Role.VIEWER else refused


def blocked_sentence(endpoint: Endpoint, *, was_up: bool) -> str:
    """Say that QUIC is blocked where TLS comes through, as by a firewall that lets no UDP pass, and the cure."""
    no = "no longer" if was_up else "not"
    return (
        f"{endpoint} answers by TLS, but {no} by QUIC: let UDP through to port {endpoint.port}, or write the "
        f"endpoint as tls/{endpoint.address} at both sites"
    )


class QuicBlockageDetector:
    """Becomes certain about one link's endpoint that answers by TLS for QUIC_PATIENCE_S but never by QUIC.

    Over a long way it takes longer, QUIC_ANSWERS times as long as an answer by TLS.
    """

    def __init__(self) -> None:
        self._tls_answers_since_s: float | None = None

    def blocked(
        self,
        endpoint: Endpoint,
        *,
        was_up: bool,
        speaks_tls: Callable[[Endpoint], bool] = speaks_tls,
        now_s: Callable[[], float] = time.monotonic,
    ) -> str | None:
        """Why the endpoint is blocked, None while it may still answer.

        A link that was up before comes back after an outage, so it is not counted as blocked.
        """
        asked_s = now_s()
        if not endpoint.is_quic or was_up or not speaks_tls(endpoint):
            self._tls_answers_since_s = None
            return None
        answered_s = now_s()
        if self._tls_answers_since_s is None:
            self._tls_answers_since_s = answered_s
        patience_s = max(QUIC_PATIENCE_S, QUIC_ANSWERS * (answered_s - asked_s))
        return None if answered_s - self._tls_answers_since_s < patience_s else blocked_sentence(endpoint, was_up=False)
