"""Tells the remote site by TLS what keeps QUIC from reaching it, so that its log states it too."""

import time

from common.errors import TransportError
from common.link.channels import TROUBLE
from common.link.transport import Link, open_link
from common.messages.requests import TroubleReport

PATIENCE_S = 2.0
ASK_EVERY_S = 0.1


def tell_by_tls(link: Link, cell: str, operator: str, reason: str) -> bool:
    """Whether the remote site was told, at the endpoint of a QUIC link, where it listens for TLS as well."""
    fallback = link.tls_fallback()
    if fallback is None:
        return False
    endpoint, security = fallback
    deadline_s = time.monotonic() + PATIENCE_S
    try:
        with open_link(connect=(str(endpoint),), security=security) as by_tls:
            while time.monotonic() < deadline_s:
                if by_tls.ask(TROUBLE, cell, TroubleReport(reason=reason), operator=operator) is not None:
                    return True
                time.sleep(ASK_EVERY_S)
    except TransportError:
        return False  # it is refused or gone for another reason, which this side reports
    return False
