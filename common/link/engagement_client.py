"""Asks the remote site, as operator or maintenance, to stop the arm or for anything else of the engagement."""

from functools import partial

from common.link.channels import ENGAGEMENT, MAINTENANCE, MAINTENANCE_STOP, STOP
from common.link.request_client import RequestClient
from common.messages.requests import EngagementAction, EngagementRequest, Reply


def ask_engagement(client: RequestClient, action: EngagementAction, *, maintenance: bool = False) -> Reply:
    """The remote site's reply to the client's operator, or to `maintenance`; errors as `RequestClient.ask`."""
    if action is EngagementAction.STOP:
        return client.stop(MAINTENANCE_STOP if maintenance else STOP)
    return client.ask(MAINTENANCE if maintenance else ENGAGEMENT, partial(EngagementRequest, action=action))
