"""Asks the remote site to let the arm follow the hand."""

import secrets
import time

from common.channels import ENGAGE, check_cell_name
from common.clock import NS_PER_S
from common.errors import TransportError
from common.messages import Reply, Request
from common.transport import Link, open_link

PATIENCE_NS = 3 * NS_PER_S
SETTLE_S = 0.3
AWAKE_AGAIN = "activated"


def request_engage(cell: str, endpoint: str) -> str:
    """What the remote site answers; TransportError when it refuses or does not answer."""
    check_cell_name(cell)
    with open_link(connect=(endpoint,)) as link:
        reply = _ask(link, cell)
        if reply.code == AWAKE_AGAIN:
            time.sleep(SETTLE_S)
            reply = _ask(link, cell)
    if not reply.done:
        raise TransportError(f"not engaged ({reply.code}): {reply.reason}")
    return f"engaged: {reply.reason}"


def _ask(link: Link, cell: str) -> Reply:
    request = Request(id=secrets.randbits(62), deadline_ns=time.monotonic_ns() + PATIENCE_NS)
    return link.request(ENGAGE, cell, request)
