"""Asks the remote site to let the arm follow the hand, and, for maintenance, to stop or reset it."""

import time

from common.errors import TransportError
from common.link.channels import ENGAGEMENT, MAINTENANCE, check_cell_name
from common.link.config import ON_THIS_HOST, LinkSecurity
from common.link.transport import Link, open_link
from common.messages.requests import EngagementAction, EngagementRequest, Reply
from farhand.commands.asking import ask_remote
from local_site.authority.config import host_operator

SETTLE_S = 0.3
AWAKE_AGAIN = "activated"


def request_engage(cell: str, endpoint: str, operator: str = "", security: LinkSecurity = ON_THIS_HOST) -> str:
    """What the remote site answers to an operator (this host's by default); TransportError when it refuses."""
    check_cell_name(cell)
    name = check_cell_name(operator or host_operator(), "operator")
    with open_link(connect=(endpoint,), security=security) as link:
        reply = _ask(link, cell, name)
        if reply.code == AWAKE_AGAIN:
            time.sleep(SETTLE_S)
            reply = _ask(link, cell, name)
    if not reply.done:
        raise TransportError(f"not engaged ({reply.code}): {reply.reason}")
    return f"engaged: {reply.reason}"


def request_maintenance(
    cell: str, endpoint: str, action: EngagementAction, name: str, security: LinkSecurity = ON_THIS_HOST
) -> str:
    """What the remote site answers to somebody of the maintenance; TransportError when it refuses."""

    def request(number: int, deadline_ns: int) -> EngagementRequest:
        return EngagementRequest(id=number, deadline_ns=deadline_ns, operator=name, action=action)

    with open_link(connect=(endpoint,), security=security) as link:
        reply = ask_remote(link, check_cell_name(cell), MAINTENANCE, request)
    if not reply.done:
        raise TransportError(f"refused ({reply.code}): {reply.reason}")
    return reply.reason


def _ask(link: Link, cell: str, operator: str) -> Reply:
    def request(number: int, deadline_ns: int) -> EngagementRequest:
        action = EngagementAction.ENGAGE
        return EngagementRequest(id=number, deadline_ns=deadline_ns, operator=operator, action=action)

    return ask_remote(link, cell, ENGAGEMENT, request)
