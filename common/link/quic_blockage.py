"""QUIC that is blocked on the way where TLS comes through: a firewall that lets no UDP pass."""

import time
from collections.abc import Callable

from common.link.endpoints import Endpoint
from common.link.probe import speaks_tls

QUIC_PATIENCE_S = 3.0  # a site that has just started answers by TLS before it does by QUIC
QUIC_ANSWERS = 20.0  # times as long as TLS took to answer: a lost packet of the handshake costs QUIC a second


def blocked_sentence(endpoint: Endpoint, *, was_up: bool) -> str:
    """Say what is wrong, and the cure."""
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
