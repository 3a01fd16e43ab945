"""Asks the remote site to let the arm follow the hand, and, for maintenance, to stop or reset it."""

from common.errors import TransportError
from common.link.channels import check_cell_name
from common.link.config import ON_THIS_HOST, LinkSecurity
from common.link.engagement_client import ask_engagement
from common.link.remote_clock import RemoteClock
from common.link.request_client import RequestClient
from common.messages.requests import EngagementAction
from farhand.authority.asking import link_to
from local_site.authority.config import host_operator


def request_engage(cell: str, endpoint: str, operator: str = "", security: LinkSecurity = ON_THIS_HOST) -> str:
    """The remote site's reply to an operator (this host's by default); TransportError when it refuses."""
    name = check_cell_name(operator or host_operator(), "operator")
    with link_to(cell, endpoint, security=security) as link:
        client = RequestClient(link, cell, RemoteClock(link, cell), operator=name)
        reply = ask_engagement(client, EngagementAction.ENGAGE)
    if not reply.done:
        raise TransportError(f"not engaged ({reply.code}): {reply.reason}")
    return f"engaged: {reply.reason}"


def request_maintenance(
    cell: str, endpoint: str, action: EngagementAction, security: LinkSecurity = ON_THIS_HOST
) -> str:
    """The remote site's reply to a maintenance request; TransportError when it refuses."""
    with link_to(cell, endpoint, security=security) as link:
        reply = ask_engagement(RequestClient(link, cell, RemoteClock(link, cell)), action, maintenance=True)
    if not reply.done:
        raise TransportError(f"refused ({reply.code}): {reply.reason}")
    return reply.reason
